// SPDX-License-Identifier: MIT
#include "apps/studio/method.h"

#include <utility>

namespace kibori::studio {
namespace {

constexpr auto kAnswerEvery = std::chrono::milliseconds(33);
// A page that has not asked for this long no longer shows the method.
constexpr auto kForgotten = std::chrono::seconds(2);

template <class T>
void append(std::vector<uint8_t>& to, T value) {
  const auto* const raw = reinterpret_cast<const uint8_t*>(&value);
  to.insert(to.end(), raw, raw + sizeof value);
}

}  // namespace

void MethodView::add(const LiveTick& tick, double wood) {
  const Vec3 motion = tip_ ? Vec3(tick.tool.tip - *tip_) : Vec3(Vec3::Zero());
  tip_ = tick.tool.tip;
  ticks_++;
  taken_ += tick.points;
  if (tick.points == 0) return;
  newest_ = tick;
  motion_ = motion;
  force_ = wood * tick.computed.force;
}

std::optional<Method> MethodView::answer(const Snapshot& snapshot, Clock::time_point now) {
  if (!question_) {
    if (watching() && now - requested_at_ > kForgotten) clear();
    return {};
  }
  if (now - answered_at_ < kAnswerEvery) return {};
  answered_at_ = now;
  const RayBox box = ray_box(snapshot.lattice, kAxes[question_->axis], question_->centre,
                             question_->radius, question_->every);
  question_.reset();
  Method reply;
  reply.axis = static_cast<uint8_t>(box.axis);
  reply.every = static_cast<uint16_t>(box.every);
  reply.u = box.u;
  reply.v = box.v;
  reply.columns = static_cast<uint16_t>(box.columns);
  reply.rows = static_cast<uint16_t>(box.rows);
  reply.low = box.low;
  reply.high = box.high;
  reply.points = static_cast<double>(newest_.points);
  reply.volume = newest_.removed_mm3;
  reply.motion = motion_;
  reply.force = force_;
  reply.ticks = ticks_;
  reply.taken = static_cast<double>(taken_);
  for (const std::vector<Span>& spans : spans_in(box, snapshot)) {
    append(reply.spans, static_cast<uint8_t>(spans.size()));
    for (const Span& span : spans) {
      append(reply.spans, span.in);
      append(reply.spans, span.out);
    }
  }
  // Points that an undo removes did not vanish in a tick, so they are not listed.
  const bool took = std::exchange(took_, taken_ != 0);
  if ((took || took_) && before_ && before_->of_same_model(snapshot)) {
    const VanishedNodes gone = vanished_in(finer(box), *before_, snapshot);
    reply.gone = static_cast<uint32_t>(gone.count);
    for (const std::array<int16_t, 3>& node : gone.nodes)
      for (const int16_t index : node) append(reply.vanished, index);
  }
  before_ = snapshot;
  ticks_ = 0;
  taken_ = 0;
  return reply;
}

}  // namespace kibori::studio
