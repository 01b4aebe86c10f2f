// SPDX-License-Identifier: MIT
// The VRPN driver against a server that speaks the wire protocol.
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/devices/registry.h>
#include <kibori/devices/vrpn_device.h>

#include "tests/device_support.h"
#include "tests/support.h"

namespace kibori::vrpn_tests {
namespace {

using std::chrono::milliseconds;
using test::read_fresh;
using test::TcpServer;

// Writes messages byte by byte, as the protocol's documentation describes them. Shares no code with the driver.
class VrpnBytes {
 public:
  VrpnBytes& i32(int32_t v) {
    const uint32_t big = htonl(static_cast<uint32_t>(v));
    return raw(&big, 4);
  }
  VrpnBytes& f64(double v) {
    const auto bits = std::bit_cast<uint64_t>(v);
    return i32(static_cast<int32_t>(bits >> 32)).i32(static_cast<int32_t>(bits & 0xffffffffu));
  }
  VrpnBytes& raw(const void* data, size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};
std::string vrpn_message(int32_t sender, int32_t type, const std::string& body) {
  VrpnBytes m;
  m.i32(static_cast<int32_t>(24 + body.size())).i32(1000).i32(0).i32(sender).i32(type).i32(0);
  m.raw(body.data(), body.size());
  std::string bytes = m.bytes();
  while (bytes.size() % 8) bytes.push_back(0);
  return bytes;
}
std::string vrpn_name(const std::string& name) {
  VrpnBytes m;
  m.i32(static_cast<int32_t>(name.size() + 1)).raw(name.c_str(), name.size() + 1);
  return m.bytes();
}
std::string vrpn_pose(const double (&v)[7]) {
  VrpnBytes m;
  m.i32(0).i32(0);
  for (const double x : v) m.f64(x);
  return m.bytes();
}
std::string vrpn_cookie(const char* version) {
  std::string cookie = std::string("vrpn: ver. ") + version + "  0";
  cookie.resize(24, 0);
  return cookie;
}

int32_t int_at(const std::string& bytes, size_t at) {
  uint32_t big = 0;
  std::memcpy(&big, bytes.data() + at, 4);
  return static_cast<int32_t>(ntohl(big));
}
float float_at(const std::string& bytes, size_t at) {
  return std::bit_cast<float>(static_cast<uint32_t>(int_at(bytes, at)));
}

void introduce(TcpServer& server) {
  server.send_now(vrpn_message(3, -1, vrpn_name("Other")));
  server.send_now(vrpn_message(7, -1, vrpn_name("Phantom0")));
  server.send_now(vrpn_message(0, -2, vrpn_name("vrpn_Base ping_message")));
  server.send_now(vrpn_message(4, -2, vrpn_name("vrpn_Tracker Pos_Quat")));
  server.send_now(vrpn_message(5, -2, vrpn_name("vrpn_Button Change")));
}

TEST(Vrpn, ReadsPosesAndButtonsAndSendsForceFields) {
  TcpServer server(vrpn_cookie("07.35"));
  auto opened = VrpnDevice::open({"Phantom0", "127.0.0.1", server.port()});
  ASSERT_TRUE(opened.ok()) << opened.error();
  VrpnDevice& device = *opened.value();
  DeviceReading reading;
  EXPECT_EQ(device.read(reading), DeviceStatus::stale);
  EXPECT_NE(device.complaint().find("is the name right"), std::string::npos);
  introduce(server);
  const double half = std::sqrt(0.5);
  const std::string pose = vrpn_message(7, 4, vrpn_pose({0.01, -0.02, 0.03, 0, 0, half, half}));
  server.send_now(vrpn_message(3, 4, vrpn_pose({9, 9, 9, 0, 0, 0, 1})));  // another sender's
  server.send_now(vrpn_message(7, 5, VrpnBytes().i32(1).i32(1).bytes()));
  // In pieces, as a network may deliver it.
  server.send_now(pose.substr(0, 30));
  std::this_thread::sleep_for(milliseconds(5));
  device.read(reading);
  server.send_now(pose.substr(30));
  ASSERT_EQ(read_fresh(device, reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(10, -20, 30)).norm(), 0, 1e-9);
  // A quarter turn about z.
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);
  EXPECT_EQ(reading.buttons, 2u);
  EXPECT_TRUE(device.complaint().empty());

