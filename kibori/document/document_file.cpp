// SPDX-License-Identifier: MIT
// A document's file: create, open, write, copy, move.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <tuple>

#include <unistd.h>

#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

namespace kibori {
namespace {

constexpr int kApplication = 0x4B49424F;  // "KIBO"
// Format versions:
//    2: forces and thumbnails
//    3: an index of tiles by place
//    4: symmetry
//    5: seals
//    6: strokes that reshape
//    7: warps, creases, paint, clay, the wheel, symmetry about an axis
//    8: start_resists of forces, two fingers on the wheel
//    9: bodies
//   10: two hands
//   11: masks that follow their bodies
//   12: forces that a device gave to the hand
//   13: materials with k, m, density and log; thrust; the version of the force law
// Files of versions 10 and 11 have the number 9.
constexpr int64_t kVersion = 13;
// Maximum number of a step. Near its own maximum, SQLite assigns new numbers in any order.
constexpr StepId kMaxSteps = StepId{1} << 62;
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
)";
const char* const kSchemaSince3 = R"(
CREATE INDEX checkpoint_tile_by_place ON checkpoint_tile (field, u, v);
)";
const char* const kSchemaSince5 = R"(
CREATE TABLE seal (step INTEGER PRIMARY KEY REFERENCES step, value TEXT NOT NULL);
)";
const char* const kSchemaSince9 = R"(
CREATE TABLE bodies (step INTEGER PRIMARY KEY REFERENCES step, json TEXT NOT NULL);
)";
const char* const kSchemaSince12 = R"(
CREATE TABLE given (step INTEGER NOT NULL REFERENCES step, sequence INTEGER NOT NULL, count INTEGER NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY (step, sequence)) WITHOUT ROWID;
)";
const std::string kThisVersion = "PRAGMA user_version = " + std::to_string(kVersion);

// Removes a database and the files that SQLite may leave next to it.
void clear_away(const std::filesystem::path& path) {
  std::error_code code;
  for (const char* rest : {"", "-wal", "-shm", "-journal"})
    std::filesystem::remove(path.string() + rest, code);
}

// Ok if a new document can be created at `path`. It also rejects files that a killed process left
// next to a deleted document. They would become part of the new one.
Status check_free(const std::filesystem::path& path) {
  std::error_code code;
  const std::string name = sanitize_message(path.string());
  if (std::filesystem::exists(path, code))
    return Error{name + ": already exists; give another name or remove it"};
  for (const char* rest : {"-wal", "-journal"}) {
    const std::filesystem::path log = path.string() + rest;
    if (std::filesystem::exists(log, code) && std::filesystem::file_size(log, code) > 0)
      return Error{name + rest +
                   ": its document is missing, and it contains the end of that document's last "
                   "stroke; put the document back next to it, or remove it"};
    std::filesystem::remove(log, code);
  }
  std::filesystem::remove(path.string() + "-shm", code);
  return Ok{};
}

// Moves a file to its name after it is on the disk. It uses a link, because a rename would replace
// a file that was created there in the meantime. Some file systems have no links; there it renames.
bool put_in_place(const std::filesystem::path& part, const std::filesystem::path& path) {
  std::error_code code;
  if (!sync_to_disk(part)) {
    clear_away(part);
    return false;
  }
  const bool there =
      ::link(part.c_str(), path.c_str()) == 0 ||
      (!std::filesystem::exists(path, code) && ::rename(part.c_str(), path.c_str()) == 0);
  std::filesystem::remove(part, code);
  sync_name(path);
  return there;
}

std::unique_ptr<DocumentStorage> storage_of(Database database) {
  auto storage = std::make_unique<DocumentStorage>();
  storage->database = std::move(database);
  return storage;
}

}  // namespace

Document::Document(std::unique_ptr<DocumentStorage> storage) : storage_(std::move(storage)) {}

const std::string& Document::name() const { return storage_->database.name(); }

Document::~Document() {
  if (unsaved_.empty()) keep_some_tiles(std::chrono::minutes(1));
  storage_->keeper.reset();
  // A reader that is the last to close the file must not remove what a killed writer left next to
  // it.
  std::error_code none;
  if (!writes_ && std::filesystem::file_size(storage_->log, none) > 0 && !none)
    storage_->database.keep_log();
  // Now the file is complete and needs no log, so the mark is removed. If the file was not
  // writable, the mark stays.
  if (marked_ && unsaved_.empty()) static_cast<void>(mark(false));
}

