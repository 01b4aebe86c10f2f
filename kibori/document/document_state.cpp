// SPDX-License-Identifier: MIT
// The model of a step: reads its tiles, replays its strokes, and verifies both against the file.
#include <set>
#include <unordered_set>

#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>
#include <kibori/edit/grain.h>
#include <kibori/motion/stroke_player.h>

namespace kibori {
namespace {

// Maximum number of steps whose tiles wait to be stored. If steps come faster, further ones get no
// tiles.
constexpr size_t kMaxWaiting = 256;
// If more steps with tiles than this are between two states, all tiles are read. Otherwise only
// those at changed places.
constexpr size_t kFarAway = 500;

// Converts a body and an axis to the field number of the tile tables, and back.
int64_t field_of(BodyId body, Axis axis) {
  return 3 * (int64_t{body} - 1) + static_cast<int64_t>(axis);
}
int64_t body_of(int64_t field) { return field / 3 + 1; }
Axis axis_of(int64_t field) { return kAxes[static_cast<size_t>(field % 3)]; }

void clear(TriDexel& model) {
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
      for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) field.clear_tile(tu, tv);
  }
}

const Tile* tile_of(const Snapshot* model, Axis axis, int tu, int tv) {
  return model && model->field(axis).has_tile(tu, tv) ? &model->field(axis).tile(tu, tv) : nullptr;
}

Body with_model(Body body, const TriDexel& model) {
  body.model = model.snapshot();
  body.material_bounds = model.material_bounds();
  return body;
}

}  // namespace

// ---- Tiles

void Document::wait_for_tiles(StepId step, const BodyList& now) {
  LatticeBox bounds;
  for (const Body& body : now.all) bounds.include(body.material_bounds);
  material_bounds_.include(bounds);
  // If a later step already stores tiles, this step must not store any: the later tiles are the
  // differences from the last stored state, which is before this step.
  if (!writes_ || is_checkpoint(step) || before_checkpoints_.count(step) ||
      tiles_.size() >= kMaxWaiting)
    return;
  TileJob& job = tiles_.emplace_back();
  job.step = step;
  job.now = now;
  job.bounds = bounds;
}

void Document::add_checkpoint(StepId step, const LatticeBox& bounds) {
  checkpoints_[step] = bounds;
  material_bounds_.include(bounds);
  for (StepId at = steps_.at(step).parent; at != 0 && before_checkpoints_.insert(at).second;)
    at = steps_.at(at).parent;
}

// Finds the tiles of the job that differ from the last stored state before its step. Reads that
// state from the file if it is not in memory. Compares a new or removed body with no material.
Status Document::plan_tiles(TileJob& job) const {
  StepId at = steps_.at(job.step).parent;
  while (at != 0 && !is_checkpoint(at)) at = steps_.at(at).parent;
  BodyList before;
  if (const BodyList* const state = state_of(at)) {
    before = *state;
  } else if (at != 0) {
    TriDexel work(lattice_);
    Result<BodyList> read = read_tiles(at, work);
    if (!read) return Error{read.error()};
    before = std::move(read).value();
  }
  const auto hash = [](const Tile* tile) {
    return tile && !tile->empty ? FieldSnapshot::content_hash(*tile) : 0;
  };
  job.planned = true;
  const auto plan = [&](BodyId body, const Snapshot* was, const Snapshot* is) {
    for (const Axis axis : kAxes) {
      const auto consider = [&](int tu, int tv, const Tile* old_tile, const Tile* new_tile) {
        if (hash(old_tile) != hash(new_tile))
          job.places.push_back(
              {field_of(body, axis), tu, tv, new_tile && !new_tile->empty ? new_tile : nullptr});
      };
      if (was && is && is->of_same_model(*was)) {
        is->field(axis).for_changed_tiles(
            was->field(axis), [&](int tu, int tv, const Tile& old_tile, const Tile& new_tile) {
              consider(tu, tv, &old_tile, &new_tile);
            });
        continue;
      }
      const FieldSnapshot &one = (is ? is : was)->field(axis), &two = (was ? was : is)->field(axis);
      for (int tv = std::min(one.tv_begin(), two.tv_begin());
           tv < std::max(one.tv_end(), two.tv_end()); tv++)
        for (int tu = std::min(one.tu_begin(), two.tu_begin());
             tu < std::max(one.tu_end(), two.tu_end()); tu++)
          consider(tu, tv, tile_of(was, axis, tu, tv), tile_of(is, axis, tu, tv));
    }
  };
  for (const Body& body : job.now.all) {
    const Body* const was = before.find(body.id);
    plan(body.id, was ? &was->model : nullptr, &body.model);
  }
  for (const Body& body : before.all)
    if (!job.now.find(body.id)) plan(body.id, &body.model, nullptr);
  return Ok{};
}

