// SPDX-License-Identifier: MIT
// A mouse, a pen or a finger on glass: someone else says where the hand wants to be, and nothing
// pushes back.
//
//   hover      the hand is there at once
//   a stroke   its path is followed, place by place as its events' own times say:
//
//     event    ●─────────●──●────────────●            times [s] of whoever aims, not of arrival
//     reading  ··························             one a tick, equally far apart in time
//
// So what is read is a function of the path alone: neither how late an event comes, nor how many
// come at once, changes any reading, and no part of the path is left out. Where the path is not
// known yet, the hand waits; where it lies far behind, several readings are due in one tick.
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

  // ---- Of one thread, who aims

  // Where the hand is while no stroke is followed.
  void hover(const Pose& pose);
  // A stroke's path: its first place, further ones, and that it is over. Times [s] count from
  // anywhere; one that goes back counts as the one before. Gives the stroke's number. Nothing is
  // read of it before follow().
  uint32_t begin(const Pose& pose, double time_s);
  void move(const Pose& pose, double time_s);
  void end();
  // The newest stroke of which all was read, or given up.
  uint32_t finished() const { return finished_.load(std::memory_order_acquire); }
  // Hands over what the servo thread had no room for. To be called now and then.
  void pump();

  // ---- Of the servo thread

  // From now on this stroke is followed, beginning at `from`.
  void follow(uint32_t stroke, const Pose& from);
  // No stroke is followed any more; this and all before it count as finished.
  void give_up(uint32_t stroke);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  // Nothing before the first hover() or stroke.
  DeviceStatus read(DeviceReading& reading) override;
  bool behind() const override;
  bool pressed() const override { return stroke_ != 0 && !ended_; }
  DeviceStatus write(const Wrench&) override { return DeviceStatus::ok; }

 private:
  struct Event {
    uint32_t stroke = 0;
    double time_s = 0;
    Pose pose;
    bool last = false;
  };
  static constexpr size_t kRoom = 1024;

  void queue(const Event& event);
  void lead_to(const Pose& pose, double seconds);
  bool next();

  DeviceCapabilities capabilities_;
  const double tick_s_;
  LatestValue<Pose> hovers_;
  SmallQueue<Event, kRoom> events_;
  std::atomic<double> told_s_{0};  // the time of the newest event
  std::atomic<uint32_t> finished_{0};
  // Of the one who aims.
  Event newest_;
  std::deque<Event> waiting_;  // for room in events_
  // Of the servo thread.
  bool there_ = false;   // a place is known
  uint32_t stroke_ = 0;  // that is followed, to its end and until it is given up; 0: none
  bool began_ = false, ended_ = false;
  bool has_event_ = false;  // event_ is not used yet
  Event event_;
  Pose now_, from_, to_;
  Vec3 turn_rad_ = Vec3::Zero();     // by which from_ is turned to to_
  int64_t readings_ = 0, read_ = 0;  // readings between from_ and to_: all of them, and those done
  double from_s_ = 0, to_s_ = 0;
};

}  // namespace kibori