Status Document::commit(const char* doing, const std::function<Status()>& change) {
  if (!writes_) return wrong("is open read-only");
  bool disk_failed = false;
  Status done = try_commit(doing, change, disk_failed);
  if (done || !disk_failed || !may_go_to_memory_ || !unsaved_.empty()) return done;
  Result<Database> memory = Database::in_memory(storage_->database);
  if (!memory) return done;
  storage_->file = std::exchange(storage_->database, std::move(memory).value());
  Status again = try_commit(doing, change, disk_failed);
  if (again)
    unsaved_ = done.error();
  else
    storage_->database = std::move(storage_->file);
  return again;
}

Status Document::save_again() {
  if (unsaved_.empty()) return Ok{};
  // Waiting data goes into the database in memory first, so that the saved file is complete.
  if (Status s = flush(); !s) return s;
  if (Status s = storage_->file.become(storage_->database); !s) return failed("saving", s.error());
  storage_->database = std::move(storage_->file);
  unsaved_.clear();
  return Ok{};
}

Status Document::move_to(const std::filesystem::path& path) {
  if (!writes_) return wrong("is open read-only");
  if (Status s = flush(); !s) return s;
  if (Status s = save_copy(path); !s) return s;
  Result<std::unique_ptr<Document>> there = attach(path, nullptr);
  if (there)
    if (Status s = there.value()->prepare_writing(); !s) there = Error{s.error()};
  if (there)
    if (Status s = there.value()->begin_writing(path, nullptr); !s) there = Error{s.error()};
  if (!there) {
    std::error_code code;
    std::filesystem::remove(path, code);
    return Error{there.error()};
  }
  storage_->database = std::move(there.value()->storage_->database);
  storage_->file = Database();
  storage_->lock = std::move(there.value()->storage_->lock);
  storage_->keeper = std::move(there.value()->storage_->keeper);
  marked_ = std::exchange(there.value()->marked_, false);
  session_ = there.value()->session_;
  before_session_ = there.value()->before_session_;
  commits_ = there.value()->commits_;
  unsaved_.clear();
  return Ok{};
}

Status Document::try_commit(const char* doing, const std::function<Status()>& change,
                            bool& disk_failed) {
  if (Status s = storage_->database.run("BEGIN IMMEDIATE"); !s) {
    disk_failed = storage_->database.disk_failed();
    return failed(doing, s.error());
  }
  Status done = change();
  if (done) done = count_commit();
  if (!done && !done.error().starts_with(name())) done = failed(doing, done.error());
  if (done) {
    if (Status s = storage_->database.run("COMMIT"); !s) done = failed(doing, s.error());
  }
  if (!done) {
    disk_failed = storage_->database.disk_failed();
    static_cast<void>(storage_->database.run("ROLLBACK"));
    return done;
  }
  commits_++;
  if (storage_->keeper) storage_->keeper->wrote();
  return done;
}

