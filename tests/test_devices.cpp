// SPDX-License-Identifier: MIT
// Drivers against faithful stand-ins: a VRPN server that speaks the wire protocol, a Haply service over
// WebSocket, a library with the vendor's interface.
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

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <kibori/devices/force_dimension.h>
#include <kibori/devices/haply_device.h>
#include <kibori/devices/open_haptics.h>
#include <kibori/devices/recording.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/devices/vrpn_device.h>

#include "tests/fake_dhd.h"
#include "tests/fake_hd.h"
#include "tests/support.h"

namespace kibori {
namespace {

using std::chrono::milliseconds;

// Reads until it says ok, or for two seconds.
template <class D>
DeviceStatus read_fresh(D& device, DeviceReading& reading) {
  DeviceStatus status = DeviceStatus::stale;
  for (int i = 0; i < 4000 && status == DeviceStatus::stale; i++) {
    status = device.read(reading);
    if (status == DeviceStatus::stale) std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return status;
}

// A listening socket on a port of its own.
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

// ---- VRPN

// Byte by byte, as the protocol's description has it; shares nothing with the driver.
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

// A server that sends what it is told and keeps what it gets.
class VrpnServer {
 public:
  explicit VrpnServer(std::string greeting = vrpn_cookie("07.35")) {
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
  ~VrpnServer() {
    shutdown(listener_.socket, SHUT_RDWR);
    hang_up();
    thread_.join();
    if (client_ >= 0) close(client_);
  }
  uint16_t port() const { return listener_.port; }
  void send_now(const std::string& bytes) {
    EXPECT_EQ(send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
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

int32_t int_at(const std::string& bytes, size_t at) {
  uint32_t big = 0;
  std::memcpy(&big, bytes.data() + at, 4);
  return static_cast<int32_t>(ntohl(big));
}
float float_at(const std::string& bytes, size_t at) {
  return std::bit_cast<float>(static_cast<uint32_t>(int_at(bytes, at)));
}

void introduce(VrpnServer& server) {
  server.send_now(vrpn_message(3, -1, vrpn_name("Other")));
  server.send_now(vrpn_message(7, -1, vrpn_name("Phantom0")));
  server.send_now(vrpn_message(0, -2, vrpn_name("vrpn_Base ping_message")));
  server.send_now(vrpn_message(4, -2, vrpn_name("vrpn_Tracker Pos_Quat")));
  server.send_now(vrpn_message(5, -2, vrpn_name("vrpn_Button Change")));
}

TEST(Vrpn, ReadsPosesAndButtonsAndSendsForceFields) {
  VrpnServer server;
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
  // In pieces, as a network may bring it.
  server.send_now(pose.substr(0, 30));
  std::this_thread::sleep_for(milliseconds(5));
  device.read(reading);
  server.send_now(pose.substr(30));
  ASSERT_EQ(read_fresh(device, reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(10, -20, 30)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);  // a quarter turn about z
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
  EXPECT_NEAR(float_at(got, at + 24 + 32), -200,
              1e-3);                             // dFz/dz [N/m]: 0.5 N/mm, but 3 N at most within 5 mm
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
    VrpnServer server;
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

TEST(Vrpn, SaysWhatIsWrong) {
  EXPECT_FALSE(VrpnDevice::open({"P", "127.0.0.1", 1}).ok());  // nobody there
  VrpnServer other(vrpn_cookie("06.10"));
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

// ---- Haply

namespace beast = boost::beast;
using tcp = boost::asio::ip::tcp;

// The service: an inventory first, then a state for each frame it gets.
class HaplyService {
 public:
  explicit HaplyService(nlohmann::json inventory, int frames = 1 << 30)
      : acceptor_(context_, tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0)) {
    port_ = std::to_string(acceptor_.local_endpoint().port());
    thread_ = std::thread([this, inventory = std::move(inventory), frames] {
      try {
        beast::websocket::stream<tcp::socket> socket(acceptor_.accept());
        socket.accept();
        socket.write(boost::asio::buffer(inventory.dump()));
        for (int i = 0; i < frames; i++) {
          beast::flat_buffer buffer;
          socket.read(buffer);
          std::string reply;
          {
            const std::lock_guard<std::mutex> lock(mutex_);
            commands_++;
            last_ = nlohmann::json::parse(beast::buffers_to_string(buffer.data()), nullptr, false);
            reply = state_;
          }
          socket.write(boost::asio::buffer(reply));
          std::this_thread::sleep_for(std::chrono::microseconds(300));
        }
      } catch (const std::exception&) {  // the driver left
      }
    });
  }
  ~HaplyService() {
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    thread_.join();
  }
  const std::string& port() const { return port_; }
  void say(const std::string& state) {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = state;
  }
  nlohmann::json last() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_;
  }

 private:
  boost::asio::io_context context_;
  tcp::acceptor acceptor_;
  std::string port_;
  std::mutex mutex_;
  std::string state_ = "{}";
  nlohmann::json last_;
  int commands_ = 0;
  std::thread thread_;
};

const char* const kHaplyState =
    R"({"inverse3":[{"device_id":"04BA","state":{"cursor_position":{"x":0.01,"y":0.02,"z":-0.03},
        "cursor_velocity":{"x":0.1,"y":0,"z":0}}}],
        "wireless_verse_grip":[{"device_id":"61","state":{"orientation":{"w":0.7071,"x":0,"y":0,"z":0.7071},
        "buttons":{"a":true,"b":false,"c":true}}}]})";

TEST(Haply, ReadsTheStateAndSendsForces) {
  for (const bool newer : {true, false}) {
    nlohmann::json inventory = nlohmann::json::parse(kHaplyState);
    if (newer) inventory["inverse3"][0]["config"] = {{"type", "inverse3"}};
    HaplyService service(inventory);
    service.say(kHaplyState);
    auto opened = HaplyDevice::open("127.0.0.1", service.port());
    ASSERT_TRUE(opened.ok()) << opened.error();
    HaplyDevice& device = *opened.value();
    EXPECT_EQ(device.capabilities().dof_in, 6);
    DeviceReading reading;
    ASSERT_EQ(read_fresh(device, reading), DeviceStatus::ok);
    EXPECT_NEAR((reading.position_mm - Vec3(10, 20, -30)).norm(), 0, 1e-9);
    EXPECT_NEAR((reading.velocity_mm_s - Vec3(100, 0, 0)).norm(), 0, 1e-9);
    EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-6);
    EXPECT_EQ(reading.buttons, 5u);
    EXPECT_EQ(device.write({Vec3(1, -2, 3), Vec3::Zero()}), DeviceStatus::ok);
    nlohmann::json command;
    for (int i = 0; i < 400; i++) {
      std::this_thread::sleep_for(milliseconds(2));
      command = service.last()["inverse3"][0]["commands"]["set_cursor_force"][newer ? "vector" : "values"];
      if (command.is_object() && command["z"] == 3) break;
    }
    EXPECT_EQ(command, (nlohmann::json{{"x", 1}, {"y", -2}, {"z", 3}}));
    EXPECT_EQ(service.last()["inverse3"][0]["device_id"], "04BA");
    // Unplugged: the state names no arm any more.
    service.say(R"({"inverse3":[]})");
    DeviceStatus status = DeviceStatus::ok;
    for (int i = 0; i < 400 && status != DeviceStatus::unplugged; i++) {
      std::this_thread::sleep_for(milliseconds(2));
      status = device.read(reading);
    }
    EXPECT_EQ(status, DeviceStatus::unplugged);
    EXPECT_EQ(device.write({}), DeviceStatus::unplugged);
    EXPECT_NE(device.complaint().find("unplugged"), std::string::npos);
  }
}

TEST(Haply, SaysWhatIsWrong) {
  EXPECT_NE(HaplyDevice::open("127.0.0.1", "1").error().find("is the Haply service running"),
            std::string::npos);
  {
    HaplyService service(nlohmann::json::parse(R"({"inverse3":[]})"));
    EXPECT_NE(HaplyDevice::open("127.0.0.1", service.port()).error().find("no Inverse3"), std::string::npos);
  }
  {
    HaplyService service(nlohmann::json::array({1, 2}));
    EXPECT_FALSE(HaplyDevice::open("127.0.0.1", service.port()).ok());
  }
  {
    VrpnServer other("not a web socket at all, but something else that goes on and on\r\n\r\n");
    EXPECT_NE(HaplyDevice::open("127.0.0.1", std::to_string(other.port())).error().find("WebSocket"),
              std::string::npos);
  }
  // States that are none.
  for (const char* bad :
       {"{}", "[]", "null", "{", R"({"inverse3":[{"state":{"cursor_position":{"x":"a"}}}]})",
        R"({"inverse3":[{"state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"}) {
    HaplyService service(nlohmann::json::parse(kHaplyState));
    service.say(bad);
    auto opened = HaplyDevice::open("127.0.0.1", service.port());
    ASSERT_TRUE(opened.ok()) << opened.error();
    DeviceReading reading;
    EXPECT_EQ(read_fresh(*opened.value(), reading), DeviceStatus::unplugged) << bad;
  }
}

// ---- Force Dimension

class ForceDimension : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("FORCEDIM_SDK", KIBORI_FAKE_SDK, 1);
    auto library = SharedLibrary::open({KIBORI_FAKE_SDK "/lib/libdhd.so.3"});
    ASSERT_TRUE(library.ok()) << library.error();
    library_ = std::move(library).value();
    FakeDhd* (*get)() = nullptr;
    ASSERT_TRUE(library_.find("fake_dhd", get));
    fake_ = get();
    *fake_ = FakeDhd();
  }
  void TearDown() override { unsetenv("FORCEDIM_SDK"); }
  SharedLibrary library_;
  FakeDhd* fake_ = nullptr;
};

TEST_F(ForceDimension, ReadsAndWritesInOurAxes) {
  auto opened = ForceDimensionDevice::open();
  ASSERT_TRUE(opened.ok()) << opened.error();
  ForceDimensionDevice& device = *opened.value();
  EXPECT_EQ(device.capabilities().dof_out, 6);
  EXPECT_EQ(device.capabilities().force_n, 12);
  EXPECT_EQ(fake_->forces_on, 1);
  EXPECT_EQ(fake_->watchdog, 160);  // 20 ms in steps of 125 us
  // Theirs: x to the user, y right, z up.
  fake_->position[0] = -0.01, fake_->position[1] = 0.02, fake_->position[2] = 0.03;
  fake_->velocity[1] = 0.5;
  fake_->buttons = 9;
  // A quarter turn about z is one in any frame with that z.
  const double turn[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  std::memcpy(fake_->frame, turn, sizeof turn);
  DeviceReading reading;
  ASSERT_EQ(device.read(reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(20, 10, 30)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.velocity_mm_s - Vec3(500, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);
  EXPECT_EQ(reading.buttons, 9u);
  // Ours to theirs and back.
  ASSERT_EQ(device.write({Vec3(1, 2, 3), Vec3(4, 5, 6)}), DeviceStatus::ok);
  EXPECT_EQ(fake_->force[0], -2);
  EXPECT_EQ(fake_->force[1], 1);
  EXPECT_EQ(fake_->force[2], 3);
  EXPECT_NEAR(fake_->torque[0], -0.005, 1e-12);
  EXPECT_NEAR(fake_->torque[1], 0.004, 1e-12);
  // Too soon: the value is the last one.
  fake_->read_result = 1;
  EXPECT_EQ(device.read(reading), DeviceStatus::stale);
  fake_->read_result = 0;
  EXPECT_EQ(device.read(reading), DeviceStatus::ok);
  EXPECT_EQ(reading.age_s, 0);
  // A saturated motor is no fault.
  fake_->write_result = 2;
  EXPECT_EQ(device.write({}), DeviceStatus::ok);
  opened.value().reset();
  EXPECT_EQ(fake_->closed, 1);
  EXPECT_EQ(fake_->force[2], 0);
}

TEST_F(ForceDimension, EveryErrorCodeIsAFaultThatStays) {
  for (int code = 0; code <= 21; code++)
    for (int FakeDhd::*where :
         {&FakeDhd::read_result, &FakeDhd::velocity_result, &FakeDhd::frame_result, &FakeDhd::write_result}) {
      *fake_ = FakeDhd();
      auto opened = ForceDimensionDevice::open();
      ASSERT_TRUE(opened.ok()) << opened.error();
      DeviceReading reading;
      EXPECT_EQ(opened.value()->read(reading), DeviceStatus::ok);
      EXPECT_EQ(opened.value()->write({Vec3(0, 0, 5), Vec3::Zero()}), DeviceStatus::ok);
      fake_->*where = -1;
      fake_->error = code;
      const bool gone = code == 2 || code == 5 || code == 6 || code == 12;
      const DeviceStatus expected = gone ? DeviceStatus::unplugged : DeviceStatus::failed;
      EXPECT_EQ(where == &FakeDhd::write_result ? opened.value()->write({}) : opened.value()->read(reading),
                expected);
      fake_->*where = 0;
      EXPECT_EQ(opened.value()->read(reading), expected);
      EXPECT_EQ(opened.value()->write({}), expected);
      EXPECT_NE(opened.value()->complaint().find("what the vendor says"), std::string::npos);
      // The force from before is gone, where there is still somebody to tell.
      if (!gone && where != &FakeDhd::write_result) {
        EXPECT_EQ(fake_->force[2], 0);
      }
    }
  // A position that is none.
  *fake_ = FakeDhd();
  auto opened = ForceDimensionDevice::open();
  ASSERT_TRUE(opened.ok());
  fake_->position[0] = std::numeric_limits<double>::quiet_NaN();
  DeviceReading reading;
  EXPECT_EQ(opened.value()->read(reading), DeviceStatus::failed);
}

TEST_F(ForceDimension, SaysWhyItIsNotThere) {
  fake_->devices = 0;
  EXPECT_NE(ForceDimensionDevice::open().error().find("plugged in"), std::string::npos);
  fake_->devices = -1;
  EXPECT_FALSE(ForceDimensionDevice::open().ok());
  *fake_ = FakeDhd();
  fake_->open_result = -1;
  EXPECT_NE(ForceDimensionDevice::open().error().find("what the vendor says"), std::string::npos);
  *fake_ = FakeDhd();
  fake_->enable_result = -1;
  EXPECT_NE(ForceDimensionDevice::open().error().find("switched on"), std::string::npos);
  EXPECT_EQ(fake_->closed, 1);
  // A library of that name which is another.
  setenv("FORCEDIM_SDK", "/nonexistent", 1);
  EXPECT_NE(ForceDimensionDevice::open().error().find("FORCEDIM_SDK"), std::string::npos);
  *fake_ = FakeDhd();
  fake_->wrist = fake_->active_wrist = false;
  fake_->max_force = std::nan("");
  setenv("FORCEDIM_SDK", KIBORI_FAKE_SDK, 1);
  auto opened = open_device("forcedim");
  ASSERT_TRUE(opened.ok()) << opened.error();
  EXPECT_EQ(opened.value()->capabilities().dof_in, 3);
  EXPECT_EQ(opened.value()->capabilities().dof_out, 3);
  EXPECT_GT(opened.value()->capabilities().force_n, 0);
}

// ---- OpenHaptics

class OpenHaptics : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("OH_SDK_BASE", KIBORI_FAKE_SDK, 1);
    auto library = SharedLibrary::open({KIBORI_FAKE_SDK "/lib/libHD.so"});
    ASSERT_TRUE(library.ok()) << library.error();
    library_ = std::move(library).value();
    FakeHd* (*get)() = nullptr;
    ASSERT_TRUE(library_.find("fake_hd", get));
    fake_ = get();
    fake_->init_error = fake_->error = 0;
    fake_->max_force = 3.3;
    fake_->disabled = fake_->unscheduled = 0;
  }
  void TearDown() override { unsetenv("OH_SDK_BASE"); }
  SharedLibrary library_;
  FakeHd* fake_ = nullptr;
};

TEST_F(OpenHaptics, ReadsAndWritesInOurAxes) {
  auto opened = open_device("openhaptics");
  ASSERT_TRUE(opened.ok()) << opened.error();
  Device& device = *opened.value();
  EXPECT_TRUE(fake_->output);
  EXPECT_EQ(device.capabilities().force_n, 3.3);
  fake_->x = 10;
  fake_->buttons = 2;
  std::this_thread::sleep_for(milliseconds(20));
  DeviceReading reading;
  ASSERT_EQ(read_fresh(device, reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(10, 30, 20)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.velocity_mm_s - Vec3(100, 0, 0)).norm(), 0, 1e-9);
  // A quarter turn about their y, which is our z.
  EXPECT_NEAR((reading.frame * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);
  EXPECT_EQ(reading.buttons, 2u);
  for (int i = 0; i < 20; i++) {
    ASSERT_EQ(device.write({Vec3(1, 2, 3), Vec3::Zero()}), DeviceStatus::ok);
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(fake_->force_y, 3);   // up
  EXPECT_EQ(fake_->force_z, -2);  // to the user
  // Nobody renews it: let go within 20 ms (and what the thread takes).
  std::this_thread::sleep_for(milliseconds(80));
  EXPECT_EQ(fake_->force_y, 0);
  opened.value().reset();
  EXPECT_EQ(fake_->disabled, 1);
  EXPECT_EQ(fake_->unscheduled, 1);
}

TEST_F(OpenHaptics, EveryErrorCodeIsAFaultThatStays) {
  for (const unsigned code :
       {0x0100u, 0x0301u, 0x0302u, 0x0303u, 0x0400u, 0x0402u, 0x0403u, 0x0404u, 0x0500u}) {
    fake_->error = 0;
    auto opened = OpenHapticsDevice::open();
    ASSERT_TRUE(opened.ok()) << opened.error();
    DeviceReading reading;
    ASSERT_EQ(read_fresh(*opened.value(), reading), DeviceStatus::ok);
    fake_->error = code;
    const DeviceStatus expected =
        code == 0x0302 || code == 0x0303 ? DeviceStatus::unplugged : DeviceStatus::failed;
    DeviceStatus status = DeviceStatus::ok;
    for (int i = 0; i < 1000 && (status == DeviceStatus::ok || status == DeviceStatus::stale); i++) {
      std::this_thread::sleep_for(milliseconds(1));
      status = opened.value()->read(reading);
    }
    EXPECT_EQ(status, expected);
    fake_->error = 0;
    std::this_thread::sleep_for(milliseconds(3));
    EXPECT_EQ(opened.value()->read(reading), expected);
    EXPECT_EQ(opened.value()->write({}), expected);
    EXPECT_NE(opened.value()->complaint().find("what the vendor says"), std::string::npos);
  }
  fake_->init_error = 0x0400;
  EXPECT_NE(OpenHapticsDevice::open().error().find("what the vendor says"), std::string::npos);
  setenv("OH_SDK_BASE", "/nonexistent", 1);
  EXPECT_NE(OpenHapticsDevice::open().error().find("OH_SDK_BASE"), std::string::npos);
}

// ---- Recordings

TEST(Recording, PlaysBackWhatWasRead) {
  VirtualDeviceSettings settings;
  const auto script = [](double t) {
    return VirtualDevice::Target{Vec3(std::sin(t), t, 0), rotation(Vec3(0, 0, t)), t > 0.01 ? 1u : 0u};
  };
  RecordingDevice recorder(std::make_unique<VirtualDevice>(settings, script), 0.001, 40);
  std::vector<DeviceReading> seen;
  DeviceReading reading;
  for (int i = 0; i < 60; i++) {
    ASSERT_EQ(recorder.read(reading), DeviceStatus::ok);
    seen.push_back(reading);
  }
  ASSERT_EQ(recorder.readings().size(), 40u);
  const auto path =
      std::filesystem::temp_directory_path() / ("kibori-recording-" + std::to_string(getpid()) + ".csv");
  ASSERT_TRUE(recorder.save(path).ok());
  auto opened = open_device("replay:" + path.string());
  ASSERT_TRUE(opened.ok()) << opened.error();
  for (int i = 0; i < 60; i++) {
    ASSERT_EQ(opened.value()->read(reading), DeviceStatus::ok);
    const DeviceReading& was = seen[static_cast<size_t>(std::min(i, 39))];
    EXPECT_EQ(reading.position_mm, was.position_mm);
    EXPECT_EQ(reading.frame, was.frame);
    EXPECT_EQ(reading.buttons, was.buttons);
  }
  std::filesystem::remove(path);
  EXPECT_FALSE(open_device("replay:" + path.string()).ok());
}

TEST(Recording, RefusesWhatIsNone) {
  const auto path =
      std::filesystem::temp_directory_path() / ("kibori-bad-" + std::to_string(getpid()) + ".csv");
  const std::string kHead = "t_s,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,buttons\n";
  const std::string good = "0.001,1,2,3,1,0,0,0,1,0,0,0,1,0";
  for (const std::string& bad : std::vector<std::string>{
           std::string(), std::string("heading\n"), kHead + good + ",7\n", kHead + good.substr(0, 20) + "\n",
           "h\nnan" + good.substr(5) + "\n", "h\n0.001,1,2,3,1,0,0,0,1,0,0,0,-1,0\n", kHead + good + "1e99\n",
           kHead + good.substr(0, good.size() - 1) + "-1\n", std::string("h\n\0\0\0", 5),
           kHead + good + "\n" + std::string(1, 0) + good, kHead + good + "\n\n"}) {
    {
      std::FILE* file = std::fopen(path.c_str(), "wb");
      ASSERT_NE(file, nullptr);
      std::fwrite(bad.data(), 1, bad.size(), file);
      std::fclose(file);
    }
    const auto read = read_recording(path);
    ASSERT_FALSE(read.ok()) << bad;
    EXPECT_NE(read.error().find(path.string()), std::string::npos);
  }
  std::filesystem::remove(path);
}

TEST(Registry, KnowsTheKinds) {
  for (const char* bad : {"", "phantom", "haply:", "haply:host:", "haply::1", "vrpn:", "vrpn:a"})
    EXPECT_FALSE(open_device(bad).ok()) << bad;
  EXPECT_NE(open_device("phantom").error().find("vrpn:NAME@HOST"), std::string::npos);
  bool simulated = false;
  for (const DeviceFound& found : find_devices()) {
    EXPECT_FALSE(found.text.empty());
    simulated |= found.name == "virtual" && found.present;
  }
  EXPECT_TRUE(simulated);
}

}  // namespace
}  // namespace kibori
