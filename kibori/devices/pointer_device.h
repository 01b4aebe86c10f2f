// SPDX-License-Identifier: MIT
// A mouse, a pen or a finger on a touch screen as a device. The thread that aims passes the poses
// at which the user points. The device has no force feedback.
//
//   hover      without a stroke: the hand jumps to the pose
//   stroke     the hand follows a path from point to point, at the times of the events:
//
//     event    ●─────────●──●────────────●            the sender's times [s], not arrival times
//     reading  ··························             one per tick, equally spaced in time
//
// Therefore, the readings depend only on the path. Events that arrive late or in bursts change no
// reading, and no part of the path is lost. While the next point is unknown, the hand waits. If the
// hand is far behind, one tick takes several readings.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>

#include <kibori/base/handover.h>
#include <kibori/haptics/device.h>

namespace kibori {

class PointerDevice final : public Device {
 public:
  explicit PointerDevice(double rate_hz);

  // ---- Functions for the thread that aims

  // Sets the pose of the hand. It has an effect only while no stroke is followed.
  void hover(const Pose& pose);
  // Pass the path of a stroke: the first point, more points, and the end. begin() returns the
  // number of the stroke. Only differences of times count [s]. A time before the last one is
  // replaced by the last one. `pressure` is that of a pen, 0 to 1. It is interpolated like the
  // poses. The servo thread does not read the path before follow().
  uint32_t begin(const Pose& pose, double time_s, double pressure = 1);
  void move(const Pose& pose, double time_s, double pressure = 1);
  void end();
  // Returns the number of the newest stroke that was read completely or given up.
  uint32_t finished() const { return finished_.load(std::memory_order_acquire); }
  // Passes waiting events to the servo thread, as far as its queue has room. Call it regularly.
  void pump();

  // ---- Functions for the servo thread

  // Starts to follow this stroke, with the hand at `from`.
  void follow(uint32_t stroke, const Pose& from);
  // Stops following. This stroke and all strokes before it count as finished.
  void give_up(uint32_t stroke);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  // Returns `stale` until there was a hover() or a followed stroke.
  DeviceStatus read(DeviceReading& reading) override;
  bool behind() const override;
  bool can_wait() const override { return true; }
  bool pressed() const override { return stroke_ != 0 && !ended_; }
  DeviceStatus write(const Wrench&) override { return DeviceStatus::ok; }

 private:
  struct Event {
    uint32_t stroke = 0;
    double time_s = 0;
    Pose pose;
    bool last = false;
    double pressure = 1;
  };
  static constexpr size_t kRoom = 1024;

  void queue(const Event& event);
  void lead_to(const Event& event, double seconds);
  bool next();

  DeviceCapabilities capabilities_;
  const double tick_s_;
  LatestValue<Pose> hovers_;
  SmallQueue<Event, kRoom> events_;
  std::atomic<double> newest_s_{0};  // time of the newest event
  std::atomic<uint32_t> finished_{0};
  // Members for the thread that aims.
  Event newest_;
  std::deque<Event> waiting_;  // events for which events_ has no room yet
  // Members for the servo thread.
  bool there_ = false;   // true if a pose is known
  uint32_t stroke_ = 0;  // the stroke that is followed, until it is given up; 0: none
  bool began_ = false, ended_ = false;
  bool has_event_ = false;  // true if event_ is not used yet
  Event event_;
  Pose now_, from_, to_;
  double pressure_ = 1, from_pressure_ = 1, to_pressure_ = 1;  // at now_, from_ and to_
  Vec3 turn_rad_ = Vec3::Zero();                               // rotation from from_ to to_
  int64_t readings_ = 0, read_ = 0;  // number of readings from from_ to to_; number done
  double from_s_ = 0, to_s_ = 0;
};

}  // namespace kibori
