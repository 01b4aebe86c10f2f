// SPDX-License-Identifier: MIT
#include <kibori/devices/vrpn_device.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

namespace kibori {
namespace {

// Both sides begin with this cookie: the version, and "0" for no logging. Only the part before the
// minor version must match.
constexpr char kCookie[24] = "vrpn: ver. 07.36  0";
constexpr size_t kCookieSame = 13;  // "vrpn: ver. 07"
constexpr size_t kHeader = 24;
constexpr int32_t kSenderName = -1, kTypeName = -2;
constexpr int kPatienceMs = 2000;
constexpr double kRadiusMm = 5;  // radius of the force field: beyond it the server stops the force
// The client's numbers for its sender name and for its type of message.
constexpr int32_t kOurSender = 0, kOurForce = 0;

double now_s() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

uint32_t read32(const unsigned char* p) {
  return uint32_t{p[0]} << 24 | uint32_t{p[1]} << 16 | uint32_t{p[2]} << 8 | p[3];
}
double read_double(const unsigned char* p) {
  return std::bit_cast<double>(uint64_t{read32(p)} << 32 | read32(p + 4));
}
void put32(unsigned char* p, uint32_t value) {
  for (int i = 0; i < 4; i++) p[i] = static_cast<unsigned char>(value >> (24 - 8 * i));
}
size_t padded(size_t size) { return (size + 7) / 8 * 8; }

void put_header(unsigned char* p, size_t body, int32_t sender, int32_t type) {
  timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  put32(p, static_cast<uint32_t>(kHeader + body));
  put32(p + 4, static_cast<uint32_t>(t.tv_sec));
  put32(p + 8, static_cast<uint32_t>(t.tv_nsec / 1000));
  put32(p + 12, static_cast<uint32_t>(sender));
  put32(p + 16, static_cast<uint32_t>(type));
  put32(p + 20, 0);
}

}  // namespace

Result<VrpnAddress> parse_vrpn_address(const std::string& text) {
  const size_t at = text.find('@');
  const auto wrong = [&](const char* what) {
    return Error{"VRPN device '" + text + "' " + what +
                 "; write it like Phantom0@localhost or Phantom0@host:3883"};
  };
  if (at == std::string::npos || at == 0) return wrong("names no device");
  VrpnAddress address{text.substr(0, at), text.substr(at + 1)};
  if (address.device.size() > 99) return wrong("has too long a name");
  const size_t colon = address.host.rfind(':');
  if (colon != std::string::npos) {
    const std::string port = address.host.substr(colon + 1);
    char* end = nullptr;
    const long number = std::strtol(port.c_str(), &end, 10);
    if (port.empty() || *end != 0 || number < 1 || number > 65535)
      return wrong("has a port that is not 1 to 65535");
    address.port = static_cast<uint16_t>(number);
    address.host.resize(colon);
  }
  if (address.host.empty()) return wrong("names no host");
  return address;
}

Result<std::unique_ptr<VrpnDevice>> VrpnDevice::open(const VrpnAddress& address) {
  const std::string where = "VRPN server " + address.host + ":" + std::to_string(address.port);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error =
          getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found))
    return Error{where + ": " + gai_strerror(error)};
  int socket = -1, error = 0;
  for (const addrinfo* a = found; a && socket < 0; a = a->ai_next) {
    socket = ::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol);
    if (socket < 0) continue;
    error = connect(socket, a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      pollfd ready{socket, POLLOUT, 0};
      socklen_t size = sizeof error;
      if (poll(&ready, 1, kPatienceMs) != 1)
        error = ETIMEDOUT;
      else
        getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error != 0) {
      close(socket);
      socket = -1;
    }
  }
  freeaddrinfo(found);
  if (socket < 0) return Error{where + ": " + std::strerror(error) + "; is it running?"};
  const int yes = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);

  std::unique_ptr<VrpnDevice> device(new VrpnDevice(socket));
  device->device_ = address.device;
  device->capabilities_.name = address.device + " at " + address.host + " (VRPN)";
  device->capabilities_.dof_in = 6;
  device->capabilities_.dof_out = 3;
  if (!device->send_all(kCookie, sizeof kCookie))
    return Error{where + ": the connection was closed"};
  char cookie[sizeof kCookie];
  for (size_t got = 0; got < sizeof cookie;) {
    pollfd ready{socket, POLLIN, 0};
    if (poll(&ready, 1, kPatienceMs) != 1)
      return Error{where + ": no answer within 2 s; is it a VRPN server?"};
    const ssize_t n = recv(socket, cookie + got, sizeof cookie - got, 0);
    if (n <= 0) return Error{where + ": the connection was closed"};
    got += static_cast<size_t>(n);
  }
  if (std::memcmp(cookie, kCookie, kCookieSame) != 0)
    return Error{where + ": speaks another protocol than VRPN 07"};
  if (!device->describe(kSenderName, kOurSender, address.device.c_str()) ||
      !device->describe(kTypeName, kOurForce, "vrpn_ForceDevice Force_Field"))
    return Error{where + ": the connection was closed"};
  return device;
}