Status Document::keep_tiles(TileJob& job, std::chrono::steady_clock::time_point until) {
  Result<Statement> find = storage_->database.prepare("SELECT id, data FROM tile WHERE hash = ?");
  if (!find) return Error{find.error()};
  Result<Statement> add = storage_->database.prepare("INSERT INTO tile (hash, data) VALUES (?, ?)");
  if (!add) return Error{add.error()};
  for (; job.next < job.places.size(); job.next++) {
    const Tile* const tile = job.places[job.next].tile;
    if (!tile) continue;
    if (job.ids.count(tile)) continue;
    if (std::chrono::steady_clock::now() >= until) return Ok{};
    int64_t id = 0;
    const Bytes data = encode_tile(*tile);
    const int64_t hash = hash_of(data);
    Status looked = find.value().bind(hash).for_rows([&]() -> Status {
      if (find.value().bytes(1) == data) id = find.value().integer(0);
      return Ok{};
    });
    if (!looked) return looked;
    if (id == 0) {
      if (Status s = add.value().bind(hash).bind(data).run(); !s) return s;
      id = storage_->database.last_row();
    }
    job.ids[tile] = id;
  }
  Result<Statement> checkpoint = storage_->database.prepare("INSERT INTO checkpoint VALUES (?, ?)");
  if (!checkpoint) return Error{checkpoint.error()};
  if (Status s = checkpoint.value().bind(job.step).bind(box_to_json(job.bounds)).run(); !s)
    return s;
  Result<Statement> drop = storage_->database.prepare("DELETE FROM checkpoint_tile WHERE step = ?");
  if (!drop) return Error{drop.error()};
  if (Status s = drop.value().bind(job.step).run(); !s) return s;
  Result<Statement> put =
      storage_->database.prepare("INSERT INTO checkpoint_tile VALUES (?, ?, ?, ?, ?)");
  if (!put) return Error{put.error()};
  for (const TilePlace& place : job.places) {
    Statement& p = put.value();
    p.bind(job.step).bind(place.field).bind(int64_t{place.tu}).bind(int64_t{place.tv});
    if (Status s = (place.tile ? p.bind(job.ids.at(place.tile)) : p.bind_null()).run(); !s)
      return s;
  }
  job.done = true;
  return Ok{};
}

void Document::keep_some_tiles(std::chrono::milliseconds max_time) {
  const auto until = std::chrono::steady_clock::now() + max_time;
  while (!tiles_.empty() && std::chrono::steady_clock::now() < until) {
    TileJob& first = tiles_.front();
    Status kept = first.planned ? Status(Ok{}) : plan_tiles(first);
    // A copy, because the results of a failed transaction are discarded.
    TileJob job;
    if (kept)
      kept = commit("storing tiles", [&] {
        job = first;
        return keep_tiles(job, until);
      });
    if (!kept) {
      // The file may be damaged where the tiles would go. Without its tiles, the step is replayed
      // when the user goes to it.
      tiles_.pop_front();
    } else if (job.done) {
      add_checkpoint(job.step, job.bounds);
      tiles_.pop_front();
    } else {
      first = std::move(job);
    }
  }
}

// Returns the newest tile of each place on the path to the step.
Result<Document::TileMap> Document::all_tiles(StepId step) const {
  TileMap tiles;
  Result<std::vector<StepId>> path = path_to(step);
  if (!path) return Error{path.error()};
  Result<Statement> places =
      storage_->database.prepare("SELECT field, u, v, tile FROM checkpoint_tile WHERE step = ?");
  if (!places) return failed("reading tiles", places.error());
  Statement& p = places.value();
  for (const StepId id : path.value()) {
    if (!is_checkpoint(id)) continue;
    const Status done = p.bind(id).for_rows([&]() -> Status {
      tiles[{p.integer(0), p.integer(1), p.integer(2)}] = p.null(3) ? 0 : p.integer(3);
      return Ok{};
    });
    if (!done) return failed("reading tiles", done.error());
  }
  return tiles;
}

