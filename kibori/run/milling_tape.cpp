// SPDX-License-Identifier: MIT
#include <kibori/run/milling_tape.h>

#include <algorithm>
#include <utility>

namespace kibori {

void MillTape::begin(const TriDexel& model) {
  const std::scoped_lock lock(mutex_);
  keys_ = {{0, model.snapshot()}};
  bounds_ = model.material_bounds();
}

void MillTape::begin_run() {
  first_program_ = programs_;
  first_collision_ = collisions_.size();
  first_tool_ = tools_.size();
  collision_moves_.clear();
  machine_s_ = 0;
}

int MillTape::tool_index(const MillTool& tool) {
  const std::scoped_lock lock(mutex_);
  for (size_t i = first_tool_; i < tools_.size(); i++)
    if (tools_[i].number == tool.number) return static_cast<int>(i);
  tools_.push_back(tool);
  return static_cast<int>(tools_.size() - 1);
}

size_t MillTape::add(MillTapeMove move) {
  const double end_s = move.end_s(), wait_s = std::max(0.0, move.start_s - machine_s_);
  machine_s_ = end_s;
  move.program = programs_ - 1;
  move.start_s = time_s_ + wait_s;
  if (!(move.seconds > 0)) move.seconds = move.motion.travel_mm.norm() / kUnknownSpeed;
  time_s_ = move.end_s();
  pending_.push_back(move);
  return added_++;
}

void MillTape::press(size_t move, const CuttingForce& force) {
  MillTapeMove& at = pending(move);
  at.force_n = std::max(at.force_n, force.force_n);
  at.power_w = std::max(at.power_w, force.power_w);
}

void MillTape::keep(const TriDexel& model, const std::vector<MillCollision>& collisions) {
  const std::scoped_lock lock(mutex_);
  moves_.insert(moves_.end(), pending_.begin(), pending_.end());
  pending_.clear();
  if (added_ > kept_) keys_.push_back({added_, model.snapshot()});
  kept_ = added_;
  collisions_.resize(first_collision_);
  for (size_t i = 0; i < collision_moves_.size(); i++) {
    collisions_.push_back({collisions[i], collision_moves_[i]});
    collisions_.back().met.program += static_cast<size_t>(first_program_);
  }
  thin_out(model);
}

// Drops every second snapshot, but neither the first nor the last one.
void MillTape::thin_out(const TriDexel& model) {
  if (keys_.size() <= 3 ||
      (keys_.size() <= kMaxKeys && model.snapshot().memory_bytes() <= kMaxBytes))
    return;
  std::vector<Key> kept;
  for (size_t i = 0; i < keys_.size(); i++)
    if (i % 2 == 0 || i + 1 == keys_.size()) kept.push_back(std::move(keys_[i]));
  keys_ = std::move(kept);
  interval_ *= 2;
}

void MillTape::finish(const std::string& error) {
  const std::scoped_lock lock(mutex_);
  done_ = true;
  error_ = error;
}

MillTape::State MillTape::state() const {
  const std::scoped_lock lock(mutex_);
  return {moves_.size(), moves_.empty() ? 0 : moves_.back().end_s(), collisions_.size(), done_,
          error_};
}

std::vector<MillTapeMove> MillTape::moves(size_t from, size_t count) const {
  const std::scoped_lock lock(mutex_);
  from = std::min(from, moves_.size());
  const auto begin = moves_.begin() + static_cast<std::ptrdiff_t>(from);
  return {begin, begin + static_cast<std::ptrdiff_t>(std::min(count, moves_.size() - from))};
}

std::vector<MillTape::Collision> MillTape::collisions() const {
  const std::scoped_lock lock(mutex_);
  return collisions_;
}

std::optional<MillTape::Collision> MillTape::collision_after(double seconds) const {
  const std::scoped_lock lock(mutex_);
  for (const Collision& collision : collisions_)
    if (moves_[collision.move].end_s() > seconds) return collision;
  return std::nullopt;
}

size_t MillTape::move_at(double seconds) const {
  const std::scoped_lock lock(mutex_);
  const auto at = std::partition_point(moves_.begin(), moves_.end(), [&](const MillTapeMove& move) {
    return move.end_s() <= seconds;
  });
  return static_cast<size_t>(at - moves_.begin());
}

MillTape::Range MillTape::line_of(size_t move) const {
  const std::scoped_lock lock(mutex_);
  const auto same = [&](size_t other) {
    return moves_[other].line == moves_[move].line && moves_[other].program == moves_[move].program;
  };
  Range range{move, move};
  if (move >= moves_.size()) return range;
  while (range.begin > 0 && same(range.begin - 1)) range.begin--;
  while (range.end < moves_.size() && same(range.end)) range.end++;
  return range;
}

std::optional<MillTape::Range> MillTape::find_line(int program, int line) const {
  std::optional<size_t> best;
  {
    const std::scoped_lock lock(mutex_);
    for (size_t i = 0; i < moves_.size(); i++) {
      const MillTapeMove& move = moves_[i];
      if (move.program != program || move.line < line) continue;
      if (!best || move.line < moves_[*best].line) best = i;
      if (move.line == line) break;
    }
  }
  return best ? std::optional(line_of(*best)) : std::nullopt;
}

MillTape::Key MillTape::key_before(size_t moves) const {
  const std::scoped_lock lock(mutex_);
  const auto after = std::partition_point(keys_.begin(), keys_.end(),
                                          [&](const Key& key) { return key.moves <= moves; });
  return *std::prev(after);
}

LatticeBox MillTape::material_bounds() const {
  const std::scoped_lock lock(mutex_);
  return bounds_;
}

MillTool MillTape::tool(int index) const {
  const std::scoped_lock lock(mutex_);
  return tools_[static_cast<size_t>(index)];
}

MillTape::Curve MillTape::curve(size_t parts) const {
  const std::scoped_lock lock(mutex_);
  Curve curve;
  curve.force_n.resize(parts);
  curve.power_w.resize(parts);
  if (moves_.empty() || parts == 0) return curve;
  curve.seconds = moves_.back().end_s();
  const double per_second = curve.seconds > 0 ? static_cast<double>(parts) / curve.seconds : 0;
  for (const MillTapeMove& move : moves_) {
    if (!(move.force_n > 0)) continue;
    const auto first = static_cast<size_t>(move.start_s * per_second),
               last = static_cast<size_t>(move.end_s() * per_second);
    for (size_t i = first; i <= std::min(last, parts - 1); i++) {
      curve.force_n[i] = std::max(curve.force_n[i], static_cast<float>(move.force_n));
      curve.power_w[i] = std::max(curve.power_w[i], static_cast<float>(move.power_w));
    }
  }
  return curve;
}

}  // namespace kibori