VrpnDevice::~VrpnDevice() {
  if (seen_) write({});  // stop the force that the server still renders
  close(socket_);
}

// Sends a small message. The socket's buffer is usually empty. If it has no room for the message,
// the server no longer reads, and this function returns false.
bool VrpnDevice::send_all(const void* data, size_t size) {
  return send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(size);
}

bool VrpnDevice::describe(int32_t kind, int32_t id, const char* name) {
  const size_t length = std::strlen(name) + 1, body = 4 + length;
  unsigned char message[kHeader + 128] = {};
  put_header(message, body, id, kind);
  put32(message + kHeader, static_cast<uint32_t>(length));
  std::memcpy(message + kHeader + 4, name, length);
  return send_all(message, kHeader + padded(body));
}

// Handles one complete message. `size` comes from its header.
void VrpnDevice::take(const unsigned char* message, size_t size) {
  const auto sender = static_cast<int32_t>(read32(message + 12)),
             type = static_cast<int32_t>(read32(message + 16));
  const unsigned char* body = message + kHeader;
  const size_t length = size - kHeader;
  if (type == kSenderName || type == kTypeName) {
    if (sender < 0 || sender >= kMaxIds || length < 4) return;
    const size_t text_size = read32(body);
    if (text_size < 1 || text_size > length - 4 || body[4 + text_size - 1] != 0) return;
    const char* const name = reinterpret_cast<const char*>(body + 4);
    const auto id = static_cast<size_t>(sender);
    if (type == kSenderName)
      ours_[id] = device_ == name;
    else
      names_[id] = std::strcmp(name, "vrpn_Tracker Pos_Quat") == 0 ? Known::pose
                   : std::strcmp(name, "vrpn_Button Change") == 0  ? Known::button
                                                                   : Known::other;
    return;
  }
  if (type < 0 || type >= kMaxIds || sender < 0 || sender >= kMaxIds ||
      !ours_[static_cast<size_t>(sender)])
    return;
  const Known known = names_[static_cast<size_t>(type)];
  if (known == Known::pose && length >= 8 + 7 * 8) {
    double v[7];
    for (size_t i = 0; i < 7; i++) v[i] = read_double(body + 8 + 8 * i);
    double norm2 = 0;
    for (size_t i = 3; i < 7; i++) norm2 += v[i] * v[i];
    for (const double x : v)
      if (!std::isfinite(x)) return;
    if (!(norm2 > 1e-6 && norm2 < 1e6)) return;
    const Vec3 position = 1000 * Vec3(v[0], v[1], v[2]);
    if (!(position.cwiseAbs().maxCoeff() < 1e5)) return;  // a hundred metres
    const double now = now_s(), since = now - velocity_time_s_;
    // If poses are less than 1 ms apart, the jitter of the network dominates the velocity.
    if (!seen_) {
      last_.velocity_mm_s = Vec3::Zero();
      velocity_from_mm_ = position;
      velocity_time_s_ = now;
    } else if (since > 0.001) {
      last_.velocity_mm_s = (position - velocity_from_mm_) / since;
      velocity_from_mm_ = position;
      velocity_time_s_ = now;
    }
    last_.position_mm = position;
    last_.frame = Eigen::Quaterniond(v[6], v[3], v[4], v[5]).normalized().toRotationMatrix();
    last_time_s_ = now;
    seen_ = true;
  } else if (known == Known::button && length >= 8) {
    const uint32_t button = read32(body), state = read32(body + 4);
    if (button < 32) last_.buttons = (last_.buttons & ~(1u << button)) | (state ? 1u << button : 0);
  }
}

