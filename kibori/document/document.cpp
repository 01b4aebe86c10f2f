// SPDX-License-Identifier: MIT
// The tree of steps: strokes into it, and back and forth in it.
#include <kibori/base/hash.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

#include <algorithm>

namespace kibori {
namespace {

// So long a flush keeps tiles, so that ticks never wait long behind them.
constexpr auto kTilesAtOnce = std::chrono::milliseconds(10);
constexpr size_t kTicksABlock = 65536;
// States held in memory, and the memory that the model then may take; those not visited for longest
// go first, and are made again from the file when asked for.
constexpr size_t kMinStates = 64, kMaxStates = 2048, kMaxBytes = size_t{512} << 20;

}  // namespace

Result<std::vector<StepId>> Document::path_to(StepId step) const {
  std::vector<StepId> path;
  for (auto at = steps_.find(step); at != steps_.end(); at = steps_.find(at->second.parent))
    path.push_back(at->first);
  if (path.empty()) return wrong("has no step " + std::to_string(step));
  std::reverse(path.begin(), path.end());
  return path;
}

Result<StepId> Document::find(const std::string& name) const {
  if (const auto found = versions_.find(name); found != versions_.end()) return found->second;
  char* end = nullptr;
  const long long id = std::strtoll(name.c_str(), &end, 10);
  if (!name.empty() && *end == 0 && steps_.count(id)) return StepId{id};
  return wrong("has no version or step '" + sanitize_message(name) + "'; it has steps 1 to " +
               std::to_string(steps_.rbegin()->first));
}

Status Document::check_finished(StepId step) const {
  const auto found = steps_.find(step);
  if (found == steps_.end()) return wrong("has no step " + std::to_string(step));
  if (!found->second.finished)
    return wrong("step " + std::to_string(step) + " is still being made");
  return Ok{};
}

Status Document::name_version(const std::string& name, StepId step) {
  if (name.empty() || name.find_first_not_of("0123456789") == std::string::npos)
    return wrong("a version's name can't be a number or nothing");
  if (Status s = check_finished(step); !s) return s;
  Status kept = commit("naming a version", [&]() -> Status {
    Result<Statement> put =
        storage_->database.prepare("INSERT OR REPLACE INTO version VALUES (?, ?)");
    if (!put) return Error{put.error()};
    if (Status s = put.value().bind(name).bind(step).run(); !s) return s;
    return seal_versions();
  });
  if (kept) versions_[name] = step;
  return kept;
}

Status Document::write_head(StepId step) {
  Result<Statement> put =
      storage_->database.prepare("UPDATE meta SET value = ? WHERE key = 'head'");
  return put ? put.value().bind(step).run() : Status(Error{put.error()});
}

Status Document::set_head(StepId step) {
  // Who only reads goes where it wants for itself.
  if (writes_)
    if (Status s = commit("moving in the history", [&] { return write_head(step); }); !s) return s;
  head_ = step;
  return Ok{};
}

void Document::remember(StepId step, const Snapshot& state) {
  // Of another model.
  if (!states_.empty() && !states_.begin()->second.of_same_model(state)) return;
  states_[step] = state;
  std::erase(visited_, step);
  visited_.push_back(step);
  while (visited_.size() > kMaxStates ||
         (visited_.size() > kMinStates && state.memory_bytes() > kMaxBytes)) {
    const auto oldest = states_.find(visited_.front());
    oldest->second.drop_shared();
    states_.erase(oldest);
    visited_.erase(visited_.begin());
  }
}

// ---- History

Status Document::rebuild(TriDexel& model, StepId step,
                         const std::function<void(StepId, const Snapshot&)>& remember) const {
  std::vector<StepId> carved_again;
  StepId begin = step;
  for (; !state_of(begin) && !is_checkpoint(begin); begin = steps_.at(begin).parent)
    carved_again.push_back(begin);
  if (const Snapshot* const state = state_of(begin))
    model.restore(*state);
  else if (Status s = go_by_tiles(model, begin); !s)
    return s;
  if (Status s = check_state(begin, model.snapshot()); !s) return s;
  remember(begin, model.snapshot());
  for (auto next = carved_again.rbegin(); next != carved_again.rend(); ++next) {
    if (Status s = replay(*next, model, std::nullopt, {}); !s) return s;
    if (Status s = check_state(*next, model.snapshot()); !s) return s;
    remember(*next, model.snapshot());
  }
  return Ok{};
}

Result<std::unique_ptr<TriDexel>> Document::load() {
  states_.clear();
  visited_.clear();
  tiles_.clear();
  auto model = std::make_unique<TriDexel>(lattice_);
  const Status made = rebuild(*model, head_, [&](StepId at, const Snapshot& state) {
    remember(at, state);
    wait_for_tiles(at, state, model->material_bounds());
  });
  if (!made) return Error{made.error()};
  return model;
}

Result<Document::Checkout> Document::checkout(StepId step) const {
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  Checkout to;
  to.step = step;
  if (const Snapshot* const known = state_of(step)) {
    to.state = to.states[step] = *known;
    to.material_bounds = material_bounds_;
    return to;
  }
  if (states_.empty()) return wrong("no model of it is worked on");
  TriDexel beside(states_.begin()->second, material_bounds_);
  const Status made = rebuild(beside, step, [&](StepId at, const Snapshot& state) {
    to.states[at] = state;
    if (to.states.size() > kMaxStates) {
      to.states.begin()->second.drop_shared();
      to.states.erase(to.states.begin());
    }
  });
  if (!made) return Error{made.error()};
  to.state = beside.snapshot();
  to.material_bounds = beside.material_bounds();
  return to;
}

Status Document::commit_checkout(const Checkout& to) {
  const StepId from = head_;
  if (Status s = set_head(to.step); !s) return s;
  material_bounds_.include(to.material_bounds);
  for (const auto& [step, state] : to.states) remember(step, state);
  // All the way back, so that redo comes the same way.
  std::vector<StepId> way;
  StepId at = from;
  for (; at > to.step; at = steps_[at].parent) way.push_back(at);
  if (at == to.step)
    for (const StepId step : way) last_child_[steps_[step].parent] = step;
  return Ok{};
}

Result<std::unique_ptr<TriDexel>> Document::load_at(StepId step) const {
  auto model = std::make_unique<TriDexel>(lattice_);
  if (const Status s = make_state(*model, step); !s) return Error{s.error()};
  return model;
}

Status Document::go(TriDexel& model, StepId step) {
  if (open_step_ != 0) return wrong("a stroke is being made; finish or cancel it first");
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  const Snapshot before = model.snapshot();
  Checkout to;
  to.step = step;
  Status done =
      rebuild(model, step, [&](StepId at, const Snapshot& state) { to.states[at] = state; });
  to.material_bounds = model.material_bounds();
  if (done) done = commit_checkout(to);
  if (!done) model.restore(before);
  return done;
}

Result<StepId> Document::before_head() const {
  const StepId parent = steps_.at(head_).parent;
  if (parent == 0) return wrong("there is nothing before the stock");
  return parent;
}

Result<StepId> Document::after_head() const {
  if (const auto last = last_child_.find(head_); last != last_child_.end()) return last->second;
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
    if (step->second.parent == head_ && step->second.finished) return step->first;
  return wrong("nothing follows step " + std::to_string(head_));
}

Status Document::undo(TriDexel& model) {
  const Result<StepId> to = before_head();
  return to ? go(model, to.value()) : Status(Error{to.error()});
}

Status Document::redo(TriDexel& model) {
  const Result<StepId> to = after_head();
  return to ? go(model, to.value()) : Status(Error{to.error()});
}

// ---- Strokes

Status Document::begin(const StrokeSettings& settings, const Pose& start,
                       const std::string& label) {
  if (!writes_) return wrong("is open for reading only");
  if (open_step_ != 0) return wrong("a stroke is being made already");
  // What could not be read again is not written.
  const std::string json = settings_to_json(settings);
  if (const auto pose = decode_pose(encode_pose(start)); !pose)
    return wrong("keeping a stroke: " + pose.error());
  if (const auto read = settings_from_json(json); !read)
    return wrong("keeping a stroke: " + read.error());
  Step begun;
  Status kept = commit("beginning a stroke", [&]() -> Status {
    Result<Statement> setting =
        storage_->database.prepare("INSERT OR IGNORE INTO setting (json) VALUES (?)");
    if (!setting) return Error{setting.error()};
    if (Status s = setting.value().bind(json).run(); !s) return s;
    Result<Statement> step = storage_->database.prepare(
        "INSERT INTO step (parent, kind, label, setting, start) VALUES (?, 'stroke', ?, (SELECT id "
        "FROM "
        "setting WHERE json = ?), ?) RETURNING id, setting, CAST(strftime('%s', made_at) AS "
        "INTEGER)");
    if (!step) return Error{step.error()};
    const Result<bool> row =
        step.value().bind(head_).bind(label).bind(json).bind(encode_pose(start)).row();
    if (!row) return Error{row.error()};
    begun.id = step.value().integer(0);
    begun.setting = step.value().integer(1);
    begun.made_s = step.value().integer(2);
    return Ok{};
  });
  if (!kept) return kept;
  open_step_ = begun.id;
  open_sequence_ = saved_ticks_ = 0;
  waiting_.clear();
  waiting_forces_.clear();
  all_felt_ = true;
  begun.parent = head_;
  begun.label = label;
  begun.finished = false;
  steps_[begun.id] = begun;
  return Ok{};
}

Status Document::write_ticks(int64_t& sequence) {
  sequence = open_sequence_;
  for (const StrokeTick& tick : waiting_)
    if (!tick.tip.allFinite() || !tick.turn.allFinite() || !tick.hand.allFinite() ||
        !tick.hand_turn.allFinite())
      return Error{"a tick of the stroke has a number that is not finite"};
  Result<Statement> tick = storage_->database.prepare("INSERT INTO tick VALUES (?, ?, ?, ?)");
  if (!tick) return Error{tick.error()};
  Result<Statement> force = storage_->database.prepare("INSERT INTO force VALUES (?, ?, ?, ?)");
  if (!force) return Error{force.error()};
  const auto put = [&](Statement& into, size_t count, const Bytes& data) {
    return into.bind(open_step_).bind(sequence).bind(static_cast<int64_t>(count)).bind(data).run();
  };
  for (size_t from = 0; from < waiting_.size(); from += kTicksABlock, sequence++) {
    const size_t count = std::min(kTicksABlock, waiting_.size() - from);
    if (Status s = put(tick.value(), count, encode_ticks(&waiting_[from], count)); !s) return s;
    if (!all_felt_) continue;
    if (Status s = put(force.value(), count, encode_forces(&waiting_forces_[from], count)); !s)
      return s;
  }
  if (all_felt_ || open_sequence_ == 0) return Ok{};
  // Some were felt, and others not.
  Result<Statement> drop = storage_->database.prepare("DELETE FROM force WHERE step = ?");
  return drop ? drop.value().bind(open_step_).run() : Status(Error{drop.error()});
}

Status Document::flush() {
  if (open_step_ == 0 || waiting_.empty()) {
    keep_some_tiles(kTilesAtOnce);
    return Ok{};
  }
  int64_t sequence = 0;
  Status kept = commit("saving", [&] { return write_ticks(sequence); });
  if (!kept) return kept;
  open_sequence_ = sequence;
  saved_ticks_ += static_cast<int64_t>(waiting_.size());
  waiting_.clear();
  waiting_forces_.clear();
  keep_some_tiles(kTilesAtOnce);
  return Ok{};
}

Status Document::finish(const Snapshot& now, const LatticeBox& material_bounds,
                        double removed_mm3) {
  if (open_step_ == 0) return wrong("no stroke is being made");
  Step step = steps_[open_step_];
  step.ticks = saved_ticks_ + static_cast<int64_t>(waiting_.size());
  step.removed_mm3 = removed_mm3;
  step.hash = now.content_hash();
  step.finished = true;
  Status kept = commit("finishing a stroke", [&]() -> Status {
    int64_t sequence = 0;
    if (Status s = write_ticks(sequence); !s) return s;
    Result<Statement> update = storage_->database.prepare(
        "UPDATE step SET finished = 1, ticks = ?, removed_mm3 = ?, hash = ? WHERE id = ?");
    if (!update) return Error{update.error()};
    if (Status s = update.value()
                       .bind(step.ticks)
                       .bind(removed_mm3)
                       .bind(hash_text(step.hash))
                       .bind(step.id)
                       .run();
        !s)
      return s;
    if (Status s = seal(step.id); !s) return s;
    return write_head(step.id);
  });
  if (!kept) return kept;
  steps_[step.id] = step;
  last_child_.erase(step.parent);
  head_ = step.id;
  open_step_ = 0;
  waiting_.clear();
  waiting_forces_.clear();
  remember(step.id, now);
  wait_for_tiles(step.id, now, material_bounds);
  return Ok{};
}

Status Document::cancel() {
  if (open_step_ == 0) return wrong("no stroke is being made");
  const StepId id = open_step_;
  Status kept = commit("cancelling a stroke", [&]() -> Status {
    for (const char* sql : {"DELETE FROM tick WHERE step = ?", "DELETE FROM force WHERE step = ?",
                            "DELETE FROM step WHERE id = ?"}) {
      Result<Statement> drop = storage_->database.prepare(sql);
      if (!drop) return Error{drop.error()};
      if (Status s = drop.value().bind(id).run(); !s) return s;
    }
    return Ok{};
  });
  if (!kept) return kept;
  steps_.erase(id);
  open_step_ = 0;
  waiting_.clear();
  waiting_forces_.clear();
  return Ok{};
}

Status Document::set_thumbnail(StepId step, const Bytes& png) {
  if (Status s = check_finished(step); !s) return s;
  Status kept = commit("keeping a thumbnail", [&]() -> Status {
    Result<Statement> put =
        storage_->database.prepare("INSERT OR REPLACE INTO thumbnail VALUES (?, ?)");
    if (!put) return Error{put.error()};
    return put.value().bind(step).bind(png).run();
  });
  if (kept) steps_[step].pictured = true;
  return kept;
}

Result<Bytes> Document::thumbnail(StepId step) const {
  if (version_ < 2) return Bytes();
  Result<Statement> read = storage_->database.prepare("SELECT png FROM thumbnail WHERE step = ?");
  if (!read) return failed("reading a thumbnail", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a thumbnail", row.error());
  return row.value() ? read.value().bytes(0) : Bytes();
}

}  // namespace kibori