Result<BodyList> Document::read_tiles_after(const BodyList& before, StepId step,
                                            TriDexel& work) const {
  TileMap tiles;
  Result<Statement> places =
      storage_->database.prepare("SELECT field, u, v, tile FROM checkpoint_tile WHERE step = ?");
  if (!places) return failed("reading tiles", places.error());
  Statement& p = places.value();
  const Status read = p.bind(step).for_rows([&]() -> Status {
    tiles[{p.integer(0), p.integer(1), p.integer(2)}] = p.null(3) ? 0 : p.integer(3);
    return Ok{};
  });
  if (!read) return failed("reading tiles", read.error());
  return put_bodies(tiles, before, step, checkpoints_.at(step), work);
}

// Returns a box of all material of a step and of earlier steps, if they have tiles.
LatticeBox Document::bounds_at(StepId step) const {
  LatticeBox bounds;
  for (StepId at = step; at != 0; at = steps_.at(at).parent)
    if (const auto checkpoint = checkpoints_.find(at); checkpoint != checkpoints_.end())
      bounds.include(checkpoint->second);
  return bounds;
}

// Returns the bodies of a step: those of `start` with these tiles. `work` allocates their memory.
// `bounds`: a box of their material.
Result<BodyList> Document::put_bodies(const TileMap& tiles, const BodyList& start, StepId step,
                                      const LatticeBox& bounds, TriDexel& work) const {
  BodyList bodies = bodies_at(step);
  for (Body& body : bodies.all) {
    if (const Body* const was = start.find(body.id))
      work.restore(was->model);
    else
      clear(work);
    work.set_lattice(joined(work.lattice(), lattice_holding(lattice_, bounds)));
    work.include_material(bounds);
    if (Status s = put_tiles(tiles, step, body.id, work); !s) return Error{s.error()};
    body = with_model(body, work);
  }
  return bodies;
}

// Returns the newest tile on the path from the stock to `step`, for each place that the steps in
// `path_from` changed.
Result<Document::TileMap> Document::other_tiles(StepId step,
                                                const std::vector<StepId>& path_from) const {
  TileMap tiles;
  auto& database = storage_->database;
  Result<Statement> places =
      database.prepare("SELECT field, u, v FROM checkpoint_tile WHERE step = ?");
  if (!places) return failed("reading tiles", places.error());
  Statement& p = places.value();
  for (const StepId id : path_from) {
    const Status done = p.bind(id).for_rows([&]() -> Status {
      tiles[{p.integer(0), p.integer(1), p.integer(2)}] = 0;
      return Ok{};
    });
    if (!done) return failed("reading tiles", done.error());
  }
  Result<Statement> newest = database.prepare(
      "SELECT step, tile FROM checkpoint_tile WHERE field = ? AND u = ? AND v = ? AND step <= ? "
      "ORDER BY step DESC");
  if (!newest) return failed("reading tiles", newest.error());
  // The numbers of steps of other branches are between those of this path. So the path is followed
  // step by step, as far back as needed.
  StepId known_to = step;
  std::unordered_set<StepId> path_steps = {step};
  const auto on_path = [&](StepId at) {
    if (!is_checkpoint(at)) return false;
    while (known_to > at) path_steps.insert(known_to = steps_.at(known_to).parent);
    return path_steps.count(at) != 0;
  };
  for (auto& [place, tile] : tiles) {
    const auto& [field, u, v] = place;
    Result<Statement>& n = newest;
    n.value().bind(field).bind(u).bind(v).bind(step);
    for (;;) {
      const Result<bool> row = n.value().row();
      if (!row) return failed("reading tiles", row.error());
      if (!row.value()) break;
      if (!on_path(n.value().integer(0))) continue;
      tile = n.value().null(1) ? 0 : n.value().integer(1);
      break;
    }
  }
  return tiles;
}

Result<BodyList> Document::go_by_tiles(TriDexel& work, StepId step) const {
  // Starts at the current step if it has tiles, or at the last step before it that has some. The
  // state of that step must be in memory, and near.
  StepId from = head_;
  while (from != 0 && !is_checkpoint(from)) from = steps_.at(from).parent;
  const BodyList* const start = state_of(from);
  std::vector<StepId> path_steps;
  StepId there = step;
  while (start && from != there && path_steps.size() <= kFarAway) {
    StepId& later = from > there ? from : there;
    if (is_checkpoint(later)) path_steps.push_back(later);
    later = steps_.at(later).parent;
  }
  if (!start || path_steps.size() > kFarAway || version_ < 3) return read_tiles(step, work);
  // One transaction for all tiles. Otherwise SQLite would lock the file for each one.
  auto& database = storage_->database;
  if (writes_) static_cast<void>(database.run("BEGIN"));
  Result<BodyList> there_now = [&]() -> Result<BodyList> {
    const Result<TileMap> tiles = other_tiles(step, path_steps);
    return tiles ? put_bodies(tiles.value(), *start, step, checkpoints_.at(step), work)
                 : Error{tiles.error()};
  }();
  if (writes_) static_cast<void>(database.run("COMMIT"));
  return there_now;
}

