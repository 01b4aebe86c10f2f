// SPDX-License-Identifier: MIT
// What a page is told that looks at the method itself: rays, dexels, and the points that vanish.
#pragma once

#include <chrono>
#include <optional>

#include <kibori/live/servo_context.h>

#include "apps/studio/messages.h"
#include "apps/studio/session/ray_box.h"

namespace kibori::studio {

// Of one page. It holds a snapshot only while the page goes on asking.
class MethodView {
 public:
  using Clock = std::chrono::steady_clock;

  void ask(const AskMethod& question, Clock::time_point now) {
    question_ = question;
    asked_at_ = now;
  }
  // Whether the page looks at the method now.
  bool watching() const { return asked_at_ != Clock::time_point{}; }
  // A tick of the servo. `wood`: the wood's force for one that a device is given (1: none holds the
  // tool).
  void add(const LiveTick& tick, double wood);
  // The answer, if one is asked for and due.
  std::optional<Method> answer(const Snapshot& snapshot, Clock::time_point now);
  // There is another document, or none.
  void clear() { *this = MethodView(); }

 private:
  std::optional<AskMethod> question_;
  Clock::time_point asked_at_{}, answered_at_{};
  std::optional<Snapshot> before_;  // as of the last answer
  std::optional<Vec3> tip_;         // as of the last tick
  uint32_t ticks_ = 0;              // since the last answer
  int64_t taken_ = 0;
  bool took_ = false;  // in the ticks before the last answer: a snapshot comes after its ticks
  LiveTick newest_;    // that took or added points
  Vec3 motion_ = Vec3::Zero(), force_ = Vec3::Zero();
};

}  // namespace kibori::studio
