// SPDX-License-Identifier: MIT
// Shared by the tests of device drivers.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/haptics/device.h>

namespace kibori::test {

// Reads until the status is ok, or for two seconds.
template <class D>
DeviceStatus read_fresh(D& device, DeviceReading& reading) {
  DeviceStatus status = DeviceStatus::stale;
  for (int i = 0; i < 4000 && status == DeviceStatus::stale; i++) {
    status = device.read(reading);
    if (status == DeviceStatus::stale) std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return status;
}

// A listening socket on a free port.
struct Listener {
  int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  uint16_t port = 0;

  Listener() {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&at), size), 0);
    EXPECT_EQ(listen(socket, 1), 0);
    getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size);
    port = ntohs(at.sin_port);
  }
  ~Listener() { close(socket); }
};

// A server that sends given bytes and keeps what it receives.
class TcpServer {
 public:
  explicit TcpServer(std::string greeting) {
    thread_ = std::thread([this, greeting = std::move(greeting)] {
      client_ = accept(listener_.socket, nullptr, nullptr);
      if (client_ < 0) return;
      send_now(greeting);
      up_ = true;
      char buffer[4096];
      for (;;) {
        const ssize_t n = recv(client_, buffer, sizeof buffer, 0);
        if (n <= 0) return;
        const std::lock_guard<std::mutex> lock(mutex_);
        got_.append(buffer, static_cast<size_t>(n));
      }
    });
  }
  ~TcpServer() {
    shutdown(listener_.socket, SHUT_RDWR);
    hang_up();
    thread_.join();
    if (client_ >= 0) close(client_);
  }
  uint16_t port() const { return listener_.port; }
  void send_now(const std::string& bytes) {
    EXPECT_EQ(send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  void hang_up() {
    if (client_ >= 0) shutdown(client_, SHUT_RDWR);
  }
  std::string got() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return got_;
  }

 private:
  Listener listener_;
  std::atomic<int> client_{-1};
  std::atomic<bool> up_{false};
  std::mutex mutex_;
  std::string got_;
  std::thread thread_;
};

}  // namespace kibori::test
