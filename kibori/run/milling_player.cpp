// SPDX-License-Identifier: MIT
#include <kibori/run/milling_player.h>

#include <algorithm>
#include <vector>

namespace kibori {

MillPlayer::MillPlayer(const MillTape& tape, int threads)
    : tape_(tape), threads_(threads), model_(tape.key_before(0).model, tape.material_bounds()) {}

MillMoment MillPlayer::moment(double seconds) const {
  const size_t index = tape_.move_at(seconds);
  const std::vector<MillTapeMove> move = tape_.moves(index, 1);
  if (move.empty() || !(move.front().seconds > 0)) return {index, 0};
  return {index, std::clamp((seconds - move.front().start_s) / move.front().seconds, 0.0, 1.0)};
}

double MillPlayer::seconds() const {
  if (!move_) return 0;
  return at_.share > 0 ? move_->start_s + at_.share * move_->seconds : move_->end_s();
}

int MillPlayer::tool() const {
  if (move_) return move_->tool;
  const std::vector<MillTapeMove> first = tape_.moves(0, 1);
  return first.empty() ? -1 : first.front().tool;
}

std::optional<Pose> MillPlayer::pose() const {
  if (move_) return move_->motion.at(at_.share > 0 ? at_.share : 1);
  const std::vector<MillTapeMove> first = tape_.moves(0, 1);
  return first.empty() ? std::nullopt : std::optional(first.front().motion.start);
}

void MillPlayer::restore(const MillTape::Key& key) {
  whole_.reset();
  model_.restore(key.model);
  at_ = {key.moves, 0};
}

Result<bool> MillPlayer::go(const MillMoment& to) {
  if (to == at_) return true;
  // What is cut of a move stays, if more of the same move follows.
  if (whole_ && !(to.moves == at_.moves && to.share >= at_.share)) {
    model_.restore(*whole_);
    whole_.reset();
    at_.share = 0;
  }
  if (const MillTape::Key key = tape_.key_before(to.moves);
      to.moves < at_.moves || key.moves > at_.moves)
    restore(key);
  if (at_.moves < to.moves)
    if (Status ok = cut_whole(std::min(kBatch, to.moves - at_.moves)); !ok)
      return Error{ok.error()};
  if (at_.moves == to.moves && to.share > at_.share)
    if (Status ok = cut_share(to.share); !ok) return Error{ok.error()};
  const size_t shown = at_.share > 0 ? at_.moves + 1 : at_.moves;
  move_.reset();
  if (shown > 0)
    if (const auto move = tape_.moves(shown - 1, 1); !move.empty()) move_ = move.front();
  return at_ == to;
}

Status MillPlayer::cut_whole(size_t count) {
  Sweeps sweeps;
  for (const MillTapeMove& move : tape_.moves(at_.moves, count)) {
    if (Status ok = add(sweeps, move, 0, 1); !ok) return ok;
    if (sweeps.tools.size() >= kMaxSweeps) cut(sweeps);
  }
  cut(sweeps);
  at_ = {at_.moves + count, 0};
  return Ok{};
}

Status MillPlayer::cut_share(double share) {
  const std::vector<MillTapeMove> move = tape_.moves(at_.moves, 1);
  if (move.empty()) return Ok{};
  Sweeps sweeps;
  if (Status ok = add(sweeps, move.front(), at_.share, share); !ok) return ok;
  if (!whole_) whole_ = model_.snapshot();
  cut(sweeps);
  at_.share = share;
  return Ok{};
}

void MillPlayer::cut(Sweeps& sweeps) {
  cut_batch(model_, sweeps.cuts, {threads_});
  sweeps = {};
}

// A whole move has the same sweeps as in MillRun::sweep.
Status MillPlayer::add(Sweeps& to, const MillTapeMove& move, double begin, double end) {
  if (move.tool < 0) return Ok{};
  const Lattice& lattice = model_.lattice();
  while (tools_.size() <= static_cast<size_t>(move.tool))
    tools_.push_back(tape_.tool(static_cast<int>(tools_.size())).cutter);
  const Tool& cutter = tools_[static_cast<size_t>(move.tool)];
  ToolMotion motion = move.motion.part(end);
  if (begin > 0) {
    motion.start = move.motion.at(begin);
    motion.travel_mm = move.motion.travel_mm * (end - begin);
    motion.turn_rad = move.motion.turn_rad * (end - begin);
  }
  const Result<int> steps = substeps_of(cutter, motion, lattice);
  if (!steps) return Error{steps.error()};
  const int n = steps.value();
  const Box whole = lattice.whole().units.grown(1);
  for (int i = 0; i < n; i++) {
    const Pose start = motion.substep(i, n);
    const Vec3 travel = motion.travel_mm / n;
    const Solid& solid =
        to.tools.emplace_back(cutter, start, travel, lattice, move.clear && begin == 0 && i == 0)
            .solid();
    const Box box = solid.bounds().units;
    if (!((box.min.array() < whole.max.array()).all() &&
          (box.max.array() > whole.min.array()).all()))
      continue;
    BatchCut& cut = to.cuts.emplace_back();
    cut.solid = &solid;
    cut.reference = lattice.to_lattice(start.tip + travel);
  }
  return Ok{};
}

}  // namespace kibori
