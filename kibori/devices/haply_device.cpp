// SPDX-License-Identifier: MIT
#include <kibori/devices/haply_device.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include <kibori/base/handover.h>
#include <kibori/base/json.h>
#include <kibori/net/web.h>

namespace kibori {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPatience = std::chrono::seconds(2);
// A force that is not renewed within this time is dropped.
constexpr auto kWatchdog = std::chrono::milliseconds(20);
constexpr size_t kLongest = 1 << 20;  // maximum size of a frame [bytes]

// Reads a vector member of the frame. Returns false if there is none.
bool vector_at(const Json& frame, const char* name, Vec3& v) {
  const auto found = frame.find(name);
  if (found == frame.end() || !found->is_object()) return false;
  const char* const axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3; i++) {
    const auto value = found->find(axes[i]);
    if (value == found->end() || !value->is_number()) return false;
    v[i] = value->get<double>();
  }
  return v.allFinite();
}

const Json* first_of(const Json& frame, const char* kind) {
  const auto found = frame.find(kind);
  if (found == frame.end() || !found->is_array() || found->empty() || !found->front().is_object())
    return nullptr;
  return &found->front();
}

uint32_t buttons_of(const Json& state) {
  const auto found = state.find("buttons");
  if (found == state.end() || !found->is_object()) return 0;
  uint32_t bits = 0, bit = 1;
  for (const auto& button : *found) {  // by name: a, b, c
    if (button.is_boolean() && button.get<bool>()) bits |= bit;
    bit <<= 1;
    if (bit == 0) break;
  }
  return bits;
}

// The service uses metres, and x right, y forward, z up: Kibori's axes in another unit. Returns
// false if the frame contains no position.
bool read_frame(const Json& frame, DeviceReading& reading) {
  const Json* arm = first_of(frame, "inverse3");
  if (!arm) return false;
  const auto state = arm->find("state");
  if (state == arm->end() || !state->is_object()) return false;
  Vec3 position, velocity;
  if (!vector_at(*state, "cursor_position", position)) return false;
  if (!vector_at(*state, "cursor_velocity", velocity)) return false;
  if (position.cwiseAbs().maxCoeff() > 100 || velocity.cwiseAbs().maxCoeff() > 1e6) return false;
  reading.position_mm = 1000 * position;
  reading.velocity_mm_s = 1000 * velocity;
  for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
    const Json* grip = first_of(frame, kind);
    if (!grip) continue;
    const auto held = grip->find("state");
    if (held == grip->end() || !held->is_object()) continue;
    reading.buttons = buttons_of(*held);
    Vec3 xyz;
    if (!vector_at(*held, "orientation", xyz)) continue;
    const auto w = (*held)["orientation"].find("w");
    if (w == (*held)["orientation"].end() || !w->is_number()) continue;
    const Eigen::Quaterniond q(w->get<double>(), xyz.x(), xyz.y(), xyz.z());
    if (q.norm() > 0.5 && q.norm() < 2) reading.frame = q.normalized().toRotationMatrix();
  }
  return true;
}

}  // namespace

struct HaplyDevice::Link {
  net::WebSocketClient socket{kPatience, kLongest};
  std::string where, id, grip;
  bool newer = true;  // the service supports `vector`; older ones use `values`
  DeviceCapabilities capabilities;

  struct Timed {
    DeviceReading reading;
    Clock::time_point at;
  };
  LatestValue<Timed> readings;
  struct Command {
    Wrench wrench;
    Clock::time_point at;
  };
  LatestValue<Command> forces;
  std::atomic<bool> stopping{false}, lost{false};
  std::atomic<const char*> why{nullptr};
  std::thread thread;
  Timed last;
  bool seen = false;

