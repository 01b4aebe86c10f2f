// SPDX-License-Identifier: MIT
// Data for a page that shows how the model works: rays, dexels, and vanished points (lattice nodes
// that a tick removed).
#pragma once

#include <chrono>
#include <optional>

#include <kibori/live/servo_context.h>

#include "apps/studio/messages.h"
#include "apps/studio/session/ray_box.h"

namespace kibori::studio {

// The method view of one page. It has a snapshot only while the page sends questions.
class MethodView {
 public:
  using Clock = std::chrono::steady_clock;

  void ask(const AskMethod& question, Clock::time_point now) {
    question_ = question;
    requested_at_ = now;
  }
  // Returns true if the page shows the method at the moment.
  bool watching() const { return requested_at_ != Clock::time_point{}; }
  // Adds a servo tick. `wood` is the ratio of the wood's force to the device's force. It is 1 if no
  // device holds the tool.
  void add(const LiveTick& tick, double wood);
  // Returns the answer, if there is a question and an answer is due.
  std::optional<Method> answer(const Snapshot& snapshot, Clock::time_point now);
  // Forgets everything. Call it when another document is opened, or none.
  void clear() { *this = MethodView(); }

 private:
  std::optional<AskMethod> question_;
  Clock::time_point requested_at_{}, answered_at_{};
  std::optional<Snapshot> before_;  // model at the last answer
  std::optional<Vec3> tip_;         // position of the tip at the last tick
  uint32_t ticks_ = 0;              // number of ticks since the last answer
  // Number of points that vanished since the last answer.
  int64_t taken_ = 0;
  // True if points vanished before the last answer. Its snapshot may still have contained them.
  bool took_ = false;
  LiveTick newest_;  // the last tick that removed or added points
  Vec3 motion_ = Vec3::Zero(), force_ = Vec3::Zero();
};

}  // namespace kibori::studio