Result<BodyList> Document::read_tiles(StepId step, TriDexel& work) const {
  Result<TileMap> tiles = all_tiles(step);
  if (!tiles) return Error{tiles.error()};
  return put_bodies(tiles.value(), BodyList(), step, bounds_at(step), work);
}

Status Document::put_tiles(const TileMap& tiles, StepId step, BodyId body, TriDexel& model) const {
  Result<Statement> read = storage_->database.prepare("SELECT hash, data FROM tile WHERE id = ?");
  if (!read) return failed("reading tiles", read.error());
  const BodyId next_body = bodies_at(step).next;
  // Maps a field and a tile to the first place with that tile.
  std::map<std::pair<int64_t, int64_t>, std::pair<int, int>> first;
  for (const auto& [place, tile] : tiles) {
    const auto& [number, u, v] = place;
    if (number < 0 || (tile != 0 && body_of(number) >= next_body))
      return wrong("is a damaged document: there is no field " + std::to_string(number));
    if (body_of(number) != body) continue;
    Field& field = model.field(axis_of(number));
    const bool near = std::abs(u) < kMaxNodesPerAxis && std::abs(v) < kMaxNodesPerAxis;
    const int tu = near ? static_cast<int>(u) : 0, tv = near ? static_cast<int>(v) : 0;
    if (!near || !field.has_tile(tu, tv)) {
      // A step of another branch had grown the lattice there.
      if (near && tile == 0) continue;
      return wrong("is a damaged document: a tile is outside its lattice");
    }
    if (tile == 0) {
      field.clear_tile(tu, tv);
      continue;
    }
    if (const auto same = first.find({number, tile}); same != first.end()) {
      field.share_tile(tu, tv, same->second.first, same->second.second);
      continue;
    }
    const Result<bool> row = read.value().bind(tile).row();
    if (!row) return failed("reading tiles", row.error());
    if (!row.value())
      return wrong("is a damaged document: tile " + std::to_string(tile) + " is missing");
    const Bytes data = read.value().bytes(1);
    if (hash_of(data) != read.value().integer(0))
      return wrong("is a damaged document: at step " + std::to_string(step) + ", tile " +
                   std::to_string(tile) + " was changed since it was written");
    const Status put = decode_tile(data, field, tu, tv);
    if (!put)
      return wrong("is a damaged document: at step " + std::to_string(step) + ", " + put.error());
    first[{number, tile}] = {tu, tv};
  }
  model.touch();
  return Ok{};
}

Status Document::check_state(StepId step, const BodyList& now) const {
  const Step& written = steps_.at(step);
  // An unfinished stroke of a killed process has no hash.
  if ((!written.finished && written.hash == 0) || now.content_hash() == written.hash) return Ok{};
  return wrong("is a damaged document: step " + std::to_string(step) +
               " was changed since it was written");
}

Result<StepId> Document::last_whole() const {
  const Result<std::vector<StepId>> path = path_to(head_);
  if (!path) return Error{path.error()};
  const std::vector<StepId>& path_steps = path.value();
  const auto whole = [&](size_t i) {
    TriDexel work(lattice_);
    return path_fault(path_steps[i]).empty() && make_state(work, path_steps[i]).ok();
  };
  // A damaged tile affects all later steps until a cut replaces it. The search goes back by growing
  // distances until a step is undamaged. Then it bisects.
  size_t good = 0, bad = path_steps.size();
  for (size_t back = 1;; back *= 2) {
    const size_t at = back < path_steps.size() ? path_steps.size() - back : 0;
    if (whole(at)) {
      good = at;
      break;
    }
    bad = at;
    if (at == 0) return wrong("is a damaged document without an undamaged step");
  }
  while (bad - good > 1) {
    const size_t middle = good + (bad - good) / 2;
    (whole(middle) ? good : bad) = middle;
  }
  return path_steps[good];
}

Status Document::view_step(StepId step) {
  if (writes_) return wrong("is open for writing; use go()");
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  head_ = step;
  head_lost_ = false;
  active_ = active_at(step);
  return Ok{};
}

