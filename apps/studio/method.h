// SPDX-License-Identifier: MIT
// Data for a page that shows the method itself: rays, dexels, and vanishing points.
#pragma once

#include <chrono>
#include <optional>

#include <kibori/live/servo_context.h>

#include "apps/studio/messages.h"
#include "apps/studio/session/ray_box.h"

namespace kibori::studio {

// The method view of one page. It holds a snapshot only while the page keeps asking.
class MethodView {
 public:
  using Clock = std::chrono::steady_clock;

  void ask(const AskMethod& question, Clock::time_point now) {
    question_ = question;
    requested_at_ = now;
  }
  // True if the page currently shows the method.
  bool watching() const { return requested_at_ != Clock::time_point{}; }
  // Adds a servo tick. `wood` is the factor from the device's force to the wood's force. It is 1 if
  // no device holds the tool.
  void add(const LiveTick& tick, double wood);
  // The answer, if one was requested and is due.
  std::optional<Method> answer(const Snapshot& snapshot, Clock::time_point now);
  // Forgets everything, for another document or none.
  void clear() { *this = MethodView(); }

 private:
  std::optional<AskMethod> question_;
  Clock::time_point requested_at_{}, answered_at_{};
  std::optional<Snapshot> before_;  // model at the last answer
  std::optional<Vec3> tip_;         // position at the last tick
  uint32_t ticks_ = 0;              // ticks since the last answer
  int64_t taken_ = 0;
  bool took_ = false;  // points vanished before the last answer, but its snapshot may still have
                       // contained them
  LiveTick newest_;    // the last tick that removed or added points
  Vec3 motion_ = Vec3::Zero(), force_ = Vec3::Zero();
};

}  // namespace kibori::studio
