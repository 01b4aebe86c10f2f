// SPDX-License-Identifier: MIT
// The tree of steps of a document: adding strokes, and moving in the history.
#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

#include <algorithm>

namespace kibori {
namespace {

// Maximum time that a flush spends on tiles, so that ticks never wait long.
constexpr auto kTilesAtOnce = std::chrono::milliseconds(10);
constexpr size_t kTicksABlock = 65536;
// Limits of the number of states in memory, and of the memory that the model may use with them. The
// state whose last visit is the longest ago is dropped first. If it is needed again, it is read
// from the file.
constexpr size_t kMinStates = 64, kMaxStates = 2048, kMaxStateBytes = size_t{256} << 20;

}  // namespace

Error Document::failed(const std::string& doing, const std::string& reason) const {
  return wrong((storage_->database.is_malformed() ? "is a damaged document: " : "") + doing +
               " failed: " + reason);
}

Result<std::vector<StepId>> Document::path_to(StepId step) const {
  std::vector<StepId> path;
  for (auto at = steps_.find(step); at != steps_.end(); at = steps_.find(at->second.parent))
    path.push_back(at->first);
  if (path.empty()) return wrong("has no step " + std::to_string(step));
  std::reverse(path.begin(), path.end());
  return path;
}

Result<StepId> Document::find(const std::string& name) const {
  if (const auto found = versions_.find(name); found != versions_.end()) {
    if (!versions_changed_) return found->second;
    return wrong(
        "is a damaged document: the named versions were changed; give the number of a step");
  }
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
    return wrong("step " + std::to_string(step) + " is not finished yet");
  return Ok{};
}

Status Document::name_version(const std::string& name, StepId step) {
  if (name.empty() || name.find_first_not_of("0123456789") == std::string::npos)
    return wrong("a version's name must not be empty or a number");
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

Status Document::set_head(StepId step) {
  // A reader moves only its own head, not that of the file.
  if (writes_)
    if (Status s = commit("moving in the history", [&] { return write_head(step); }); !s) return s;
  head_ = step;
  active_ = active_at(step);
  return Ok{};
}

void Document::remember(StepId step, const BodyList& state) {
  // Ignore the state of another model.
  const Snapshot& model = state.all.front().model;
  if (!states_.empty() && !states_.begin()->second.all.front().model.of_same_model(model)) return;
  states_[step] = state;
  std::erase(visited_, step);
  visited_.push_back(step);
  while (visited_.size() > kMaxStates ||
         (visited_.size() > kMinStates && model.memory_bytes() > kMaxStateBytes)) {
    const auto oldest = states_.find(visited_.front());
    for (Body& body : oldest->second.all) body.model.drop_shared();
    states_.erase(oldest);
    visited_.erase(visited_.begin());
  }
}

// ---- History

Result<BodyList> Document::rebuild(
    TriDexel& work, StepId step,
    const std::function<void(StepId, const BodyList&)>& remember) const {
  std::vector<StepId> done_again;
  StepId begin = step;
  for (; !state_of(begin) && !is_checkpoint(begin); begin = steps_.at(begin).parent)
    done_again.push_back(begin);
  Result<BodyList> found =
      state_of(begin) ? Result<BodyList>(*state_of(begin)) : go_by_tiles(work, begin);
  if (!found) return found;
  take_model(work, found.value(), active_at(begin));
  Workbench bench(work, std::move(found).value(), active_at(begin));
  if (Status s = check_state(begin, bench.bodies()); !s) return Error{s.error()};
  remember(begin, bench.bodies());
  for (auto next = done_again.rbegin(); next != done_again.rend(); ++next) {
    if (Status s = replay(*next, bench, std::nullopt, {}); !s) return Error{s.error()};
    if (Status s = check_state(*next, bench.bodies()); !s) return Error{s.error()};
    remember(*next, bench.bodies());
  }
  if (Status s = bench.activate(active_at(step)); !s) return Error{s.error()};
  return bench.bodies();
}

Result<std::unique_ptr<TriDexel>> Document::load() {
  if (const std::string fault = row_fault(head_); !fault.empty())
    return wrong("is a damaged document: " + fault);
  states_.clear();
  visited_.clear();
  tiles_.clear();
  auto model = std::make_unique<TriDexel>(lattice_);
  const Result<BodyList> made = rebuild(*model, head_, [&](StepId at, const BodyList& state) {
    remember(at, state);
    wait_for_tiles(at, state);
  });
  if (!made) return Error{made.error()};
  active_ = active_at(head_);
  return model;
}

Result<Document::Checkout> Document::checkout(StepId step) const {
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  Checkout to;
  to.step = step;
  to.active = step == head_ ? active_ : active_at(step);
  if (const BodyList* const known = state_of(step)) {
    to.bodies = to.states[step] = *known;
  } else {
    if (states_.empty()) return wrong("none of its models is loaded");
    TriDexel scratch(states_.begin()->second.all.front().model, material_bounds_);
    Result<BodyList> made = rebuild(scratch, step, [&](StepId at, const BodyList& state) {
      to.states[at] = state;
      if (to.states.size() > kMaxStates) {
        for (Body& body : to.states.begin()->second.all) body.model.drop_shared();
        to.states.erase(to.states.begin());
      }
    });
    if (!made) return Error{made.error()};
    to.bodies = std::move(made).value();
  }
  to.state = to.bodies.find(to.active)->model;
  to.material_bounds = material_bounds_;
  for (const Body& body : to.bodies.all) to.material_bounds.include(body.material_bounds);
  return to;
}

Status Document::commit_checkout(const Checkout& to) {
  const StepId from = head_;
  if (Status s = set_head(to.step); !s) return s;
  active_ = to.active;
  material_bounds_.include(to.material_bounds);
  for (const auto& [step, state] : to.states) remember(step, state);
  // Marks the whole path, so that redo returns along it.
  std::vector<StepId> path;
  StepId at = from;
  for (; at > to.step; at = steps_[at].parent) path.push_back(at);
  if (at == to.step)
    for (const StepId step : path) last_child_[steps_[step].parent] = step;
  return Ok{};
}

std::string Document::path_fault(StepId step) const {
  for (auto at = steps_.find(step); at != steps_.end(); at = steps_.find(at->second.parent))
    if (const auto broken = broken_.find(at->first); broken != broken_.end()) return broken->second;
  return {};
}

std::string Document::row_fault(StepId step) const {
  return step == head_ && head_lost_ ? damage() : path_fault(step);
}

Status Document::check_rows(StepId step) const {
  const std::string fault = row_fault(step);
  if (fault.empty()) return Ok{};
  return wrong("is a damaged document: " + fault + "; 'kibori history " + name() +
               " --salvage NEW.kibori' saves the undamaged steps");
}

Result<std::unique_ptr<TriDexel>> Document::load_stock() const {
  auto model = std::make_unique<TriDexel>(lattice_);
  if (const Result<BodyList> made = make_state(*model, steps_.begin()->first); !made)
    return Error{made.error()};
  return model;
}

Result<std::unique_ptr<TriDexel>> Document::load_at(StepId step) const {
  if (const std::string fault = row_fault(step); !fault.empty())
    return wrong("is a damaged document: " + fault);
  auto model = std::make_unique<TriDexel>(lattice_);
  if (const Result<BodyList> made = make_state(*model, step); !made) return Error{made.error()};
  return model;
}

Result<BodyList> Document::load_bodies(StepId step) const {
  if (const std::string fault = row_fault(step); !fault.empty())
    return wrong("is a damaged document: " + fault);
  TriDexel work(lattice_);
  return make_state(work, step);
}

Status Document::go(TriDexel& model, StepId step) {
  if (open_step_ != 0) return wrong("a stroke is in progress; finish or cancel it first");
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  const Snapshot before = model.snapshot();
  Checkout to;
  to.step = step;
  to.active = active_at(step);
  const Result<BodyList> made =
      rebuild(model, step, [&](StepId at, const BodyList& state) { to.states[at] = state; });
  to.material_bounds = model.material_bounds();
  Status done = made ? commit_checkout(to) : Status(Error{made.error()});
  if (!done) model.restore(before);
  return done;
}

Result<StepId> Document::before_head() const {
  const StepId parent = steps_.at(head_).parent;
  if (parent == 0) return wrong("there is no step before the stock");
  return parent;
}

Result<StepId> Document::after_head() const {
  if (const auto last = last_child_.find(head_); last != last_child_.end()) return last->second;
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step)
    if (step->second.parent == head_ && step->second.finished) return step->first;
  return wrong("there is no step after step " + std::to_string(head_));
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
  if (!writes_) return wrong("is open read-only");
  if (open_step_ != 0) return wrong("a stroke is already in progress");
  const Body* const body = bodies_at(head_).find(settings.body);
  if (!body) return wrong("has no body " + std::to_string(settings.body));
  if (body->locked)
    return wrong("body '" + sanitize_message(body->name) + "' is locked; unlock it first");
  if (body->no_go)
    return wrong("body '" + sanitize_message(body->name) +
                 "' is protected; allow cuts in it first");
  const std::vector<Body>& all = bodies_at(head_).all;
  const bool protects = std::any_of(all.begin(), all.end(), [&](const Body& other) {
    return other.no_go && other.id != settings.body;
  });
  if (const Status fine = check_modes(settings.mode, settings.second_mode(), protects); !fine)
    return wrong(fine.error());
  // Data that cannot be read back is not written.
  const std::string json = settings_to_json(settings);
  if (const auto pose = decode_pose(encode_pose(start)); !pose)
    return wrong("the stroke cannot be stored: " + pose.error());
  if (const auto read = settings_from_json(json); !read)
    return wrong("the stroke cannot be stored: " + read.error());
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
  drop_waiting();
  forces_.all = given_.all = true;
  begun.parent = head_;
  begun.label = label;
  begun.finished = false;
  begun.body = active_ = settings.body;
  steps_[begun.id] = begun;
  return Ok{};
}

Status Document::write_ticks(int64_t& sequence) {
  sequence = open_sequence_;
  for (const RecordedTick& tick : waiting_)
    if (!is_finite(tick)) return Error{"a tick of the stroke has a number that is not finite"};
  Result<Statement> tick = storage_->database.prepare("INSERT INTO tick VALUES (?, ?, ?, ?)");
  if (!tick) return Error{tick.error()};
  for (size_t from = 0; from < waiting_.size(); from += kTicksABlock, sequence++) {
    const size_t count = std::min(kTicksABlock, waiting_.size() - from);
    const auto put = [&](Statement& into, const Bytes& data) {
      return into.bind(open_step_)
          .bind(sequence)
          .bind(static_cast<int64_t>(count))
          .bind(data)
          .run();
    };
    if (Status s = put(tick.value(), encode_ticks(&waiting_[from], count)); !s) return s;
    for (const WaitingForces* const forces : {&forces_, &given_}) {
      if (!forces->all) continue;
      const std::string sql = std::string("INSERT INTO ") + forces->table + " VALUES (?, ?, ?, ?)";
      Result<Statement> row = storage_->database.prepare(sql.c_str());
      if (!row) return Error{row.error()};
      if (Status s = put(row.value(), encode_forces(&forces->rows[from], count)); !s) return s;
    }
  }
  if (open_sequence_ == 0) return Ok{};
  for (const WaitingForces* const forces : {&forces_, &given_}) {
    if (forces->all) continue;
    // If only some ticks have a force, the step stores none.
    const std::string sql = std::string("DELETE FROM ") + forces->table + " WHERE step = ?";
    Result<Statement> drop = storage_->database.prepare(sql.c_str());
    if (!drop) return Error{drop.error()};
    if (Status s = drop.value().bind(open_step_).run(); !s) return s;
  }
  return Ok{};
}

void Document::drop_waiting() {
  waiting_.clear();
  forces_.rows.clear();
  given_.rows.clear();
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
  drop_waiting();
  keep_some_tiles(kTilesAtOnce);
  return Ok{};
}

Status Document::finish(const Snapshot& now, const LatticeBox& material_bounds, double removed_mm3,
                        const std::vector<Portion>& severed) {
  if (open_step_ == 0) return wrong("no stroke is in progress");
  Step step = steps_[open_step_];
  const BodyList& listed = bodies_at(head_);
  const BodyList* const state = state_of(head_);
  if (!state && listed.all.size() > 1) return wrong("none of its models is loaded");
  BodyList after = state ? *state : listed;
  Body& worked_on = *after.find(step.body);
  worked_on.model = now;
  worked_on.material_bounds = material_bounds;
  add_bodies(after, worked_on.pose, severed);
  step.ticks = saved_ticks_ + static_cast<int64_t>(waiting_.size());
  step.removed_mm3 = removed_mm3;
  step.hash = after.content_hash();
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
    if (!severed.empty())
      if (Status s = write_bodies(step.id, after); !s) return s;
    if (Status s = seal(step.id); !s) return s;
    return write_head(step.id);
  });
  if (!kept) return kept;
  steps_[step.id] = step;
  if (!severed.empty()) list(step.id, after);
  last_child_.erase(step.parent);
  head_ = step.id;
  open_step_ = 0;
  drop_waiting();
  remember(step.id, after);
  wait_for_tiles(step.id, after);
  return Ok{};
}