Result<std::unique_ptr<Document>> Document::create(const std::filesystem::path& path,
                                                   const TriDexel& model, const std::string& stock,
                                                   const Bytes& source, const char* vfs) {
  const std::string name = sanitize_message(path.string());
  if (Status s = check_free(path); !s) return Error{s.error()};
  // Complete or not at all: it is created next to `path`, and moved into place when it is a valid
  // document.
  const Result<std::filesystem::path> sibling = make_sibling(path);
  if (!sibling)
    return Error{name + ": cannot be created; check that the folder exists and is writable"};
  const std::filesystem::path& part = sibling.value();
  Result<Database> made = Database::open(part, Database::Access::create, vfs);
  if (!made) {
    clear_away(part);
    return Error{name + ": cannot be created; check that the folder exists and is writable"};
  }
  {
    std::unique_ptr<Document> document(new Document(storage_of(std::move(made).value())));
    document->writes_ = true;
    document->lattice_ = model.lattice();
    document->lattice_.below = document->lattice_.above = Index3::Zero();
    const Snapshot now = model.snapshot();
    const Status filled = [&]() -> Status {
      const std::string first = "PRAGMA application_id=" + std::to_string(kApplication);
      if (Status s = document->storage_->database.run(first.c_str()); !s) return s;
      return document->commit("making it", [&]() -> Status {
        for (const char* tables : {kSchema, kSchemaSince2, kSchemaSince3, kSchemaSince5,
                                   kSchemaSince9, kSchemaSince12, kThisVersion.c_str()})
          if (Status s = document->storage_->database.run(tables); !s) return s;
        Result<Statement> meta =
            document->storage_->database.prepare("INSERT INTO meta VALUES (?, ?)");
        if (!meta) return Error{meta.error()};
        Statement& m = meta.value();
        for (const auto& [key, value] :
             {std::pair<std::string, std::string>{"lattice", lattice_to_json(model.lattice())},
              {"stock", stock},
              {"program", "kibori " KIBORI_VERSION}})
          if (Status s = m.bind(key).bind(value).run(); !s) return s;
        if (Status s = m.bind(std::string_view("source")).bind(source).run(); !s) return s;
        if (Status s = m.bind(std::string_view("head")).bind(int64_t{1}).run(); !s) return s;
        Result<Statement> step = document->storage_->database.prepare(
            "INSERT INTO step (id, kind, hash, finished) VALUES (1, 'stock', ?, 1)");
        if (!step) return Error{step.error()};
        const uint64_t hash = now.content_hash();
        if (Status s = step.value().bind(hash_text(hash)).run(); !s) return s;
        Step first_step;
        first_step.id = 1;
        first_step.stock = true;
        first_step.hash = hash;
        document->steps_[1] = first_step;
        TileJob tiles;
        tiles.step = 1;
        tiles.now = BodyList::of(model);
        tiles.bounds = model.material_bounds();
        if (Status s = document->plan_tiles(tiles); !s) return s;
        if (Status s = document->seal_all(); !s) return s;
        if (Status s = document->write_head(1); !s) return s;
        return document->keep_tiles(tiles, std::chrono::steady_clock::time_point::max());
      });
    }();
    if (!filled) {
      document.reset();
      clear_away(part);
      return Error{name + ": cannot be created (" + filled.error() + ")"};
    }
  }
  if (!put_in_place(part, path)) return Error{name + ": cannot be moved to its final name"};
  Result<std::unique_ptr<Document>> opened = open(path, Access::write, vfs);
  if (opened) opened.value()->remember(1, BodyList::of(model));
  return opened;
}

Result<std::unique_ptr<Document>> Document::open(const std::filesystem::path& path, Access access,
                                                 const char* vfs) {
  std::error_code code;
  const std::string name = sanitize_message(path.string());
  if (!std::filesystem::exists(path, code)) return Error{name + ": there is no such file"};
  if (!std::filesystem::is_regular_file(path, code)) return Error{name + ": is not a file"};
  Result<std::unique_ptr<Document>> attached =
      access == Access::write ? attach(path, vfs) : attach_reader(path, vfs);
  if (!attached) return attached;
  std::unique_ptr<Document> document = std::move(attached).value();
  const std::string missing_pages = document->damage();
  if (Status s = document->read_tree(); !s) {
    if (missing_pages.empty()) return Error{s.error()};
    return document->wrong("is a damaged document: " + missing_pages +
                           ", and it cannot be read at all");
  }
  if (access == Access::write && !document->damage().empty())
    return document->wrong("is a damaged document: " + document->damage() + "; 'kibori history " +
                           name + " --salvage NEW.kibori' saves the undamaged steps");
  if (access == Access::write)
    if (Status s = document->prepare_writing(); !s) return Error{s.error()};
  if (Status s = document->recover(); !s) return Error{s.error()};
  if (access == Access::write)
    if (Status s = document->begin_writing(path, vfs); !s) return Error{s.error()};
  document->may_go_to_memory_ = document->writes_;
  return document;
}