DeviceStatus VrpnDevice::lost(const char* why) {
  lost_ = why;
  return DeviceStatus::unplugged;
}

DeviceStatus VrpnDevice::read(DeviceReading& reading) {
  if (lost_) return DeviceStatus::unplugged;
  // Limits the number of messages per tick, for a server that sends too fast.
  for (int rounds = 0; rounds < 8; rounds++) {
    const ssize_t n =
        recv(socket_, buffer_.data() + filled_, buffer_.size() - filled_, MSG_DONTWAIT);
    if (n == 0) return lost("the server closed the connection");
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) break;
    if (n < 0) return lost("the connection broke");
    filled_ += static_cast<size_t>(n);
    size_t used = 0;
    while (filled_ - used >= kHeader) {
      const size_t size = read32(buffer_.data() + used);
      if (size < kHeader || size > kLongest) return lost("the server sent an invalid message");
      const size_t whole = padded(size);
      if (filled_ - used < whole) break;
      take(buffer_.data() + used, size);
      used += whole;
    }
    std::memmove(buffer_.data(), buffer_.data() + used, filled_ - used);
    filled_ -= used;
  }
  reading = last_;
  reading.age_s = seen_ ? now_s() - last_time_s_ : kUnknownAge;
  return seen_ && reading.age_s < 0.002 ? DeviceStatus::ok : DeviceStatus::stale;
}

DeviceStatus VrpnDevice::write(const Wrench& wrench) {
  if (lost_) return DeviceStatus::unplugged;
  unsigned char message[kHeader + 64];
  put_header(message, 64, kOurSender, kOurForce);
  // The force field around the last position, in metres, N and N/m. It has a stiffness only along
  // the force.
  float values[16] = {};
  // The stiffness is limited so that the server's force at most doubles within the radius.
  const double force = std::sqrt(wrench.force.squaredNorm());
  const double stiffness = std::min({stiffness_n_mm_, force / kRadiusMm,
                                     std::max(0.0, capabilities_.force_n - force) / kRadiusMm});
  for (int i = 0; i < 3; i++) {
    values[i] = static_cast<float>(last_.position_mm[i] / 1000);
    values[3 + i] = static_cast<float>(wrench.force[i]);
    if (force > 0)
      for (int j = 0; j < 3; j++)
        values[6 + 3 * i + j] = static_cast<float>(-1000 * stiffness * wrench.force[i] *
                                                   wrench.force[j] / (force * force));
  }
  values[15] = static_cast<float>(kRadiusMm / 1000);
  for (size_t i = 0; i < 16; i++)
    put32(message + kHeader + 4 * i, std::bit_cast<uint32_t>(values[i]));
  if (!send_all(message, sizeof message)) return lost("the server no longer accepts forces");
  return DeviceStatus::ok;
}

std::string VrpnDevice::complaint() const {
  if (lost_) return capabilities_.name + ": " + lost_;
  if (!seen_)
    return capabilities_.name + ": the server has sent no position of it yet; is the name right?";
  return {};
}

}  // namespace kibori