// Starts from the nearest earlier step with tiles, and replays the steps since then.
Result<BodyList> Document::make_state(TriDexel& work, StepId step) const {
  Result<std::vector<StepId>> path = path_to(step);
  if (!path) return Error{path.error()};
  size_t from = path.value().size();
  while (from > 0 && !is_checkpoint(path.value()[from - 1])) from--;
  if (from == 0) return wrong("is a damaged document: the stock's tiles are missing");
  const StepId begin = path.value()[from - 1];
  Result<BodyList> read = read_tiles(begin, work);
  if (!read) return read;
  take_model(work, read.value(), active_at(begin));
  Workbench bench(work, std::move(read).value(), active_at(begin));
  for (; from < path.value().size(); from++)
    if (Status s = replay(path.value()[from], bench, std::nullopt, {}); !s) return Error{s.error()};
  if (Status s = bench.activate(active_at(step)); !s) return Error{s.error()};
  if (Status s = check_state(step, bench.bodies()); !s) return Error{s.error()};
  return bench.bodies();
}

void Document::take_model(TriDexel& work, const BodyList& bodies, BodyId active) {
  const Body& body = *bodies.find(active);
  work.restore(body.model);
  work.include_material(body.material_bounds);
}

// ---- Bodies

const BodyList& Document::bodies_at(StepId step) const {
  static const BodyList one = [] {
    BodyList bodies;
    bodies.all.emplace_back();
    return bodies;
  }();
  if (lists_.empty()) return one;
  for (StepId at = step; at != 0; at = steps_.at(at).parent)
    if (const auto list = lists_.find(at); list != lists_.end()) return list->second;
  return one;
}

BodyId Document::active_at(StepId step) const {
  const BodyList& bodies = bodies_at(step);
  for (StepId at = step; at != 0; at = steps_.at(at).parent)
    if (const BodyId body = steps_.at(at).body; bodies.find(body)) return body;
  return bodies.all.front().id;
}

Status Document::choose(BodyId body) {
  if (!bodies_at(head_).find(body)) return wrong("has no body " + std::to_string(body));
  active_ = body;
  return Ok{};
}