Result<std::unique_ptr<Document>> Document::attach(const std::filesystem::path& path,
                                                   const char* vfs) {
  Result<FileLock> lock = FileLock::take(path);
  if (!lock) return Error{lock.error()};
  const Result<std::string> missing = check_logs(path);
  if (!missing) return Error{missing.error()};
  if (!missing.value().empty())
    return Error{sanitize_message(path.string()) + ": is a damaged document: " + missing.value() +
                 "; 'kibori history " + sanitize_message(path.string()) +
                 " --salvage NEW.kibori' saves the undamaged steps"};
  std::error_code none;
  const bool log = std::filesystem::exists(
      std::filesystem::weakly_canonical(path, none).string() + "-wal", none);
  Result<Database> database = Database::open(path, Database::Access::write, vfs);
  if (!database) return Error{database.error()};
  std::unique_ptr<Document> document(new Document(storage_of(std::move(database).value())));
  document->storage_->lock = std::move(lock).value();
  if (Status s = document->check_kind(); !s) return Error{s.error()};
  if (document->storage_->database.read_only())
    return document->wrong(
        "is not writable; open it with --read-only, or copy it to a writable folder");
  if (Status s = document->look_for_log(log); !s) return Error{s.error()};
  return document;
}

Status Document::prepare_writing() {
  writes_ = true;
  auto& database = storage_->database;
  if (Status s = database.run(
          "PRAGMA journal_mode=WAL; PRAGMA foreign_keys=ON; PRAGMA synchronous=NORMAL; "
          "PRAGMA wal_autocheckpoint=0");
      !s)
    return failed("opening", s.error());
  if (version_ == kVersion) return Ok{};
  const Status updated = commit("bringing it up to date", [&]() -> Status {
    for (const auto& [since, sql] : {std::pair{2, kSchemaSince2},
                                     {3, kSchemaSince3},
                                     {5, kSchemaSince5},
                                     {9, kSchemaSince9},
                                     {12, kSchemaSince12}})
      if (version_ < since)
        if (Status made = database.run(sql); !made) return made;
    if (version_ < 5)
      if (Status sealed = seal_all(); !sealed) return sealed;
    return database.run(kThisVersion.c_str());
  });
  if (!updated) return updated;
  version_ = kVersion;
  return Ok{};
}

Status Document::begin_writing(const std::filesystem::path& path, const char* vfs) {
  Result<Database> another = Database::open(path, Database::Access::write, vfs);
  if (!another) return Error{another.error()};
  // If the disk is full, the document continues without a mark.
  static_cast<void>(mark(true));
  storage_->keeper = std::make_unique<LogKeeper>(std::move(another).value());
  return Ok{};
}

// Checks that the file is a document of Kibori in a version that this program reads.
Status Document::check_kind() {
  const auto pragma = [&](const char* sql) -> Result<int64_t> {
    Result<Statement> read = storage_->database.prepare(sql);
    if (!read) return Error{read.error()};
    const Result<bool> row = read.value().row();
    if (!row) return Error{row.error()};
    return row.value() ? read.value().integer(0) : 0;
  };
  const Result<int64_t> application = pragma("PRAGMA application_id");
  if (!application)
    return wrong((storage_->database.disk_failed()
                      ? "can't be opened: its disk is full, not readable or not writable ("
                      : "is not a document of Kibori (") +
                 application.error() + ")");
  if (application.value() != kApplication) return wrong("is not a document of Kibori");
  const Result<int64_t> version = pragma("PRAGMA user_version");
  if (!version || version.value() < 1) return wrong("is a damaged document");
  version_ = version.value();
  if (is_newer())
    return wrong("was made by a newer Kibori (format " + std::to_string(version.value()) +
                 ", this one reads " + std::to_string(kVersion) + "); use that version");
  return check_tables();
}

bool Document::is_newer() const { return version_ > kVersion; }