  device.expect_stiffness(0.5);
  EXPECT_EQ(device.write({Vec3(0, 0, 2), Vec3::Zero()}), DeviceStatus::ok);
  std::string got;
  for (int i = 0; i < 200 && got.size() < 24 + 48 + 56 + 88; i++) {
    std::this_thread::sleep_for(milliseconds(5));
    got = server.got();
  }
  EXPECT_EQ(got.substr(0, 13), "vrpn: ver. 07");
  // Two descriptions, then the field.
  size_t at = 24;
  EXPECT_EQ(int_at(got, at + 16), -1);
  EXPECT_STREQ(got.data() + at + 28, "Phantom0");
  at += (static_cast<size_t>(int_at(got, at)) + 7) / 8 * 8;
  EXPECT_EQ(int_at(got, at + 16), -2);
  EXPECT_STREQ(got.data() + at + 28, "vrpn_ForceDevice Force_Field");
  const int32_t type = int_at(got, at + 12);
  at += (static_cast<size_t>(int_at(got, at)) + 7) / 8 * 8;
  ASSERT_EQ(int_at(got, at), 24 + 64);
  EXPECT_EQ(int_at(got, at + 16), type);
  at += 24;
  EXPECT_NEAR(float_at(got, at + 8), 0.03, 1e-6);  // origin z [m]
  EXPECT_NEAR(float_at(got, at + 20), 2, 1e-6);    // force z [N]
  // dFz/dz [N/m]: 0.5 N/mm is limited to 0.2 N/mm, because 2 N may grow to at most 3 N in 5 mm.
  EXPECT_NEAR(float_at(got, at + 24 + 32), -200, 1e-3);
  EXPECT_NEAR(float_at(got, at + 24), 0, 1e-6);  // dFx/dx
  EXPECT_GT(float_at(got, at + 60), 0);          // radius

  std::this_thread::sleep_for(milliseconds(5));
  EXPECT_EQ(device.read(reading), DeviceStatus::stale);
  EXPECT_GT(reading.age_s, 0.004);
  server.hang_up();
  EXPECT_EQ(read_fresh(device, reading), DeviceStatus::unplugged);
  EXPECT_EQ(device.write({}), DeviceStatus::unplugged);
  EXPECT_NE(device.complaint().find("closed the connection"), std::string::npos);
}

TEST(Vrpn, HostileServersAreLeft) {
  test::Random random;
  for (int round = 0; round < 60; round++) {
    TcpServer server(vrpn_cookie("07.35"));
    auto opened = VrpnDevice::open({"Phantom0", "127.0.0.1", server.port()});
    ASSERT_TRUE(opened.ok()) << opened.error();
    introduce(server);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    server.send_now(vrpn_message(7, 4, vrpn_pose({nan, 0, 0, 0, 0, 0, 1})));
    server.send_now(vrpn_message(7, 4, vrpn_pose({0, 0, 0, 0, 0, 0, 0})));
    server.send_now(vrpn_message(7, 4, "short"));
    server.send_now(vrpn_message(100000, -1, vrpn_name("Phantom0")));
    server.send_now(vrpn_message(9, -1, VrpnBytes().i32(1 << 30).bytes()));
    std::string noise;
    for (int i = random.integer(24, 3000); i > 0; i--)
      noise.push_back(static_cast<char>(random.integer(0, 255)));
    server.send_now(noise);
    DeviceReading reading;
    for (int i = 0; i < 20; i++) {
      const DeviceStatus status = opened.value()->read(reading);
      EXPECT_NE(status, DeviceStatus::ok) << random.note();
      EXPECT_TRUE(reading.position_mm.allFinite());
      if (status == DeviceStatus::unplugged) break;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }
}

TEST(Vrpn, ReportsErrors) {
  EXPECT_FALSE(VrpnDevice::open({"P", "127.0.0.1", 1}).ok());  // no server there
  TcpServer other(vrpn_cookie("06.10"));
  const auto old = VrpnDevice::open({"P", "127.0.0.1", other.port()});
  ASSERT_FALSE(old.ok());
  EXPECT_NE(old.error().find("another protocol"), std::string::npos);
  for (const char* bad : {"", "@", "a@", "@h", "a", "a@h:", "a@h:0", "a@h:70000", "a@h:x"})
    EXPECT_FALSE(parse_vrpn_address(bad).ok()) << bad;
  const auto good = parse_vrpn_address("Tracker0@host:4000");
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(good.value().device + good.value().host, "Tracker0host");
  EXPECT_EQ(good.value().port, 4000);
}

}  // namespace
}  // namespace kibori::vrpn_tests