  // Receives one frame. Returns null and sets `error` if the connection is lost or the frame is not
  // an object.
  Json receive(std::string& error) {
    const Result<std::string> text = socket.receive();
    if (!text) {
      error = text.error();
      return Json();
    }
    Json frame = parse_json(text.value());
    if (!frame.is_object()) {
      error = "its message is not a state of devices";
      return Json();
    }
    return frame;
  }
  std::string command(const Vec3& force) const {
    char text[400];
    std::snprintf(text, sizeof text,
                  "{\"inverse3\":[{\"device_id\":%s,\"commands\":{\"set_cursor_force\":{\"%s\":"
                  "{\"x\":%.6g,\"y\":%.6g,\"z\":%.6g}}}}]}",
                  id.c_str(), newer ? "vector" : "values", force.x(), force.y(), force.z());
    return text;
  }
  // Sends and receives until `stopping` is set.
  void run() {
    Command force;
    std::string error;
    Timed now;  // values that a frame omits stay unchanged
    while (!stopping.load(std::memory_order_relaxed)) {
      forces.take(force);
      const bool renewed = Clock::now() - force.at < kWatchdog;
      if (!socket.send_text(command(renewed ? force.wrench.force : Vec3(Vec3::Zero())))) {
        why = "the connection to the Haply service was lost";
        break;
      }
      const Json frame = receive(error);
      if (frame.is_null()) {
        why = "the Haply service no longer answers";
        break;
      }
      if (!read_frame(frame, now.reading)) {
        why = "the Inverse3 was unplugged";
        break;
      }
      now.at = Clock::now();
      readings.put(now);
    }
    socket.send_text(command(Vec3::Zero()));
    lost = true;
  }
};

HaplyDevice::HaplyDevice(std::unique_ptr<Link> link) : link_(std::move(link)) {}

Result<std::unique_ptr<HaplyDevice>> HaplyDevice::open(const std::string& host,
                                                       const std::string& port) {
  auto link = std::make_unique<Link>();
  link->where = "Haply service at " + host + ":" + port;
  const auto wrong = [&](const std::string& what) { return Error{link->where + ": " + what}; };
  if (const Status found = link->socket.resolve(host, port); !found) return wrong(found.error());
  if (const Status connected = link->socket.connect(); !connected)
    return wrong("nobody answers (" + connected.error() + "); is the Haply service running?");
  if (const Status spoken = link->socket.handshake(); !spoken)
    return wrong("does not speak WebSocket (" + spoken.error() + ")");
  std::string error;
  const Json inventory = link->receive(error);
  if (inventory.is_null()) return wrong(error);
  const Json* arm = first_of(inventory, "inverse3");
  if (!arm) return wrong("no Inverse3 is plugged in");
  const auto id = arm->find("device_id");
  if (id == arm->end() || !id->is_string()) return wrong("the Inverse3 has no device_id");
  link->id = id->dump();  // as JSON
  if (link->id.size() > 100) return wrong("the device_id of the Inverse3 is too long");
  // Only services that support `vector` describe the device's configuration.
  link->newer = arm->contains("config");
  DeviceCapabilities& c = link->capabilities;
  c.name = "Haply Inverse3 " + id->get<std::string>();
  c.dof_in =
      first_of(inventory, "wireless_verse_grip") || first_of(inventory, "verse_grip") ? 6 : 3;
  c.dof_out = 3;
  c.force_n = 8;
  c.damping_ns_mm = 0.002;
  c.stiffness_n_mm = 1;
  link->thread = std::thread([running = link.get()] { running->run(); });
  return std::unique_ptr<HaplyDevice>(new HaplyDevice(std::move(link)));
}

HaplyDevice::~HaplyDevice() {
  link_->stopping = true;
  link_->thread.join();
}

const DeviceCapabilities& HaplyDevice::capabilities() const { return link_->capabilities; }

DeviceStatus HaplyDevice::read(DeviceReading& reading) {
  if (link_->lost.load(std::memory_order_relaxed)) return DeviceStatus::unplugged;
  link_->seen |= link_->readings.take(link_->last);
  reading = link_->last.reading;
  if (!link_->seen) return reading.age_s = kUnknownAge, DeviceStatus::stale;
  reading.age_s = std::chrono::duration<double>(Clock::now() - link_->last.at).count();
  return reading.age_s < 0.002 ? DeviceStatus::ok : DeviceStatus::stale;
}

DeviceStatus HaplyDevice::write(const Wrench& wrench) {
  if (link_->lost.load(std::memory_order_relaxed)) return DeviceStatus::unplugged;
  link_->forces.put({wrench, Clock::now()});
  return DeviceStatus::ok;
}

std::string HaplyDevice::complaint() const {
  const char* why = link_->why.load();
  return why ? link_->where + ": " + why : std::string();
}

}  // namespace kibori