void Document::list(StepId step, BodyList bodies) {
  for (Body& body : bodies.all) {
    body.model = Snapshot();
    body.material_bounds = LatticeBox();
  }
  lists_[step] = std::move(bodies);
}

Status Document::write_bodies(StepId step, const BodyList& bodies) {
  Result<Statement> put = storage_->database.prepare("INSERT OR REPLACE INTO bodies VALUES (?, ?)");
  return put ? put.value().bind(step).bind(bodies_to_json(bodies)).run()
             : Status(Error{put.error()});
}

Result<BodyChange> Document::act(const BodyAction& action, int threads) {
  if (!writes_) return wrong("is open read-only");
  if (open_step_ != 0) return wrong("a stroke is in progress; finish or cancel it first");
  const BodyList* const before = state_of(head_);
  if (!before) return wrong("none of its models is loaded");
  BodyList after = *before;
  Result<BodyChange> change = apply(after, action, threads);
  if (!change) return change;
  const std::string json = action_to_json(action);
  Step step;
  Status kept = commit("storing an action on bodies", [&]() -> Status {
    Result<Statement> setting =
        storage_->database.prepare("INSERT OR IGNORE INTO setting (json) VALUES (?)");
    if (!setting) return Error{setting.error()};
    if (Status s = setting.value().bind(json).run(); !s) return s;
    Result<Statement> put = storage_->database.prepare(
        "INSERT INTO step (parent, kind, setting, removed_mm3, hash, finished) VALUES (?, "
        "'bodies', "
        "(SELECT id FROM setting WHERE json = ?), ?, ?, 1) RETURNING id, setting, "
        "CAST(strftime('%s', made_at) AS INTEGER)");
    if (!put) return Error{put.error()};
    step.hash = after.content_hash();
    const Result<bool> row = put.value()
                                 .bind(head_)
                                 .bind(json)
                                 .bind(change.value().removed_mm3)
                                 .bind(hash_text(step.hash))
                                 .row();
    if (!row) return Error{row.error()};
    step.id = put.value().integer(0);
    step.setting = put.value().integer(1);
    step.made_s = put.value().integer(2);
    if (Status s = write_bodies(step.id, after); !s) return s;
    if (Status s = seal(step.id); !s) return s;
    return write_head(step.id);
  });
  if (!kept) return Error{kept.error()};
  step.parent = head_;
  step.action = true;
  step.body = after.find(active_) ? active_ : after.all.front().id;
  step.removed_mm3 = change.value().removed_mm3;
  steps_[step.id] = step;
  list(step.id, after);
  last_child_.erase(step.parent);
  head_ = step.id;
  active_ = step.body;
  remember(step.id, after);
  wait_for_tiles(step.id, after);
  return change;
}

Status Document::cancel() {
  if (open_step_ == 0) return wrong("no stroke is in progress");
  const StepId id = open_step_;
  Status kept = commit("cancelling a stroke", [&]() -> Status {
    for (const char* sql : {"DELETE FROM tick WHERE step = ?", "DELETE FROM force WHERE step = ?",
                            "DELETE FROM given WHERE step = ?", "DELETE FROM step WHERE id = ?"}) {
      Result<Statement> drop = storage_->database.prepare(sql);
      if (!drop) return Error{drop.error()};
      if (Status s = drop.value().bind(id).run(); !s) return s;
    }
    return Ok{};
  });
  if (!kept) return kept;
  steps_.erase(id);
  open_step_ = 0;
  drop_waiting();
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
