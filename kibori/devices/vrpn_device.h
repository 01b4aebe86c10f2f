// SPDX-License-Identifier: MIT
// A device behind a VRPN server (tracker, buttons, force device), on any machine. This class speaks
// VRPN's protocol over TCP, and needs no library.
//
// write() sends a force field around the device's last position x0 to the server: F + J (x - x0).
// The server outputs the force at its own rate. Therefore, the force is smooth even if the program
// is slower.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <kibori/haptics/device.h>

namespace kibori {

// The address of a device on a VRPN server.
struct VrpnAddress {
  std::string device;  // the name of the device at the server, for example "Phantom0"
  std::string host;
  uint16_t port = 3883;
};
// Parses "Phantom0@host[:port]". Errors: the name or the host is missing; the port is invalid.
Result<VrpnAddress> parse_vrpn_address(const std::string& text);

class VrpnDevice final : public Device {
 public:
  // Connects to the server. Errors: the host is not found; the server does not answer within two
  // seconds or closes the connection; it does not speak VRPN.
  static Result<std::unique_ptr<VrpnDevice>> open(const VrpnAddress& address);
  ~VrpnDevice() override;

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  void expect_stiffness(double n_mm) override { stiffness_n_mm_ = n_mm; }
  std::string complaint() const override;

 private:
  static constexpr size_t kLongest = 4096;  // maximum size of a message [bytes]
  static constexpr int kMaxIds = 256;

  explicit VrpnDevice(int socket) : socket_(socket) { names_.fill(Known::other); }
  bool send_all(const void* data, size_t size);
  bool describe(int32_t kind, int32_t id, const char* name);
  void take(const unsigned char* message, size_t size);
  DeviceStatus lost(const char* why);

  enum class Known : uint8_t { other, pose, button };

  int socket_;
  DeviceCapabilities capabilities_;
  std::string device_;
  std::array<Known, kMaxIds> names_;  // index: the server's number of a message type
  // True for device_. Index: the server's number of a sender.
  std::array<bool, kMaxIds> ours_{};
  std::array<unsigned char, 4 * kLongest> buffer_;
  size_t filled_ = 0;
  DeviceReading last_;
  bool seen_ = false;
  double last_time_s_ = 0, velocity_time_s_ = 0, stiffness_n_mm_ = 0;
  Vec3 velocity_from_mm_ = Vec3::Zero();
  const char* lost_ = nullptr;  // the reason why the connection was lost; null: it was not
};

}  // namespace kibori
