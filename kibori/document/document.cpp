// SPDX-License-Identifier: MIT
#include <kibori/document/document.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <kibori/base/hash.h>

namespace kibori {
namespace {

using Json = nlohmann::json;

constexpr int kApplication = 0x4B49424F;  // "KIBO"
// 2: forces and thumbnails.
constexpr int64_t kVersion = 2;
// Tiles are kept where carving again from the last ones would take more ticks than this: a fraction of a
// second.
constexpr int64_t kTicksBetweenTiles = 40000;
// So long a flush keeps tiles, so that ticks never wait long behind them.
constexpr auto kTilesAtOnce = std::chrono::milliseconds(10);
// States held in memory; those not visited for longest go first, and are made again from the file when asked
// for.
constexpr size_t kMostStates = 2048;
// So many steps back a document that was just opened goes at once.
constexpr size_t kStatesAtOnce = 64;
// A loss of power takes what was written within this time.
constexpr auto kSyncEvery = std::chrono::milliseconds(500);
constexpr int64_t kMostNodes = 1 << 14;

const char* const kSchema = R"(
CREATE TABLE meta (key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE setting (id INTEGER PRIMARY KEY, json TEXT NOT NULL UNIQUE);
CREATE TABLE step (
  id INTEGER PRIMARY KEY, parent INTEGER REFERENCES step, kind TEXT NOT NULL, label TEXT NOT NULL DEFAULT '',
  setting INTEGER REFERENCES setting, start BLOB, ticks INTEGER NOT NULL DEFAULT 0,
  removed_mm3 REAL NOT NULL DEFAULT 0, hash TEXT, finished INTEGER NOT NULL DEFAULT 0,
  made_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')));
CREATE TABLE tick (step INTEGER NOT NULL REFERENCES step, sequence INTEGER NOT NULL, count INTEGER NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY (step, sequence)) WITHOUT ROWID;
CREATE TABLE tile (id INTEGER PRIMARY KEY, hash INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX tile_by_hash ON tile (hash);
CREATE TABLE checkpoint (step INTEGER PRIMARY KEY REFERENCES step, bounds TEXT NOT NULL);
CREATE TABLE checkpoint_tile (step INTEGER NOT NULL REFERENCES checkpoint, field INTEGER NOT NULL,
  u INTEGER NOT NULL, v INTEGER NOT NULL, tile INTEGER REFERENCES tile, PRIMARY KEY (step, field, u, v))
  WITHOUT ROWID;
CREATE TABLE version (name TEXT PRIMARY KEY, step INTEGER NOT NULL REFERENCES step) WITHOUT ROWID;
)";
const char* const kSchemaSince2 = R"(
CREATE TABLE force (step INTEGER NOT NULL REFERENCES step, sequence INTEGER NOT NULL, count INTEGER NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY (step, sequence)) WITHOUT ROWID;
CREATE TABLE thumbnail (step INTEGER PRIMARY KEY REFERENCES step, png BLOB NOT NULL);
PRAGMA user_version = 2;
)";

std::string hex(uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

int64_t hash_of(const Bytes& bytes) {
  Hash hash;
  hash.add(uint64_t{bytes.size()});
  for (size_t i = 0; i < bytes.size(); i += 8) {
    uint64_t word = 0;
    for (size_t j = i; j < std::min(i + 8, bytes.size()); j++) word |= uint64_t{bytes[j]} << (8 * (j - i));
    hash.add(word);
  }
  return static_cast<int64_t>(hash.value());
}

Json numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
bool read_numbers(const Json& json, Vec3& v) {
  if (!json.is_array() || json.size() != 3) return false;
  for (size_t i = 0; i < 3; i++) {
    if (!json[i].is_number()) return false;
    v[static_cast<int>(i)] = json[i].get<double>();
  }
  return v.allFinite();
}

// A link, unlike a renaming, fails where the name was taken meanwhile; some file systems have none.
bool put_in_place(const std::filesystem::path& part, const std::filesystem::path& path) {
  std::error_code code;
  const bool there = ::link(part.c_str(), path.c_str()) == 0 ||
                     (!std::filesystem::exists(path, code) && ::rename(part.c_str(), path.c_str()) == 0);
  std::filesystem::remove(part, code);
  return there;
}

Wrench spring_wrench(const SeriesSpring& spring, const StrokeTick& tick) {
  Wrench w;
  w.force = -spring.stiffness_n_mm * tick.hand;
  if (spring.torsion_nmm_rad > 0) w.moment = -spring.torsion_nmm_rad * tick.hand_turn;
  return w;
}

}  // namespace

Document::~Document() {
  if (unsaved_.empty()) static_cast<void>(keep_some_tiles(std::chrono::minutes(1)));
  if (writes_ && open_step_ == 0) static_cast<void>(database_.run("PRAGMA wal_checkpoint(TRUNCATE)"));
  database_ = Database();
  file_ = Database();
  // Last: closing any descriptor of the file drops the locks that SQLite holds on it.
  if (lock_ >= 0) ::close(lock_);
}

Status Document::lock(const std::filesystem::path& path) {
  lock_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (lock_ < 0) return wrong("can't be opened for writing");
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0)
    return wrong("is being written by another process; open it for reading, or close it there");
  return Ok{};
}

Status Document::commit(const char* doing, const std::function<Status()>& change) {
  Status done = try_commit(doing, change);
  if (done || !may_go_to_memory_ || !unsaved_.empty()) return done;
  Result<Database> memory = Database::in_memory(database_);
  if (!memory) return done;
  file_ = std::exchange(database_, std::move(memory).value());
  const Status again = try_commit(doing, change);
  if (again)
    unsaved_ = done.error();
  else
    database_ = std::move(file_);
  return again;
}

Status Document::save_again() {
  if (unsaved_.empty()) return Ok{};
  // What waits goes into memory first, so that what is saved is all there is.
  if (Status s = flush(); !s) return s;
  if (Status s = file_.become(database_); !s) return failed("saving", s.error());
  database_ = std::move(file_);
  unsaved_.clear();
  return Ok{};
}

Status Document::move_to(const std::filesystem::path& path) {
  if (!writes_) return wrong("is open for reading only");
  if (Status s = flush(); !s) return s;
  if (Status s = save_copy(path); !s) return s;
  Result<std::unique_ptr<Document>> there = attach(path, nullptr);
  if (!there) return Error{there.error()};
  // Closed in order: the descriptor after what SQLite holds of the same file.
  database_ = std::move(there.value()->database_);
  file_ = Database();
  std::swap(lock_, there.value()->lock_);
  unsaved_.clear();
  return Ok{};
}

Status Document::try_commit(const char* doing, const std::function<Status()>& change) {
  // Now and then a commit waits until it is on the disk, and with it all before it.
  const auto now = std::chrono::steady_clock::now();
  const bool sync = now - synced_ >= kSyncEvery;
  if (Status s = database_.run(sync ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL"); !s)
    return failed(doing, s.error());
  if (Status s = database_.run("BEGIN IMMEDIATE"); !s) return failed(doing, s.error());
  Status done = change();
  if (done) {
    if (Status s = database_.run("COMMIT"); !s) done = failed(doing, s.error());
  }
  if (!done) {
    static_cast<void>(database_.run("ROLLBACK"));
    return done;
  }
  if (sync) synced_ = now;
  return done;
}

Result<std::unique_ptr<Document>> Document::create(const std::filesystem::path& path, const TriDexel& model,
                                                   const std::string& stock, const Bytes& source,
                                                   const char* vfs) {
  std::error_code code;
  const std::string name = one_line(path.string());
  if (std::filesystem::exists(path, code))
    return Error{name + ": is there already; give another name or remove it"};
  // All of it or nothing: made beside, and put in place when it is a document.
  const std::filesystem::path part = path.string() + ".part";
  for (const char* rest : {"", "-wal", "-shm", "-journal"})
    std::filesystem::remove(part.string() + rest, code);
  Result<Database> made = Database::open(part, Database::Access::create, vfs);
  if (!made) return Error{name + ": can't be made; is the folder there, and writable?"};
  {
    std::unique_ptr<Document> document(new Document(std::move(made).value()));
    document->writes_ = true;
    document->lattice_ = model.lattice();
    const Snapshot now = model.snapshot();
    const Status filled = [&]() -> Status {
      const std::string first = "PRAGMA application_id=" + std::to_string(kApplication);
      if (Status s = document->database_.run(first.c_str()); !s) return s;
      return document->commit("making it", [&]() -> Status {
        for (const char* tables : {kSchema, kSchemaSince2})
          if (Status s = document->database_.run(tables); !s) return s;
        Result<Statement> meta = document->database_.prepare("INSERT INTO meta VALUES (?, ?)");
        if (!meta) return Error{meta.error()};
        Statement& m = meta.value();
        const Lattice& lattice = model.lattice();
        const Json json{{"nodes", {lattice.nodes[0], lattice.nodes[1], lattice.nodes[2]}},
                        {"origin_mm", numbers(lattice.origin_mm)},
                        {"pitch_mm", lattice.pitch_mm}};
        for (const auto& [key, value] :
             {std::pair<std::string, std::string>{"lattice", json.dump()}, {"stock", stock}})
          if (Status s = m.bind(key).bind(value).run(); !s) return s;
        if (Status s = m.bind(std::string_view("source")).bind(source).run(); !s) return s;
        if (Status s = m.bind(std::string_view("head")).bind(int64_t{1}).run(); !s) return s;
        Result<Statement> step = document->database_.prepare(
            "INSERT INTO step (id, kind, hash, finished) VALUES (1, 'stock', ?, 1)");
        if (!step) return Error{step.error()};
        const uint64_t hash = now.content_hash();
        if (Status s = step.value().bind(hex(hash)).run(); !s) return s;
        Step first_step;
        first_step.id = 1;
        first_step.stock = true;
        first_step.hash = hash;
        document->steps_[1] = first_step;
        Result<TileJob> tiles = document->plan_tiles(1, now, model.material_bounds());
        if (!tiles) return Error{tiles.error()};
        return document->keep_tiles(tiles.value(), std::chrono::steady_clock::time_point::max());
      });
    }();
    if (!filled) {
      document.reset();
      std::filesystem::remove(part, code);
      return Error{name + ": can't be made (" + filled.error() + ")"};
    }
  }
  if (!put_in_place(part, path)) return Error{name + ": can't be put in place"};
  Result<std::unique_ptr<Document>> opened = open(path, Access::write, vfs);
  if (opened) opened.value()->remember(1, model.snapshot());
  return opened;
}

Result<std::unique_ptr<Document>> Document::open(const std::filesystem::path& path, Access access,
                                                 const char* vfs) {
  std::error_code code;
  const std::string name = one_line(path.string());
  if (!std::filesystem::exists(path, code)) return Error{name + ": there is no such file"};
  if (!std::filesystem::is_regular_file(path, code)) return Error{name + ": is no file"};
  std::unique_ptr<Document> document;
  if (access == Access::write) {
    Result<std::unique_ptr<Document>> attached = attach(path, vfs);
    if (!attached) return attached;
    document = std::move(attached).value();
  } else {
    Result<Database> database = Database::open(path, Database::Access::read, vfs);
    if (!database) return Error{database.error()};
    document.reset(new Document(std::move(database).value()));
    if (Status s = document->check_kind(); !s) return Error{s.error()};
  }
  if (Status s = document->read_tree(); !s) return Error{s.error()};
  if (Status s = document->recover(); !s) return Error{s.error()};
  document->may_go_to_memory_ = true;
  return document;
}

Result<std::unique_ptr<Document>> Document::attach(const std::filesystem::path& path, const char* vfs) {
  Result<Database> database = Database::open(path, Database::Access::write, vfs);
  if (!database) return Error{database.error()};
  std::unique_ptr<Document> document(new Document(std::move(database).value()));
  if (Status s = document->lock(path); !s) return Error{s.error()};
  if (Status s = document->check_kind(); !s) return Error{s.error()};
  document->writes_ = true;
  if (Status s = document->database_.run(
          "PRAGMA journal_mode=WAL; PRAGMA foreign_keys=ON; PRAGMA wal_autocheckpoint=4000");
      !s)
    return document->failed("opening", s.error());
  if (document->version_ < 2) {
    const Status s =
        document->commit("bringing it up to date", [&] { return document->database_.run(kSchemaSince2); });
    if (!s) return Error{s.error()};
    document->version_ = kVersion;
  }
  return document;
}

// A document of Kibori, and which version.
Status Document::check_kind() {
  const auto pragma = [&](const char* sql) -> Result<int64_t> {
    Result<Statement> read = database_.prepare(sql);
    if (!read) return Error{read.error()};
    const Result<bool> row = read.value().row();
    if (!row) return Error{row.error()};
    return row.value() ? read.value().integer(0) : 0;
  };
  const Result<int64_t> application = pragma("PRAGMA application_id");
  if (!application) return wrong("is no document of Kibori (" + application.error() + ")");
  if (application.value() != kApplication) return wrong("is no document of Kibori");
  const Result<int64_t> version = pragma("PRAGMA user_version");
  if (!version || version.value() < 1) return wrong("is a damaged document");
  if (version.value() > kVersion)
    return wrong("was made by a newer Kibori (format " + std::to_string(version.value()) +
                 ", this one reads " + std::to_string(kVersion) + "); use that");
  version_ = version.value();
  return Ok{};
}

Status Document::read_tree() {
  const auto damaged = [&](const std::string& what) { return wrong("is a damaged document: " + what); };
  Result<Statement> meta = database_.prepare("SELECT key, value FROM meta WHERE key IN ('lattice', 'head')");
  if (!meta) return damaged(meta.error());
  bool placed = false;
  for (;;) {
    Statement& m = meta.value();
    const Result<bool> row = m.row();
    if (!row) return damaged(row.error());
    if (!row.value()) break;
    if (m.text(0) == "head") {
      head_ = m.integer(1);
      continue;
    }
    const Json json = Json::parse(m.text(1), nullptr, false);
    if (!json.is_object() || !json.contains("nodes") || !json.contains("origin_mm") ||
        !json.contains("pitch_mm"))
      break;
    Vec3 nodes;
    if (!read_numbers(json["nodes"], nodes) || !read_numbers(json["origin_mm"], lattice_.origin_mm)) break;
    if (!json["pitch_mm"].is_number()) break;
    lattice_.pitch_mm = json["pitch_mm"].get<double>();
    if (!(lattice_.pitch_mm > 0) || !std::isfinite(lattice_.pitch_mm)) break;
    if (nodes.minCoeff() < 1 || nodes.maxCoeff() > static_cast<double>(kMostNodes)) break;
    for (int i = 0; i < 3; i++) lattice_.nodes[i] = static_cast<int>(nodes[i]);
    placed = true;
  }
  if (!placed) return damaged("it does not say where its rays are");

  Result<Statement> read = database_.prepare(
      "SELECT id, parent, kind, label, ticks, removed_mm3, hash, finished, "
      "(SELECT coalesce(sum(count), 0) FROM tick WHERE tick.step = step.id AND step.finished = 0) FROM step "
      "ORDER BY id");
  if (!read) return damaged(read.error());
  for (;;) {
    Statement& s = read.value();
    const Result<bool> row = s.row();
    if (!row) return damaged(row.error());
    if (!row.value()) break;
    Step step;
    step.id = s.integer(0);
    step.parent = s.null(1) ? 0 : s.integer(1);
    step.stock = s.text(2) == "stock";
    step.label = s.text(3);
    step.finished = s.integer(7) != 0;
    step.ticks = step.finished ? s.integer(4) : s.integer(8);
    step.removed_mm3 = s.real(5);
    step.hash = std::strtoull(s.text(6).c_str(), nullptr, 16);
    const bool known = step.stock ? step.parent == 0 && steps_.empty() : steps_.count(step.parent) != 0;
    if (step.id < 1 || !known)
      return damaged("step " + std::to_string(step.id) + " follows none that is there");
    steps_[step.id] = step;
  }
  if (steps_.empty()) return damaged("it has no stock");
  if (!steps_.count(head_)) head_ = steps_.rbegin()->first;

  Result<Statement> versions = database_.prepare("SELECT name, step FROM version");
  if (!versions) return damaged(versions.error());
  for (;;) {
    const Result<bool> row = versions.value().row();
    if (!row) return damaged(row.error());
    if (!row.value()) break;
    if (steps_.count(versions.value().integer(1)))
      versions_[versions.value().text(0)] = versions.value().integer(1);
  }
  Result<Statement> checkpoints = database_.prepare("SELECT step, bounds FROM checkpoint");
  if (!checkpoints) return damaged(checkpoints.error());
  for (;;) {
    const Result<bool> row = checkpoints.value().row();
    if (!row) return damaged(row.error());
    if (!row.value()) break;
    const Json json = Json::parse(checkpoints.value().text(1), nullptr, false);
    Box box;
    if (steps_.count(checkpoints.value().integer(0)) && json.is_array() && json.size() == 2 &&
        read_numbers(json[0], box.min) && read_numbers(json[1], box.max))
      checkpoints_[checkpoints.value().integer(0)] = box;
  }
  if (!checkpoints_.count(steps_.begin()->first)) return damaged("the stock's tiles are missing");
  return Ok{};
}

// Strokes that were being made when their process ended are finished as far as they came; they are the
// newest.
Status Document::recover() {
  for (auto& entry : steps_) {
    const StepId id = entry.first;
    Step& step = entry.second;
    if (step.finished) continue;
    if (writes_) {
      TriDexel model(lattice_);
      if (Status s = make_state(model, id); !s) return s;
      const Snapshot now = model.snapshot();
      step.hash = now.content_hash();
      Status kept = commit("finishing an interrupted stroke", [&]() -> Status {
        Result<Statement> update = database_.prepare(
            "UPDATE step SET finished = 1, ticks = ?, hash = ?, removed_mm3 = ? WHERE id = ?");
        if (!update) return Error{update.error()};
        TriDexel before(lattice_);
        if (Status s = make_state(before, step.parent); !s) return s;
        step.removed_mm3 = before.volume_mm3() - now.volume_mm3();
        return update.value().bind(step.ticks).bind(hex(step.hash)).bind(step.removed_mm3).bind(id).run();
      });
      if (!kept) return kept;
      step.finished = true;
      if (Status s = set_head(id); !s) return s;
    } else {
      head_ = id;
    }
  }
  return Ok{};
}

Result<std::string> Document::stock() const {
  Result<Statement> read =
      const_cast<Database&>(database_).prepare("SELECT value FROM meta WHERE key = 'stock'");
  if (!read) return failed("reading the stock", read.error());
  const Result<bool> row = read.value().row();
  if (!row) return failed("reading the stock", row.error());
  return row.value() ? read.value().text(0) : std::string();
}

Result<Bytes> Document::source() const {
  Result<Statement> read =
      const_cast<Database&>(database_).prepare("SELECT value FROM meta WHERE key = 'source'");
  if (!read) return failed("reading the stock's file", read.error());
  const Result<bool> row = read.value().row();
  if (!row) return failed("reading the stock's file", row.error());
  return row.value() ? read.value().bytes(0) : Bytes();
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
  if (const auto found = versions_.find(name); found != versions_.end()) return found->second;
  char* end = nullptr;
  const long long id = std::strtoll(name.c_str(), &end, 10);
  if (!name.empty() && *end == 0 && steps_.count(id)) return StepId{id};
  return wrong("has no version or step '" + one_line(name) + "'; it has steps 1 to " +
               std::to_string(steps_.rbegin()->first));
}

Status Document::name_version(const std::string& name, StepId step) {
  if (name.empty() || name.find_first_not_of("0123456789") == std::string::npos)
    return wrong("a version's name can't be a number or nothing");
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  Status kept = commit("naming a version", [&]() -> Status {
    Result<Statement> put = database_.prepare("INSERT OR REPLACE INTO version VALUES (?, ?)");
    if (!put) return Error{put.error()};
    return put.value().bind(name).bind(step).run();
  });
  if (kept) versions_[name] = step;
  return kept;
}

Status Document::set_head(StepId step) {
  if (writes_) {
    Status kept = commit("moving in the history", [&]() -> Status {
      Result<Statement> put = database_.prepare("UPDATE meta SET value = ? WHERE key = 'head'");
      if (!put) return Error{put.error()};
      return put.value().bind(step).run();
    });
    if (!kept) return kept;
  }
  head_ = step;
  return Ok{};
}

void Document::remember(StepId step, const Snapshot& state) {
  // One that came too late: of a model whose content has been swapped since, see destination().
  if (!states_.empty() && !states_.begin()->second.of_same_model(state)) return;
  states_[step] = state;
  std::erase(visited_, step);
  visited_.push_back(step);
  if (visited_.size() > kMostStates) {
    states_.erase(visited_.front());
    visited_.erase(visited_.begin());
  }
}

// ---- Tiles

// Against what the way to here has already: in memory, where what changed is known; else from the file.
Result<Document::TileJob> Document::plan_tiles(StepId step, const Snapshot& now, const Box& bounds) const {
  TileJob job;
  job.step = step;
  job.now = now;
  job.bounds = bounds;
  StepId at = steps_.at(step).parent;
  while (at != 0 && !is_checkpoint(at)) at = steps_.at(at).parent;
  const auto consider = [&](Axis axis, int tu, int tv, const Tile& was, const Tile& is) {
    if (!is.empty || !was.empty) job.places.push_back({axis, tu, tv, is.empty ? nullptr : &is});
  };
  if (const auto state = states_.find(at); state != states_.end() && state->second.of_same_model(now)) {
    for (const Axis axis : kAxes)
      now.field(axis).for_changed_tiles(
          state->second.field(axis),
          [&](int tu, int tv, const Tile& was, const Tile& is) { consider(axis, tu, tv, was, is); });
    return job;
  }
  TriDexel before(lattice_);
  if (at != 0)
    if (Status s = read_tiles(at, before); !s) return Error{s.error()};
  const Snapshot then = before.snapshot();
  for (const Axis axis : kAxes) {
    const FieldSnapshot &is = now.field(axis), &was = then.field(axis);
    for (int tv = 0; tv < is.tiles_v(); tv++)
      for (int tu = 0; tu < is.tiles_u(); tu++) {
        const Tile &tile = is.tile(tu, tv), &old = was.tile(tu, tv);
        if (at == 0 || encode_tile(tile) != encode_tile(old)) consider(axis, tu, tv, old, tile);
      }
  }
  return job;
}

Status Document::keep_tiles(TileJob& job, std::chrono::steady_clock::time_point until) {
  Result<Statement> find = database_.prepare("SELECT id, data FROM tile WHERE hash = ?");
  if (!find) return Error{find.error()};
  Result<Statement> add = database_.prepare("INSERT INTO tile (hash, data) VALUES (?, ?)");
  if (!add) return Error{add.error()};
  for (; job.next < job.places.size(); job.next++) {
    const Tile* const tile = job.places[job.next].tile;
    if (!tile) continue;
    auto [found, fresh] = job.ids.try_emplace(tile, 0);
    if (!fresh) continue;
    if (std::chrono::steady_clock::now() >= until) {
      job.ids.erase(found);
      return Ok{};
    }
    const Bytes data = encode_tile(*tile);
    const int64_t hash = hash_of(data);
    find.value().bind(hash);
    for (;;) {
      const Result<bool> row = find.value().row();
      if (!row) return Error{row.error()};
      if (!row.value()) break;
      if (find.value().bytes(1) == data) found->second = find.value().integer(0);
    }
    if (found->second != 0) continue;
    if (Status s = add.value().bind(hash).bind(data).run(); !s) return s;
    found->second = database_.last_row();
  }
  Result<Statement> checkpoint = database_.prepare("INSERT INTO checkpoint VALUES (?, ?)");
  if (!checkpoint) return Error{checkpoint.error()};
  const Json box{numbers(job.bounds.min), numbers(job.bounds.max)};
  if (Status s = checkpoint.value().bind(job.step).bind(box.dump()).run(); !s) return s;
  Result<Statement> put = database_.prepare("INSERT INTO checkpoint_tile VALUES (?, ?, ?, ?, ?)");
  if (!put) return Error{put.error()};
  for (const TilePlace& place : job.places) {
    Statement& p = put.value();
    p.bind(job.step).bind(static_cast<int64_t>(place.axis)).bind(int64_t{place.tu}).bind(int64_t{place.tv});
    if (Status s = (place.tile ? p.bind(job.ids.at(place.tile)) : p.bind_null()).run(); !s) return s;
  }
  job.done = true;
  return Ok{};
}

Status Document::keep_some_tiles(std::chrono::milliseconds at_most) {
  if (!tiles_) return Ok{};
  const auto until = std::chrono::steady_clock::now() + at_most;
  // What a transaction found out is forgotten with it if it fails.
  TileJob job;
  Status kept = commit("keeping tiles", [&] {
    job = *tiles_;
    return keep_tiles(job, until);
  });
  if (!kept) return kept;
  tiles_ = std::move(job);
  if (tiles_->done) {
    checkpoints_[tiles_->step] = tiles_->bounds;
    tiles_.reset();
  }
  return Ok{};
}

Status Document::read_tiles(StepId step, TriDexel& model) const {
  auto& database = const_cast<Database&>(database_);
  // The newest tile of each place on the way here.
  std::map<std::tuple<int64_t, int64_t, int64_t>, int64_t> tiles;
  Result<std::vector<StepId>> path = path_to(step);
  if (!path) return Error{path.error()};
  Result<Statement> places = database.prepare("SELECT field, u, v, tile FROM checkpoint_tile WHERE step = ?");
  if (!places) return failed("reading tiles", places.error());
  for (const StepId id : path.value()) {
    const auto checkpoint = checkpoints_.find(id);
    if (checkpoint == checkpoints_.end()) continue;
    model.include_material(checkpoint->second);
    Statement& p = places.value();
    p.bind(id);
    for (;;) {
      const Result<bool> row = p.row();
      if (!row) return failed("reading tiles", row.error());
      if (!row.value()) break;
      tiles[{p.integer(0), p.integer(1), p.integer(2)}] = p.null(3) ? 0 : p.integer(3);
    }
  }
  Result<Statement> read = database.prepare("SELECT data FROM tile WHERE id = ?");
  if (!read) return failed("reading tiles", read.error());
  std::map<std::pair<int64_t, int64_t>, std::pair<int, int>> first;  // field and tile: where it stands
  for (const auto& [place, tile] : tiles) {
    const auto& [axis, u, v] = place;
    if (axis < 0 || axis > 2)
      return wrong("is a damaged document: there is no field " + std::to_string(axis));
    Field& field = model.field(kAxes[static_cast<size_t>(axis)]);
    if (u < 0 || v < 0 || u >= field.tiles_u() || v >= field.tiles_v())
      return wrong("is a damaged document: a tile lies outside of it");
    const int tu = static_cast<int>(u), tv = static_cast<int>(v);
    if (tile == 0) {
      field.clear_tile(tu, tv);
      continue;
    }
    if (const auto same = first.find({axis, tile}); same != first.end()) {
      field.share_tile(tu, tv, same->second.first, same->second.second);
      continue;
    }
    const Result<bool> row = read.value().bind(tile).row();
    if (!row) return failed("reading tiles", row.error());
    if (!row.value()) return wrong("is a damaged document: tile " + std::to_string(tile) + " is missing");
    const Status put = decode_tile(read.value().bytes(0), field, tu, tv);
    static_cast<void>(read.value().row());
    if (!put) return wrong("is a damaged document: at step " + std::to_string(step) + ", " + put.error());
    first[{axis, tile}] = {tu, tv};
  }
  model.touch();
  return Ok{};
}

// Sets an empty model to a step: the nearest tiles before it, and the strokes since.
Status Document::make_state(TriDexel& model, StepId step) const {
  Result<std::vector<StepId>> path = path_to(step);
  if (!path) return Error{path.error()};
  size_t from = path.value().size();
  while (from > 0 && !is_checkpoint(path.value()[from - 1])) from--;
  if (from == 0) return wrong("is a damaged document: the stock's tiles are missing");
  if (Status s = read_tiles(path.value()[from - 1], model); !s) return s;
  for (; from < path.value().size(); from++)
    if (Status s = replay(path.value()[from], model, std::nullopt, {}); !s) return s;
  return Ok{};
}

// ---- History

// From the nearest state in memory on the way, or the nearest tiles, whichever is nearer; the states in
// between are remembered, as the next steps back will ask for them.
Status Document::rebuild(TriDexel& model, StepId step, size_t at_least) {
  Result<std::vector<StepId>> path = path_to(step);
  if (!path) return Error{path.error()};
  const std::vector<StepId>& way = path.value();
  size_t from = way.size() - std::min(at_least, way.size()) + 1;
  while (from > 0 && !is_checkpoint(way[from - 1]) && !states_.count(way[from - 1])) from--;
  if (from == 0) return wrong("is a damaged document: the stock's tiles are missing");
  const StepId begin = way[from - 1];
  if (const auto known = states_.find(begin); known != states_.end()) {
    model.restore(known->second);
  } else {
    for (const Axis axis : kAxes) {
      Field& field = model.field(axis);
      for (int tv = 0; tv < field.tiles_v(); tv++)
        for (int tu = 0; tu < field.tiles_u(); tu++) field.clear_tile(tu, tv);
    }
    if (Status s = read_tiles(begin, model); !s) return s;
  }
  remember(begin, model.snapshot());
  for (; from < way.size(); from++) {
    if (Status s = replay(way[from], model, std::nullopt, {}); !s) return s;
    remember(way[from], model.snapshot());
  }
  return Ok{};
}

Result<std::unique_ptr<TriDexel>> Document::load() {
  states_.clear();
  visited_.clear();
  auto model = std::make_unique<TriDexel>(lattice_);
  if (const Status s = rebuild(*model, head_, kStatesAtOnce); !s) return Error{s.error()};
  return model;
}

Result<Document::Destination> Document::destination(StepId step) {
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  Destination to;
  to.step = step;
  if (const auto known = states_.find(step); known != states_.end()) {
    to.state = known->second;
    return to;
  }
  auto states = std::exchange(states_, {});
  auto visited = std::exchange(visited_, {});
  to.model = std::make_unique<TriDexel>(lattice_);
  if (const Status s = rebuild(*to.model, step, kStatesAtOnce); !s) {
    states_ = std::move(states);
    visited_ = std::move(visited);
    return Error{s.error()};
  }
  return to;
}

Status Document::went(StepId step) {
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  const StepId from = head_;
  Status done = set_head(step);
  if (done && steps_[from].parent == step) last_child_[step] = from;
  return done;
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
  Status done = rebuild(model, step, 1);
  if (done) done = went(step);
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

Status Document::begin(const StrokeSettings& settings, const Pose& start, const std::string& label) {
  if (!writes_) return wrong("is open for reading only");
  if (open_step_ != 0) return wrong("a stroke is being made already");
  StepId id = 0;
  Status kept = commit("beginning a stroke", [&]() -> Status {
    const std::string json = settings_to_json(settings);
    Result<Statement> setting = database_.prepare("INSERT OR IGNORE INTO setting (json) VALUES (?)");
    if (!setting) return Error{setting.error()};
    if (Status s = setting.value().bind(json).run(); !s) return s;
    Result<Statement> step = database_.prepare(
        "INSERT INTO step (parent, kind, label, setting, start) VALUES (?, 'stroke', ?, (SELECT id FROM "
        "setting WHERE "
        "json = ?), ?)");
    if (!step) return Error{step.error()};
    if (Status s = step.value().bind(head_).bind(label).bind(json).bind(encode_pose(start)).run(); !s)
      return s;
    id = database_.last_row();
    return Ok{};
  });
  if (!kept) return kept;
  open_step_ = id;
  open_sequence_ = open_ticks_ = saved_ticks_ = 0;
  waiting_.clear();
  waiting_forces_.clear();
  Step step;
  step.id = id;
  step.parent = head_;
  step.label = label;
  step.finished = false;
  steps_[id] = step;
  return Ok{};
}

// Within a transaction.
Status Document::write_ticks() {
  if (waiting_.empty()) return Ok{};
  Result<Statement> put = database_.prepare("INSERT INTO tick VALUES (?, ?, ?, ?)");
  if (!put) return Error{put.error()};
  const auto count = static_cast<int64_t>(waiting_.size());
  if (Status s = put.value()
                     .bind(open_step_)
                     .bind(open_sequence_)
                     .bind(count)
                     .bind(encode_ticks(waiting_.data(), waiting_.size()))
                     .run();
      !s)
    return s;
  if (waiting_forces_.size() != waiting_.size()) return Ok{};
  put = database_.prepare("INSERT INTO force VALUES (?, ?, ?, ?)");
  if (!put) return Error{put.error()};
  return put.value()
      .bind(open_step_)
      .bind(open_sequence_)
      .bind(count)
      .bind(encode_forces(waiting_forces_.data(), waiting_forces_.size()))
      .run();
}

Status Document::flush() {
  if (open_step_ == 0 || waiting_.empty()) return keep_some_tiles(kTilesAtOnce);
  Status kept = commit("saving", [&] { return write_ticks(); });
  if (!kept) return kept;
  open_sequence_++;
  saved_ticks_ += static_cast<int64_t>(waiting_.size());
  waiting_.clear();
  waiting_forces_.clear();
  return keep_some_tiles(kTilesAtOnce);
}

Status Document::finish(const Snapshot& now, const Box& material_bounds, double removed_mm3) {
  if (open_step_ == 0) return wrong("no stroke is being made");
  Step step = steps_[open_step_];
  step.ticks = saved_ticks_ + static_cast<int64_t>(waiting_.size());
  step.removed_mm3 = removed_mm3;
  step.hash = now.content_hash();
  step.finished = true;
  int64_t ticks = step.ticks;
  for (StepId at = step.parent; at != 0 && !is_checkpoint(at); at = steps_[at].parent)
    ticks += steps_[at].ticks;
  Status kept = commit("finishing a stroke", [&]() -> Status {
    if (Status s = write_ticks(); !s) return s;
    Result<Statement> update =
        database_.prepare("UPDATE step SET finished = 1, ticks = ?, removed_mm3 = ?, hash = ? WHERE id = ?");
    if (!update) return Error{update.error()};
    if (Status s = update.value().bind(step.ticks).bind(removed_mm3).bind(hex(step.hash)).bind(step.id).run();
        !s)
      return s;
    Result<Statement> head = database_.prepare("UPDATE meta SET value = ? WHERE key = 'head'");
    if (!head) return Error{head.error()};
    return head.value().bind(step.id).run();
  });
  if (!kept) return kept;
  steps_[step.id] = step;
  last_child_.erase(step.parent);
  head_ = step.id;
  open_step_ = 0;
  waiting_.clear();
  waiting_forces_.clear();
  remember(step.id, now);
  if (ticks <= kTicksBetweenTiles || tiles_) return Ok{};
  Result<TileJob> tiles = plan_tiles(step.id, now, material_bounds);
  if (tiles) tiles_ = std::move(tiles).value();
  return Ok{};
}

Status Document::cancel() {
  if (open_step_ == 0) return wrong("no stroke is being made");
  const StepId id = open_step_;
  Status kept = commit("cancelling a stroke", [&]() -> Status {
    for (const char* sql : {"DELETE FROM tick WHERE step = ?", "DELETE FROM force WHERE step = ?",
                            "DELETE FROM step WHERE id = ?"}) {
      Result<Statement> drop = database_.prepare(sql);
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
  if (!writes_) return wrong("is open for reading only");
  if (!steps_.count(step)) return wrong("has no step " + std::to_string(step));
  return commit("keeping a thumbnail", [&]() -> Status {
    Result<Statement> put = database_.prepare("INSERT OR REPLACE INTO thumbnail VALUES (?, ?)");
    if (!put) return Error{put.error()};
    return put.value().bind(step).bind(png).run();
  });
}

Result<Bytes> Document::thumbnail(StepId step) const {
  if (version_ < 2) return Bytes();
  Result<Statement> read =
      const_cast<Database&>(database_).prepare("SELECT png FROM thumbnail WHERE step = ?");
  if (!read) return failed("reading a thumbnail", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a thumbnail", row.error());
  return row.value() ? read.value().bytes(0) : Bytes();
}

Status Document::save_copy(const std::filesystem::path& path) const {
  std::error_code code;
  const std::string name = one_line(path.string());
  if (std::filesystem::exists(path, code))
    return Error{name + ": is there already; give another name or remove it"};
  const std::filesystem::path part = path.string() + ".part";
  std::filesystem::remove(part, code);
  Result<Statement> copy = const_cast<Database&>(database_).prepare("VACUUM INTO ?");
  if (!copy) return failed("copying", copy.error());
  if (const Status s = copy.value().bind(part.string()).run(); !s) {
    std::filesystem::remove(part, code);
    return Error{name + ": can't be written (" + s.error() + ")"};
  }
  if (!put_in_place(part, path)) return Error{name + ": can't be put in place"};
  return Ok{};
}

// ---- Replay

Result<StrokeSettings> Document::settings(StepId step) const {
  Result<Statement> read = const_cast<Database&>(database_).prepare(
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
  Result<Statement> read = const_cast<Database&>(database_).prepare("SELECT start FROM step WHERE id = ?");
  if (!read) return failed("reading a stroke", read.error());
  const Result<bool> row = read.value().bind(step).row();
  if (!row) return failed("reading a stroke", row.error());
  Result<Pose> pose = decode_pose(row.value() ? read.value().bytes(0) : Bytes());
  if (!pose) return wrong("is a damaged document: step " + std::to_string(step) + ": " + pose.error());
  return pose;
}

// The rows of `table` that belong to a step, in order: f(data, count).
Status Document::for_blocks(const char* table, StepId step,
                            const std::function<Status(const Bytes&, int64_t)>& f) const {
  Result<Statement> read = const_cast<Database&>(database_).prepare(
      (std::string("SELECT sequence, count, data FROM ") + table + " WHERE step = ? ORDER BY sequence")
          .c_str());
  if (!read) return failed("reading a stroke", read.error());
  Statement& s = read.value();
  s.bind(step);
  for (int64_t sequence = 0;; sequence++) {
    const Result<bool> row = s.row();
    if (!row) return failed("reading a stroke", row.error());
    if (!row.value()) return Ok{};
    Status done = s.integer(0) == sequence ? f(s.bytes(2), s.integer(1))
                                           : Status(Error{"some of its ticks are missing"});
    if (!done) return wrong("is a damaged document: step " + std::to_string(step) + ": " + done.error());
  }
}

Status Document::for_ticks(StepId step,
                           const std::function<Status(const std::vector<StrokeTick>&)>& f) const {
  return for_blocks("tick", step, [&](const Bytes& data, int64_t count) -> Status {
    const Result<std::vector<StrokeTick>> ticks = decode_ticks(data);
    if (!ticks) return Error{ticks.error()};
    if (static_cast<int64_t>(ticks.value().size()) != count) return Error{"some of its ticks are missing"};
    return f(ticks.value());
  });
}

Status Document::for_forces(StepId step, const std::function<Status(const std::vector<Wrench>&)>& f) const {
  if (version_ < 2) return Ok{};
  return for_blocks("force", step, [&](const Bytes& data, int64_t count) -> Status {
    const Result<std::vector<Wrench>> felt = decode_forces(data);
    if (!felt) return Error{felt.error()};
    if (static_cast<int64_t>(felt.value().size()) != count) return Error{"some of its forces are missing"};
    return f(felt.value());
  });
}

Status Document::replay(StepId step, TriDexel& model, const std::optional<ForceLaw>& law,
                        const std::function<void(const ReplayedTick&)>& use) const {
  Result<StrokeSettings> read = settings(step);
  if (!read) return Error{read.error()};
  const StrokeSettings& s = read.value();
  Result<Pose> begin = start(step);
  if (!begin) return Error{begin.error()};
  Stroke stroke(model, begin.value());
  ReplayedTick out;
  out.step = step;
  int64_t count = 0;
  return for_ticks(step, [&](const std::vector<StrokeTick>& ticks) -> Status {
    for (const StrokeTick& tick : ticks) {
      const Mode mode = tick.edits ? s.mode : Mode::off;
      Result<TickResult> done = stroke.advance(s.tool, tick.tip, tick.turn, mode, law.value_or(s.force.law),
                                               s.materials, s.material);
      if (!done) return Error{done.error()};
      count++;
      if (!use) continue;
      out.recorded = &tick;
      out.result = done.value();
      if (s.force.series && !law) out.result.wrench = spring_wrench(s.force.spring, tick);
      out.time_s = static_cast<double>(count) / s.rate_hz;
      use(out);
    }
    return Ok{};
  });
}

Status Document::verify(const std::function<void(const std::string&)>& wrong_at,
                        const std::function<void(double)>& progress) const {
  auto& database = const_cast<Database&>(database_);
  Result<Statement> check = database.prepare("PRAGMA integrity_check(20)");
  if (!check) return failed("checking", check.error());
  for (;;) {
    const Result<bool> row = check.value().row();
    if (!row) return failed("checking", row.error());
    if (!row.value()) break;
    if (check.value().text(0) != "ok") wrong_at("the file's structure: " + one_line(check.value().text(0)));
  }
  Result<Statement> tiles = database.prepare("SELECT id, hash, data FROM tile");
  if (!tiles) return failed("checking", tiles.error());
  for (;;) {
    const Result<bool> row = tiles.value().row();
    if (!row) return failed("checking", row.error());
    if (!row.value()) break;
    if (hash_of(tiles.value().bytes(2)) != tiles.value().integer(1))
      wrong_at("tile " + std::to_string(tiles.value().integer(0)) + " is not what was written");
  }
  // Every way from the stock to an end of the tree, each step carved once: from the state of the one before
  // it.
  std::map<StepId, Snapshot> states;
  std::map<StepId, int> children;
  for (const auto& [id, step] : steps_) children[step.parent]++;
  TriDexel model(lattice_);
  size_t done = 0;
  for (const auto& [id, step] : steps_) {
    if (progress) progress(static_cast<double>(done++) / static_cast<double>(steps_.size()));
    const std::string which = "step " + std::to_string(id);
    Status made = Ok{};
    if (step.stock) {
      made = read_tiles(id, model);
    } else {
      const auto before = states.find(step.parent);
      if (before == states.end()) {
        wrong_at(which + " can't be carved, as the one before it can't be");
        continue;
      }
      model.restore(before->second);
      std::vector<Wrench> kept;
      if (Status s = for_forces(id,
                                [&](const std::vector<Wrench>& felt) -> Status {
                                  kept.insert(kept.end(), felt.begin(), felt.end());
                                  return Ok{};
                                });
          !s)
        wrong_at(s.error());
      int64_t ticks = 0, other_forces = 0;
      made = replay(id, model, std::nullopt, [&](const ReplayedTick& tick) {
        const auto i = static_cast<size_t>(ticks++);
        other_forces += i < kept.size() && !(kept[i].force == tick.result.wrench.force &&
                                             kept[i].moment == tick.result.wrench.moment);
      });
      if (made && !kept.empty() && static_cast<int64_t>(kept.size()) != ticks)
        wrong_at(which + " has the forces of " + std::to_string(kept.size()) + " ticks of " +
                 std::to_string(ticks));
      if (other_forces > 0)
        wrong_at(which + ": the forces kept of " + std::to_string(other_forces) +
                 " ticks are not those felt when carved again");
      if (made && ticks != step.ticks)
        wrong_at(which + " has " + std::to_string(ticks) + " ticks of " + std::to_string(step.ticks));
      if (--children[step.parent] == 0) states.erase(before);
    }
    if (!made) {
      wrong_at(made.error());
      continue;
    }
    const Snapshot now = model.snapshot();
    if (step.finished && now.content_hash() != step.hash)
      wrong_at(which + " carved again is not what it was");
    if (is_checkpoint(id) && !step.stock) {
      TriDexel kept(lattice_);
      if (Status s = read_tiles(id, kept); !s)
        wrong_at(s.error());
      else if (kept.content_hash() != step.hash)
        wrong_at("the tiles kept at " + which + " are not its state");
    }
    if (children[id] > 0) states[id] = now;
  }
  if (progress) progress(1);
  return Ok{};
}

}  // namespace kibori
