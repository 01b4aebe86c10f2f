// SPDX-License-Identifier: MIT
#include <kibori/motion/stroke_player.h>

#include <utility>

namespace kibori {
namespace {

template <class... F>
struct Overload : F... {
  using F::operator()...;
};
template <class... F>
Overload(F...) -> Overload<F...>;

}  // namespace

Status check_stroke(const StrokeSettings& s, const NoGo* no_go) {
  if (Status fine = check_tool(s.tool); !fine) return fine;
  if (Status fine = check_symmetry(s.symmetry); !fine) return fine;
  if (s.materials.empty()) return Error{"a stroke needs at least one material"};
  if (s.material >= s.materials.size()) return Error{"this material is unknown"};
  if (Status fine = check_modes(s.mode, s.second_mode(), no_go != nullptr); !fine) return fine;
  if (reshapes(s.mode))
    if (Status fine = check_brush_of(s.mode, s.brush); !fine) return fine;
  if (!s.second) return Ok{};
  if (Status fine = check_tool(s.second->tool); !fine) return fine;
  if (s.second->material >= s.materials.size()) return Error{"this material is unknown"};
  return Ok{};
}

void StrokePlayer::set_threads(int threads) {
  first_.set_threads(threads);
  if (second_) second_->set_threads(threads);
  reshape_.set_threads(threads);
}

void StrokePlayer::set_no_go(const NoGo* no_go) {
  no_go_ = no_go;
  first_.set_no_go(no_go);
  if (second_) second_->set_no_go(no_go);
}

void StrokePlayer::set_grain(const Grain* grain) {
  first_.set_grain(grain);
  if (second_) second_->set_grain(grain);
}

Status StrokePlayer::begin(const StrokeSettings& settings) {
  if (Status fine = check_stroke(settings, no_go_); !fine) return fine;
  settings_ = settings;
  reshaping_ = failed_ = false;
  played_ = nullptr;
  first_.set_symmetry(settings.symmetry);
  first_.set_grows(settings.grows);
  first_.begin_stroke();
  if (second_) {
    second_->set_symmetry(settings.symmetry);
    second_->set_grows(settings.grows);
    second_->begin_stroke();
  }
  return Ok{};
}

ToolUse StrokePlayer::use_of(bool second) const {
  const StrokeSettings& s = settings_;
  if (!second) return {s.tool, s.mode, s.material, s.force.law, s.materials};
  if (!s.second) return {s.tool, Mode::off, 0, s.force.law, s.materials};
  return {s.second->tool, s.second->mode, s.second->material, s.second->force.law, s.materials};
}

// Reshapes the model after the first hand's tool moved from `before`.
Status StrokePlayer::reshape(ToolTick& tick, const Pose& before, bool computes) {
  const StrokeSettings& s = settings_;
  Status done = Ok{};
  if (!std::exchange(reshaping_, true))
    done = reshape_.begin({s.mode, s.brush, s.tool, s.force.law, s.rate_hz, s.symmetry, s.grows},
                          settings_.materials, before);
  if (done) done = reshape_.advance(tick, computes);
  failed_ = !done;
  return done;
}

Status StrokePlayer::end_reshaping(ToolTick& tick) {
  if (!std::exchange(reshaping_, false)) return Ok{};
  Status done = reshape_.end(tick);
  failed_ = !done;
  return done;
}

Result<ToolTick> StrokePlayer::move(const Vec3& tip_mm, const Vec3& turn_rad, bool second) {
  const Pose before = tool_pose(second);
  Result<ToolTick> done = hand(second).move(use_of(second), tip_mm, turn_rad);
  if (done && !second && reshapes(settings_.mode))
    if (const Status reshaped = reshape(done.value(), before); !reshaped)
      return Error{reshaped.error()};
  return done;
}

Result<ToolTick> StrokePlayer::move_to(const Pose& pose) {
  const Pose before = tool_pose();
  Result<ToolTick> done = first_.move_to(use_of(false), pose);
  if (done && reshapes(settings_.mode))
    if (const Status reshaped = reshape(done.value(), before); !reshaped)
      return Error{reshaped.error()};
  return done;
}

RecordedTick StrokePlayer::recorded(bool second) const {
  MoveTick tick = hand(second).recorded();
  tick.edits |= !second && reshapes(settings_.mode);
  return {tick, second};
}

Result<std::optional<RecordedTick>> StrokePlayer::end(ToolTick& last) {
  const bool apart = reshaping_ && ends_apart(settings_.mode);
  if (const Status ended = end_reshaping(last); !ended) return Error{ended.error()};
  if (!apart) return std::optional<RecordedTick>();
  return std::optional<RecordedTick>({EndTick{tool_pose().tip}, false});
}

Result<ToolTick> StrokePlayer::play_move(const MoveTick& tick, bool second) {
  // Documents of Kibori 0.1 have no EndTick. There, a tick that edits nothing ends the stroke.
  const bool ends = !second && reshaping_ && !tick.edits;
  const Pose before = tool_pose(second);
  Result<ToolTick> done = hand(second).play(use_of(second), tick);
  if (!done) return done;
  // The final result of a warp does not depend on the ticks in which it is computed. Only the force
  // of model `paper` does.
  const bool computes = tick.computes && settings_.force.law.model == ForceModel::paper;
  done.value().pressure = tick.pressure;
  if (!second && reshapes(settings_.mode) && (ends || tick.edits)) {
    const Status reshaped =
        ends ? end_reshaping(done.value()) : reshape(done.value(), before, computes);
    if (!reshaped) return Error{reshaped.error()};
  } else if (tick.edits) {
    played_ = &hand(second).played();
  }
  return done;
}

Result<ToolTick> StrokePlayer::play(const RecordedTick& tick) {
  played_ = nullptr;
  if (tick.second && !(second_ && settings_.second))
    return Error{"it has ticks of a second hand, but no second hand"};
  return std::visit(Overload{[&](const MoveTick& move) { return play_move(move, tick.second); },
                             [&](const PutTick& put) -> Result<ToolTick> {
                               hand(tick.second).place(put.pose);
                               ToolTick there;
                               there.pose = put.pose;
                               return there;
                             },
                             [&](const EndTick&) -> Result<ToolTick> {
                               ToolTick there;
                               there.pose = tool_pose();
                               if (const Status ended = end_reshaping(there); !ended)
                                 return Error{ended.error()};
                               return there;
                             }},
                    tick.what);
}

Status StrokePlayer::finish_record() {
  return std::exchange(reshaping_, false) ? reshape_.break_off() : Status(Ok{});
}

double StrokePlayer::without_force_mm3() const {
  const double h = model_.lattice().pitch_mm;
  const double cells =
      first_.without_force_cells() + (second_ ? second_->without_force_cells() : 0);
  return h * h * h * cells;
}

}  // namespace kibori
