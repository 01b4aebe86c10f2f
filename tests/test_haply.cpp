// SPDX-License-Identifier: MIT
// The Haply driver against a service over WebSocket.
#include <chrono>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <kibori/devices/haply_device.h>
#include <kibori/net/web.h>

#include "tests/device_support.h"
#include "tests/support.h"

namespace kibori::haply_tests {
namespace {

using std::chrono::milliseconds;
using test::read_fresh;

// The service: an inventory first, then a state for each frame it gets.
class HaplyService {
 public:
  explicit HaplyService(const nlohmann::json& inventory) {
    const Status listening = listener_.listen("127.0.0.1", 0);
    EXPECT_TRUE(listening.ok()) << listening.error();
    port_ = std::to_string(listener_.port());
    listener_.start([this, text = inventory.dump()](net::Socket socket) {
      http_.emplace(std::move(socket));
      http_->read_head({}, [this, text](net::Received) {
        socket_ = http_->upgrade();
        socket_->accept([this, text](bool) { send(text); });
      });
    });
    thread_ = std::thread([this] { loop_.run(); });
  }
  ~HaplyService() {
    loop_.stop();
    thread_.join();
  }
  const std::string& port() const { return port_; }
  void send_state(const std::string& state) {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = state;
  }
  nlohmann::json last() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_;
  }

 private:
  void send(std::string text) {
    sent_ = std::move(text);
    const auto* const bytes = reinterpret_cast<const uint8_t*>(sent_.data());
    socket_->write({bytes, sent_.size()}, [this](bool sent) {
      if (sent) read();
    });
  }
  void read() {
    socket_->read([this](std::optional<net::WebSocketMessage> message) {
      if (!message) return;  // the driver disconnected
      const std::lock_guard<std::mutex> lock(mutex_);
      last_ = nlohmann::json::parse(message->bytes.begin(), message->bytes.end(), nullptr, false);
      pause_.start(std::chrono::microseconds(300), [this, reply = state_] { send(reply); });
    });
  }

  std::string port_, sent_;
  std::mutex mutex_;
  std::string state_ = "{}";
  nlohmann::json last_;
  net::Loop loop_;
  net::Listener listener_{loop_};
  net::Timer pause_{loop_};
  std::optional<net::HttpStream> http_;
  std::unique_ptr<net::WebSocket> socket_;
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
    service.send_state(kHaplyState);
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
      command =
          service
              .last()["inverse3"][0]["commands"]["set_cursor_force"][newer ? "vector" : "values"];
      if (command.is_object() && command["z"] == 3) break;
    }
    EXPECT_EQ(command, (nlohmann::json{{"x", 1}, {"y", -2}, {"z", 3}}));
    EXPECT_EQ(service.last()["inverse3"][0]["device_id"], "04BA");
    // Unplugged: the state lists no arm any more.
    service.send_state(R"({"inverse3":[]})");
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

TEST(Haply, ReportsErrors) {
  EXPECT_NE(HaplyDevice::open("127.0.0.1", "1").error().find("is the Haply service running"),
            std::string::npos);
  {
    HaplyService service(nlohmann::json::parse(R"({"inverse3":[]})"));
    EXPECT_NE(HaplyDevice::open("127.0.0.1", service.port()).error().find("no Inverse3"),
              std::string::npos);
  }
  {
    HaplyService service(nlohmann::json::array({1, 2}));
    EXPECT_FALSE(HaplyDevice::open("127.0.0.1", service.port()).ok());
  }
  {
    test::TcpServer other(
        "not a web socket at all, but something else that goes on and on\r\n\r\n");
    EXPECT_NE(
        HaplyDevice::open("127.0.0.1", std::to_string(other.port())).error().find("WebSocket"),
        std::string::npos);
  }
  // Invalid states.
  for (const char* bad :
       {"{}", "[]", "null", "{", R"({"inverse3":[{"state":{"cursor_position":{"x":"a"}}}]})",
        R"({"inverse3":[{"state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"}) {
    HaplyService service(nlohmann::json::parse(kHaplyState));
    service.send_state(bad);
    auto opened = HaplyDevice::open("127.0.0.1", service.port());
    ASSERT_TRUE(opened.ok()) << opened.error();
    DeviceReading reading;
    EXPECT_EQ(read_fresh(*opened.value(), reading), DeviceStatus::unplugged) << bad;
  }
}

}  // namespace
}  // namespace kibori::haply_tests