Result<BodyAction> Document::action(StepId step) const {
  Result<Statement> read = storage_->database.prepare(
      "SELECT json FROM setting WHERE id = (SELECT setting FROM step WHERE id = ?)");
  if (!read) return failed("reading a step", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a step", row.error());
  Result<BodyAction> action = action_from_json(row.value() ? read.value().text(0) : std::string());
  if (!action)
    return wrong("is a damaged document: step " + std::to_string(step) + ": " + action.error());
  return action;
}

// ---- Replay

Result<StrokeSettings> Document::settings(StepId step) const {
  Result<Statement> read = storage_->database.prepare(
      "SELECT json FROM setting WHERE id = (SELECT setting FROM step WHERE id = ?)");
  if (!read) return failed("reading a stroke's settings", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a stroke's settings", row.error());
  const std::string which = "step " + std::to_string(step);
  if (!row.value()) return wrong("is a damaged document: " + which + " has no settings");
  Result<StrokeSettings> settings = settings_from_json(read.value().text(0));
  if (!settings) return wrong("is a damaged document: " + which + ": " + settings.error());
  return settings;
}

Result<Pose> Document::start(StepId step) const {
  Result<Statement> read = storage_->database.prepare("SELECT start FROM step WHERE id = ?");
  if (!read) return failed("reading a stroke", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a stroke", row.error());
  Result<Pose> pose = decode_pose(row.value() ? read.value().bytes(0) : Bytes());
  if (!pose)
    return wrong("is a damaged document: step " + std::to_string(step) + ": " + pose.error());
  return pose;
}

// Calls f(data, count) for the rows of `table` that belong to a step, in order. It is also an error
// if the rows of a finished step differ from its seal.
Status Document::for_blocks(BlockTable table, StepId step,
                            const std::function<Status(const Bytes&, int64_t)>& f) const {
  Result<Statement> read =
      storage_->database.prepare(("SELECT sequence, count, data FROM " +
                                  std::string(name_of(table)) + " WHERE step = ? ORDER BY sequence")
                                     .c_str());
  if (!read) return failed("reading a stroke", read.error());
  Statement& s = read.value();
  int64_t sequence = 0;
  Hash hash;
  Status done = s.bind(step).for_rows([&]() -> Status {
    if (s.integer(0) != sequence++) return Error{"some of its ticks are missing"};
    const Bytes data = s.bytes(2);
    add_block(hash, s.integer(0), s.integer(1), data);
    return f(data, s.integer(1));
  });
  const auto sealed = sealed_blocks_.find(step);
  if (done && sealed != sealed_blocks_.end() && steps_.at(step).finished &&
      hash.value() != sealed->second[static_cast<size_t>(table)])
    done = Error{"its rows of table '" + std::string(name_of(table)) +
                 "' were changed since they were written"};
  if (done) return Ok{};
  return wrong("is a damaged document: step " + std::to_string(step) + ": " + done.error());
}

Status Document::for_ticks(StepId step,
                           const std::function<Status(const std::vector<RecordedTick>&)>& f) const {
  return for_blocks(BlockTable::tick, step, [&](const Bytes& data, int64_t count) -> Status {
    const Result<std::vector<RecordedTick>> ticks = decode_ticks(data);
    if (!ticks) return Error{ticks.error()};
    if (static_cast<int64_t>(ticks.value().size()) != count)
      return Error{"some of its ticks are missing"};
    return f(ticks.value());
  });
}

namespace {

// Reads the blocks of `force` or `given`.
std::function<Status(const Bytes&, int64_t)> forces_into(
    const std::function<Status(const std::vector<Wrench>&)>& f) {
  return [&f](const Bytes& data, int64_t count) -> Status {
    const Result<std::vector<Wrench>> computed = decode_forces(data);
    if (!computed) return Error{computed.error()};
    if (static_cast<int64_t>(computed.value().size()) != count)
      return Error{"some of its forces are missing"};
    return f(computed.value());
  };
}

}  // namespace

Status Document::for_forces(StepId step,
                            const std::function<Status(const std::vector<Wrench>&)>& f) const {
  return version_ < 2 ? Status(Ok{}) : for_blocks(BlockTable::force, step, forces_into(f));
}

Status Document::for_given(StepId step,
                           const std::function<Status(const std::vector<Wrench>&)>& f) const {
  return version_ < 12 ? Status(Ok{}) : for_blocks(BlockTable::given, step, forces_into(f));
}

Status Document::replay(StepId step, Workbench& bench, const std::optional<ForceLaw>& law,
                        const std::function<void(const ReplayedTick&)>& use) const {
  const std::string which = "is a damaged document: step " + std::to_string(step) + ": ";
  if (steps_.at(step).action) {
    const Result<BodyAction> what = action(step);
    if (!what) return Error{what.error()};
    const Result<BodyChange> done = bench.act(what.value());
    return done ? Status(Ok{}) : Status(wrong(which + done.error()));
  }
  const Result<StrokeSettings> read = settings(step);
  if (!read) return Error{read.error()};
  const StrokeSettings& s = read.value();
  if (Status there = bench.activate(s.body); !there) return wrong(which + there.error());
  std::optional<Snapshot> before;
  if (s.crumbs != Crumbs::stay) before = bench.model().snapshot();
  const Result<const NoGo*> no_go = bench.no_go();
  if (!no_go) return wrong(which + no_go.error());
  if (Status done = replay_ticks(step, s, bench.model(), no_go.value(), law, use); !done)
    return done;
  if (before) bench.end_stroke(*before, s.crumbs);
  return Ok{};
}

// Gives the model the lattice that it had when the stroke began. A model with another pitch keeps
// its own.
Status Document::set_first_lattice(const StrokeSettings& s, TriDexel& model) const {
  Lattice first = model.lattice();
  if ((first.nodes != lattice_.nodes).any() || first.pitch_mm != lattice_.pitch_mm) return Ok{};
  first.below = s.grown_below;
  first.above = s.grown_above;
  if ((first.high() - first.low() > kMaxNodesPerAxis).any())
    return Error{"its lattice is too large"};
  model.set_lattice(joined(first, fitted_lattice(model.snapshot())));
  return Ok{};
}

Status Document::replay_ticks(StepId step, const StrokeSettings& recorded, TriDexel& model,
                              const NoGo* no_go, const std::optional<ForceLaw>& law,
                              const std::function<void(const ReplayedTick&)>& use) const {
  const Result<Pose> begin = start(step);
  if (!begin) return Error{begin.error()};
  StrokeSettings s = recorded;
  if (law) s.force.law = *law;
  if (law && s.second) s.second->force.law = *law;
  if (Status set = set_first_lattice(s, model); !set)
    return wrong("is a damaged document: step " + std::to_string(step) + ": " + set.error());
  StrokePlayer player(model, begin.value(), s.force.spring);
  if (s.second) player.add_second({}, s.second->force.spring);
  player.set_no_go(no_go);
  // Forces are computed only for a caller that uses them.
  const std::shared_ptr<const Grain> grain =
      use ? Grain::of(model.lattice(), s.materials) : nullptr;
  player.set_grain(grain.get());
  if (Status begun = player.begin(s); !begun) return begun;
  ReplayedTick out;
  out.step = step;
  const int64_t all = steps_.at(step).ticks;
  int64_t count = 0, of_first = 0;
  // Kibori 0.1 had a fault: it recorded reshaping strokes of scenes with force model `series` as if
  // they edited nothing. The first tick of such a stroke shows this, because all other strokes edit
  // from the first tick on.
  bool lost_edits = false;
  Status replayed = for_ticks(step, [&](const std::vector<RecordedTick>& ticks) -> Status {
    for (RecordedTick tick : ticks) {
      if (auto* const move = std::get_if<MoveTick>(&tick.what);
          move && reshapes(s.mode) && recorded.force.series() && !s.second) {
        if (count == 0) lost_edits = !move->edits;
        if (lost_edits) move->edits = !(ends_apart(s.mode) && count == all - 1);
      }
      Result<ToolTick> played = player.play(tick);
      if (!played) return Error{played.error()};
      count++;
      if (!tick.second && std::holds_alternative<MoveTick>(tick.what)) of_first++;
      out.time_s = static_cast<double>(of_first) / s.rate_hz;
      if (!use) continue;
      out.recorded = &tick;
      out.result = std::move(played).value();
      out.removed = player.played();
      use(out);
    }
    return Ok{};
  });
  if (replayed && count != all && steps_.at(step).finished)
    return wrong("is a damaged document: step " + std::to_string(step) + " has " +
                 std::to_string(count) + " ticks of " + std::to_string(all));
  return replayed ? player.finish_record() : replayed;
}

namespace {

// Reports damage of the file and of its tiles.
Status verify_file(Database& database, const std::function<void(const std::string&)>& wrong_at) {
  Result<Statement> check = database.prepare("PRAGMA integrity_check(20)");
  if (!check) return Error{check.error()};
  const Status structure = check.value().for_rows([&]() -> Status {
    if (check.value().text(0) != "ok")
      wrong_at("the file's structure: " + sanitize_message(check.value().text(0)));
    return Ok{};
  });
  if (!structure) return structure;
  Result<Statement> tiles = database.prepare("SELECT id, hash, data FROM tile");
  if (!tiles) return Error{tiles.error()};
  return tiles.value().for_rows([&]() -> Status {
    if (hash_of(tiles.value().bytes(2)) != tiles.value().integer(1))
      wrong_at("tile " + std::to_string(tiles.value().integer(0)) +
               " was changed since it was written");
    return Ok{};
  });
}

// Replays a step on the bench. Reports ticks and stored forces that differ. Error: it cannot be
// replayed.
Status verify_ticks(const Document& document, const Step& step, Workbench& bench,
                    const std::function<void(const std::string&)>& wrong_at,
                    const std::function<void(const std::string&)>& note) {
  const std::string which = "step " + std::to_string(step.id);
  std::vector<Wrench> kept, given;
  const auto gather = [](std::vector<Wrench>& all) {
    return [&all](const std::vector<Wrench>& some) -> Status {
      all.insert(all.end(), some.begin(), some.end());
      return Ok{};
    };
  };
  if (Status s = document.for_forces(step.id, gather(kept)); !s) wrong_at(s.error());
  if (Status s = document.for_given(step.id, gather(given)); !s) wrong_at(s.error());
  int64_t ticks = 0, other_forces = 0;
  const std::function<void(const ReplayedTick&)> compare = [&](const ReplayedTick& tick) {
    const auto i = static_cast<size_t>(ticks++);
    other_forces += i < kept.size() && !(kept[i].force == tick.result.wrench.force &&
                                         kept[i].moment == tick.result.wrench.moment);
  };
  // Forces are computed only if there are some to compare.
  const Status made =
      document.replay(step.id, bench, std::nullopt, kept.empty() ? nullptr : compare);
  for (const auto& [rows, name] : {std::pair{&kept, "forces"}, {&given, "given forces"}})
    if (made && step.finished && !rows->empty() && static_cast<int64_t>(rows->size()) != step.ticks)
      wrong_at(which + " has the " + name + " of " + std::to_string(rows->size()) + " ticks of " +
               std::to_string(step.ticks));
  if (other_forces > 0) {
    const std::string ticks_text =
        which + ": the stored forces of " + std::to_string(other_forces) + " ticks ";
    const Result<StrokeSettings> stroke = document.settings(step.id);
    if (!stroke || stroke.value().force.law.version == kForceVersion)
      wrong_at(ticks_text + "differ from the forces of a replay");
    else if (note)
      note(ticks_text + "were computed by an older version of Kibori, and differ today");
  }
  return made;
}

// True if the result of a step depends on volumes that an older version of Kibori measured.
bool by_older_volumes(const Document& document, StepId step) {
  const Result<StrokeSettings> stroke = document.settings(step);
  return stroke && reshapes(stroke.value().mode) &&
         stroke.value().force.law.version < kForceVersion;
}

}  // namespace

Status Document::verify(const std::function<void(const std::string&)>& wrong_at,
                        const std::function<void(double)>& progress,
                        const std::function<void(const std::string&)>& note) const {
  if (!missing_.empty()) wrong_at(missing_);
  std::set<std::string> said;
  const auto say = [&](const std::string& fault) {
    if (said.insert(fault).second) wrong_at(fault);
  };
  for (const std::string& fault : damage_) say(fault);
  if (Status s = verify_file(storage_->database, wrong_at); !s)
    return failed("checking", s.error());
  if (Status s = check_seals([&](StepId, const std::string& fault) { say(fault); }); !s)
    say("the seals can't be read (" + s.error() + ")");
  // Follows every path from the stock to a leaf of the tree. Each step is carved once, from the
  // state of its parent.
  std::map<StepId, BodyList> states;
  std::set<StepId> differ;  // differ from the document, because they use older volumes
  std::map<StepId, int> children;
  for (const auto& [id, step] : steps_) children[step.parent]++;
  TriDexel model(lattice_);
  Workbench bench(model);
  // Computes the states that the stored tiles give. Each is made from the state of the nearest
  // earlier step with tiles. `later` counts the steps that still need a state.
  TriDexel work(lattice_);
  std::map<StepId, StepId> base;  // 0: the stock
  std::map<StepId, int> later;
  for (const auto& [id, step] : steps_) {
    const bool with_tiles = is_checkpoint(step.parent);
    base[id] = step.stock || with_tiles ? step.parent : base[step.parent];
    if (is_checkpoint(id)) later[base[id]]++;
  }
  std::map<StepId, BodyList> by_tiles;
  const auto tile_state = [&](StepId id) -> Result<BodyList> {
    const StepId from = base.at(id);
    const auto before = by_tiles.find(from);
    Result<BodyList> state = before == by_tiles.end() ? read_tiles(id, work)
                                                      : read_tiles_after(before->second, id, work);
    if (--later[from] == 0 && before != by_tiles.end()) by_tiles.erase(before);
    if (state && later[id] > 0) by_tiles[id] = state.value();
    return state;
  };
  size_t done = 0;
  for (const auto& [id, step] : steps_) {
    if (progress) progress(static_cast<double>(done++) / static_cast<double>(steps_.size()));
    const std::string which = "step " + std::to_string(id);
    Status made = Ok{};
    if (step.stock) {
      const Result<BodyList> stock = read_tiles(id, model);
      if (stock)
        bench.set(stock.value(), 1);
      else
        made = Error{stock.error()};
      static_cast<void>(tile_state(id));
    } else {
      const auto before = states.find(step.parent);
      if (before == states.end()) {
        wrong_at(which + " cannot be carved again, because the step before it cannot");
        continue;
      }
      bench.set(before->second, active_at(step.parent));
      made = verify_ticks(*this, step, bench, wrong_at, note);
      if (--children[step.parent] == 0) states.erase(before);
    }
    if (!made) {
      wrong_at(made.error());
      continue;
    }
    const BodyList now = bench.bodies();
    if (step.finished && now.content_hash() != step.hash) {
      if (differ.contains(step.parent)) {
        differ.insert(id);
      } else if (by_older_volumes(*this, id)) {
        differ.insert(id);
        if (note)
          note(which +
               " uses a volume that an older version of Kibori measured; a replay of it and of "
               "later steps gives a slightly different model");
      } else {
        wrong_at(which + " differs from the recorded model when it is carved again");
      }
    }
    if (step.finished && bodies_to_json(now) != bodies_to_json(bodies_at(id)))
      wrong_at(which + " gives other bodies than recorded when it is repeated");
    if (is_checkpoint(id) && !step.stock) {
      const Result<BodyList> kept = tile_state(id);
      if (!kept)
        wrong_at(kept.error());
      else if (kept.value().content_hash() != step.hash)
        wrong_at("the stored tiles of " + which + " differ from its model");
    }
    if (children[id] > 0) states[id] = now;
  }
  if (progress) progress(1);
  return Ok{};
}

}  // namespace kibori