// The definitions of the tables must be Kibori's, word for word. Something with the name of a table
// can be a view, have computed columns, or be a virtual table. SQLite would then run code that the
// file chooses.
Status Document::check_tables() {
  using Tables = std::set<std::tuple<std::string, std::string, std::string, std::string>>;
  constexpr size_t kMaxTables = 64;
  const auto tables_of = [](Database& database) -> Result<Tables> {
    Result<Statement> read =
        database.prepare("SELECT type, name, tbl_name, sql FROM sqlite_master");
    if (!read) return Error{read.error()};
    Tables tables;
    Statement& r = read.value();
    const Status done = r.for_rows([&]() -> Status {
      std::string sql;
      for (const char c : r.text(3))  // whitespace makes no difference
        if (!std::isspace(static_cast<unsigned char>(c)))
          sql += c;
        else if (!sql.empty() && sql.back() != ' ')
          sql += ' ';
      tables.emplace(r.text(0), r.text(1), r.text(2), sql);
      return tables.size() <= kMaxTables ? Status(Ok{}) : Status(Error{"too many tables"});
    });
    return done ? Result<Tables>(tables) : Result<Tables>(Error{done.error()});
  };
  Result<Database> model = Database::open(":memory:", Database::Access::create);
  if (!model) return Error{model.error()};
  for (const auto& [since, sql] : {std::pair{1, kSchema},
                                   {2, kSchemaSince2},
                                   {3, kSchemaSince3},
                                   {5, kSchemaSince5},
                                   {9, kSchemaSince9},
                                   {12, kSchemaSince12}})
    if (version_ >= since)
      if (Status s = model.value().run(sql); !s) return failed("opening", s.error());
  const Result<Tables> ours = tables_of(model.value()), found = tables_of(storage_->database);
  if (!ours) return failed("opening", ours.error());
  if (!found) return wrong("is a damaged document (" + found.error() + ")");
  for (const auto& table : found.value())
    if (!ours.value().count(table))
      return wrong("is not a document of Kibori: its " +
                   sanitize_message(std::get<0>(table) + " '" + std::get<1>(table)) +
                   "' differs from that of Kibori");
  for (const auto& table : ours.value())
    if (!found.value().count(table))
      return wrong("is a damaged document: it has no " + std::get<0>(table) + " '" +
                   std::get<1>(table) + "'");
  return Ok{};
}

namespace {

Status for_rows(Database& database, const char* sql, const std::function<Status(Statement&)>& f) {
  Result<Statement> read = database.prepare(sql);
  if (!read) return Error{read.error()};
  return read.value().for_rows([&] { return f(read.value()); });
}

Status read_lattice(Database& database, Lattice& lattice) {
  bool placed = false;
  const Status done = for_rows(database, "SELECT value FROM meta WHERE key = 'lattice'",
                               [&](Statement& s) -> Status {
                                 Result<Lattice> read = lattice_from_json(s.text(0));
                                 if (!read) return Error{read.error()};
                                 lattice = read.value();
                                 placed = true;
                                 return Ok{};
                               });
  if (!done || placed) return done;
  return Error{"its lattice (pitch, origin, size) is missing or invalid"};
}

// Reads the body of each stroke's settings. Skips damaged settings, because Document::settings()
// reports them.
Status read_bodies_of_settings(Database& database, std::map<int64_t, BodyId>& body_of) {
  return for_rows(database, "SELECT id, json FROM setting", [&](Statement& s) -> Status {
    const Result<StrokeSettings> settings = settings_from_json(s.text(1));
    if (settings) body_of[s.integer(0)] = settings.value().body;
    return Ok{};
  });
}

using OnFault = std::function<void(StepId, const std::string&)>;

// Reads all steps that can be read. Reports the others. Error: there is no stock.
Status read_steps(Database& database, std::map<StepId, Step>& steps, const OnFault& fault) {
  std::map<int64_t, BodyId> body_of;
  if (Status done = read_bodies_of_settings(database, body_of); !done)
    fault(0, "its settings can't be read (" + done.error() + ")");
  const Status done = for_rows(
      database,
      "SELECT id, parent, kind, label, ticks, removed_mm3, hash, finished, (SELECT "
      "coalesce(sum(count), 0) "
      "FROM tick WHERE tick.step = step.id AND step.finished = 0), CAST(strftime('%s', made_at) "
      "AS "
      "INTEGER), setting FROM step ORDER BY id",
      [&](Statement& s) -> Status {
        Step step;
        step.id = s.integer(0);
        step.parent = s.null(1) ? 0 : s.integer(1);
        step.stock = s.text(2) == "stock";
        step.action = s.text(2) == "bodies";
        // For an action, the step before it determines the body that strokes act on.
        step.body = 0;
        if (const auto body = body_of.find(s.integer(10)); body != body_of.end() && !step.action)
          step.body = body->second;
        step.label = s.text(3);
        step.finished = s.integer(7) != 0;
        step.ticks = step.finished ? s.integer(4) : s.integer(8);
        step.removed_mm3 = s.real(5);
        step.hash = std::strtoull(s.text(6).c_str(), nullptr, 16);
        step.made_s = s.integer(9);
        step.setting = s.integer(10);
        const bool known =
            step.stock ? step.parent == 0 && steps.empty() : steps.count(step.parent) != 0;
        // Each step must be unique and follow its parent. Therefore, there are no cycles.
        if (step.id < 1 || step.id > kMaxSteps || !known || steps.count(step.id)) {
          fault(0, "step " + std::to_string(step.id) + " has no parent step in the file");
          return Ok{};
        }
        if (const auto parent = steps.find(step.parent);
            parent != steps.end() && !parent->second.finished)
          fault(step.parent, "step " + std::to_string(step.parent) +
                                 " is marked as unfinished, but a step follows it");
        steps[step.id] = step;
        return Ok{};
      });
  if (steps.empty()) return Error{done ? "its stock is missing" : done.error()};
  if (!done)
    fault(0, "steps after " + std::to_string(steps.rbegin()->first) + " can't be read (" +
                 done.error() + ")");
  return Ok{};
}

// Reads the bodies after each step that changed them.
Status read_lists(Database& database, const std::map<StepId, Step>& steps,
                  std::map<StepId, BodyList>& lists, const OnFault& fault) {
  return for_rows(database, "SELECT step, json FROM bodies", [&](Statement& s) -> Status {
    const StepId step = s.integer(0);
    if (!steps.count(step)) return Ok{};
    Result<BodyList> bodies = bodies_from_json(s.text(1));
    if (bodies)
      lists[step] = std::move(bodies).value();
    else
      fault(step, "step " + std::to_string(step) + ": " + bodies.error());
    return Ok{};
  });
}

}  // namespace

