// SPDX-License-Identifier: MIT
#include "apps/studio/addresses.h"

#include <algorithm>
#include <cstdint>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace kibori::studio {
namespace {

bool is_private(const in_addr& address) {
  const uint32_t a = ntohl(address.s_addr);
  return (a >> 24) == 10 || (a >> 20) == 0xac1 || (a >> 16) == 0xc0a8;
}

std::string text_of_address(int family, const void* address) {
  char text[INET6_ADDRSTRLEN] = {};
  return inet_ntop(family, address, text, sizeof text) ? text : "";
}

// Returns the address from which packets leave this machine. Empty: there is no route. Sends
// nothing, because connect() of a UDP socket only chooses the route.
std::string outgoing_address() {
  const int handle = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (handle < 0) return {};
  sockaddr_in peer{}, own{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(9);
  inet_pton(AF_INET, "192.0.2.1", &peer.sin_addr);  // an address for documentation (RFC 5737)
  socklen_t size = sizeof own;
  const bool found = connect(handle, reinterpret_cast<sockaddr*>(&peer), sizeof peer) == 0 &&
                     getsockname(handle, reinterpret_cast<sockaddr*>(&own), &size) == 0;
  close(handle);
  return found ? text_of_address(AF_INET, &own.sin_addr) : "";
}

}  // namespace

std::vector<std::string> private_addresses() {
  std::vector<std::string> found;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return found;
  for (const ifaddrs* one = all; one; one = one->ifa_next) {
    if (!one->ifa_addr || one->ifa_addr->sa_family != AF_INET || !(one->ifa_flags & IFF_UP))
      continue;
    const in_addr& address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr)->sin_addr;
    if (is_private(address)) found.push_back(text_of_address(AF_INET, &address));
  }
  freeifaddrs(all);
  const std::string first = outgoing_address();
  std::stable_partition(found.begin(), found.end(),
                        [&](const std::string& address) { return address == first; });
  return found;
}

Result<std::string> canonical_address(const std::string& text) {
  const std::string plain = text.size() > 2 && text.front() == '[' && text.back() == ']'
                                ? text.substr(1, text.size() - 2)
                                : text;
  in_addr v4{};
  in6_addr v6{};
  if (inet_pton(AF_INET, plain.c_str(), &v4) == 1 && v4.s_addr != INADDR_ANY)
    return text_of_address(AF_INET, &v4);
  if (inet_pton(AF_INET6, plain.c_str(), &v6) == 1 && !IN6_IS_ADDR_UNSPECIFIED(&v6))
    return text_of_address(AF_INET6, &v6);
  return Error{"'" + text +
               "' is not the address of an interface; write it in numbers, like "
               "192.168.1.5"};
}

}  // namespace kibori::studio