void Document::add_damage(StepId step, const std::string& fault) {
  damage_.push_back(fault);
  if (step != 0) broken_.emplace(step, fault);
}

Status Document::read_tree() {
  Database& database = storage_->database;
  const OnFault fault = [this](StepId step, const std::string& what) { add_damage(step, what); };
  // If only a part of a table can be read, the rest is damaged, and salvage uses the part.
  const auto read = [&](const char* table, const char* sql,
                        const std::function<Status(Statement&)>& f) {
    if (const Status done = for_rows(database, sql, f); !done)
      fault(0, std::string("its table '") + table + "' can't be read (" + done.error() + ")");
  };
  read("meta", "SELECT value FROM meta WHERE key = 'head'", [&](Statement& s) -> Status {
    head_ = head_in_file_ = s.integer(0);
    return Ok{};
  });
  Status needed = read_lattice(database, lattice_);
  if (needed) needed = read_steps(database, steps_, fault);
  if (!needed)
    return wrong("is a damaged document: " + (damage_.empty() ? "" : damage_.front() + "; ") +
                 needed.error());
  if (version_ >= 9)
    if (const Status done = read_lists(database, steps_, lists_, fault); !done)
      fault(0, "its bodies can't be read (" + done.error() + ")");
  head_lost_ = !steps_.count(head_);
  if (head_lost_) {
    fault(0, "its current step " + std::to_string(head_) + " is missing");
    head_ = steps_.rbegin()->first;
  }
  active_ = active_at(head_);
  read("version", "SELECT name, step FROM version", [&](Statement& s) -> Status {
    if (steps_.count(s.integer(1))) versions_[s.text(0)] = s.integer(1);
    return Ok{};
  });
  if (version_ >= 2)
    read("thumbnail", "SELECT step FROM thumbnail", [&](Statement& s) -> Status {
      if (const auto found = steps_.find(s.integer(0)); found != steps_.end())
        found->second.pictured = true;
      return Ok{};
    });
  read("checkpoint", "SELECT step, bounds FROM checkpoint", [&](Statement& s) -> Status {
    const StepId step = s.integer(0);
    if (!steps_.count(step)) return Ok{};
    const Result<LatticeBox> box = box_from_json(s.text(1));
    if (box)
      add_checkpoint(step, box.value());
    else
      fault(step, "step " + std::to_string(step) + " has tiles without valid bounds");
    return Ok{};
  });
  if (!checkpoints_.count(steps_.begin()->first))
    return wrong("is a damaged document: the stock's tiles are missing");
  look_at_seals();
  return Ok{};
}

// Finishes strokes whose process was killed, with the ticks that were written. They are the newest
// steps.
Status Document::recover() {
  for (auto& entry : steps_) {
    const StepId id = entry.first;
    Step& step = entry.second;
    if (step.finished || std::any_of(steps_.begin(), steps_.end(),
                                     [id](const auto& other) { return other.second.parent == id; }))
      continue;
    if (writes_) {
      TriDexel model(lattice_), before(lattice_);
      // Damaged data stays unchanged. Loading it reports the damage.
      const Result<BodyList> was = make_state(before, step.parent), now = make_state(model, id);
      if (!was || !now) {
        head_ = id;
        continue;
      }
      step.hash = now.value().content_hash();
      const bool other_bodies = now.value().all.size() != was.value().all.size();
      Status kept = commit("finishing an interrupted stroke", [&]() -> Status {
        Result<Statement> update = storage_->database.prepare(
            "UPDATE step SET finished = 1, ticks = ?, hash = ?, removed_mm3 = ? WHERE id = ?");
        if (!update) return Error{update.error()};
        step.removed_mm3 = was.value().volume_mm3() - now.value().volume_mm3();
        if (other_bodies)
          if (Status s = write_bodies(id, now.value()); !s) return s;
        if (Status s = update.value()
                           .bind(step.ticks)
                           .bind(hash_text(step.hash))
                           .bind(step.removed_mm3)
                           .bind(id)
                           .run();
            !s)
          return s;
        return seal(id);
      });
      if (!kept) return kept;
      step.finished = true;
      if (other_bodies) list(id, now.value());
      if (Status s = set_head(id); !s) return s;
    } else {
      head_ = head_in_file_ = id;
    }
  }
  return Ok{};
}

Result<std::string> Document::stock() const {
  Result<Statement> read = storage_->database.prepare("SELECT value FROM meta WHERE key = 'stock'");
  if (!read) return failed("reading the stock", read.error());
  const Result<bool> row = read.value().row();
  if (!row) return failed("reading the stock", row.error());
  return row.value() ? read.value().text(0) : std::string();
}

Result<Bytes> Document::source() const {
  Result<Statement> read =
      storage_->database.prepare("SELECT value FROM meta WHERE key = 'source'");
  if (!read) return failed("reading the stock's file", read.error());
  const Result<bool> row = read.value().row();
  if (!row) return failed("reading the stock's file", row.error());
  return row.value() ? read.value().bytes(0) : Bytes();
}

Status Document::save_copy(const std::filesystem::path& path) const {
  const std::string name = sanitize_message(path.string());
  if (Status s = check_free(path); !s) return s;
  const Result<std::filesystem::path> sibling = make_sibling(path);
  if (!sibling) return Error{sibling.error()};
  const std::filesystem::path& part = sibling.value();
  // A reader is always in a transaction, and SQLite cannot write another file during a transaction.
  auto& database = storage_->database;
  if (!writes_) static_cast<void>(database.run("COMMIT; PRAGMA query_only = 0"));
  const Status copied = [&]() -> Status {
    Result<Statement> copy = database.prepare("VACUUM INTO ?");
    if (!copy) return Error{copy.error()};
    std::error_code code;
    return copy.value().bind(std::filesystem::absolute(part, code).string()).run();
  }();
  if (!writes_) static_cast<void>(database.run("PRAGMA query_only = 1; BEGIN"));
  if (copied) {
    // In WAL mode, others can read the copy while a process writes it. The copy is complete, so it
    // needs no mark, unless the log is missing.
    Result<Database> made = Database::open(part, Database::Access::write);
    if (made)
      static_cast<void>(made.value().run(
          missing_.empty() ? "DELETE FROM meta WHERE key = 'writing'; PRAGMA journal_mode = WAL"
                           : "PRAGMA journal_mode = WAL"));
  } else {
    clear_away(part);
    return Error{name + ": can't be written (" + copied.error() + ")"};
  }
  if (!put_in_place(part, path)) return Error{name + ": cannot be moved to its final name"};
  return Ok{};
}

}  // namespace kibori
