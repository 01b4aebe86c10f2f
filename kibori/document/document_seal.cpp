// SPDX-License-Identifier: MIT
// Seals, which show that a row was changed or is missing. Each finished step has a seal: a hash
// over its row and its parent's seal, and hashes of its rows in `tick`, `force` and `given`. `meta`
// has the number of seals, a hash over all seals in order, a hash over the versions, and one of the
// head. While a process writes a document, a mark in `meta` says so. If the mark exists but the log
// does not, the last steps may be missing.
#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

#include <random>

namespace kibori {
namespace {

constexpr size_t kHashDigits = 16;

void add(Hash& hash, std::string_view text) {
  hash.add(reinterpret_cast<const uint8_t*>(text.data()), text.size());
}

// The start of the chain of seals: a hash of the lattice, the stock, and its source.
Result<uint64_t> seal_of_stock(Database& database) {
  Result<Statement> read = database.prepare(
      "SELECT key, value FROM meta WHERE key IN ('lattice', 'stock', 'source') ORDER BY key");
  if (!read) return Error{read.error()};
  Hash hash;
  const Status done = read.value().for_rows([&]() -> Status {
    add(hash, read.value().text(0));
    const Bytes value = read.value().bytes(1);
    hash.add(value.data(), value.size());
    return Ok{};
  });
  if (!done) return Error{done.error()};
  return hash.value();
}

// The key in `meta` for the last commit. The value has the writer's session and the number of the
// commit in it. For the first commit of a session, it also has the previous commit. The commits
// show to which file a log belongs.
const char* const kCommit = "commit";

const char* const kOtherVersions = "the named versions were changed";

// Hash of the head's step number.
std::string seal_of_head(const std::string& head) {
  Hash hash;
  add(hash, head);
  return hash_text(hash.value());
}

Result<std::string> seal_of_versions(Database& database) {
  Result<Statement> read = database.prepare("SELECT name, step FROM version ORDER BY name");
  if (!read) return Error{read.error()};
  Hash hash;
  const Status done = read.value().for_rows([&]() -> Status {
    add(hash, read.value().text(0));
    hash.add(static_cast<uint64_t>(read.value().integer(1)));
    return Ok{};
  });
  if (!done) return Error{done.error()};
  return hash_text(hash.value());
}

// A hash over a step's rows in a table.
Result<uint64_t> hash_of_blocks(Database& database, BlockTable table, StepId step) {
  const std::string sql = "SELECT sequence, count, data FROM " + std::string(name_of(table)) +
                          " WHERE step = ? ORDER BY sequence";
  Result<Statement> read = database.prepare(sql.c_str());
  if (!read) return Error{read.error()};
  Statement& row = read.value();
  Hash hash;
  const Status done = row.bind(step).for_rows([&]() -> Status {
    add_block(hash, row.integer(0), row.integer(1), row.bytes(2));
    return Ok{};
  });
  return done ? Result<uint64_t>(hash.value()) : Result<uint64_t>(Error{done.error()});
}

// The columns that seal_of_row reads. Steps without a row in `bodies` have NULL there.
std::string select_rows(bool has_bodies) {
  return std::string(
             "SELECT step.id, parent, kind, label, setting.json, start, ticks, removed_mm3, hash, "
             "made_at, finished, seal.value, ") +
         (has_bodies ? "bodies.json" : "NULL") +
         " FROM step LEFT JOIN setting ON setting.id = setting LEFT JOIN seal ON seal.step = "
         "step.id" +
         (has_bodies ? " LEFT JOIN bodies ON bodies.step = step.id" : "");
}

// The seal of the current row of a statement of select_rows(). `blocks`: the hashes of the blocks
// of that step as text; empty if an older version, which did not include them, wrote the seal.
uint64_t seal_of_row(const Statement& row, const std::string& parent_seal,
                     const std::string& blocks) {
  Hash hash;
  hash.add(static_cast<uint64_t>(row.integer(0)));
  hash.add(static_cast<uint64_t>(row.integer(1)));
  for (const int column : {2, 3, 4}) add(hash, row.text(column));
  const Bytes start = row.bytes(5);
  hash.add(start.data(), start.size());
  hash.add(static_cast<uint64_t>(row.integer(6)));
  hash.add(row.real(7));
  for (const int column : {8, 9}) add(hash, row.text(column));
  add(hash, parent_seal);
  if (!row.null(12)) add(hash, row.text(12));
  if (!blocks.empty()) add(hash, blocks);
  return hash.value();
}

std::string text_of(const std::array<uint64_t, 3>& blocks) {
  std::string text;
  for (const uint64_t hash : blocks) {
    text += ' ';
    text += hash_text(hash);
  }
  return text;
}

uint64_t number_of(const std::string& hash) { return std::strtoull(hash.c_str(), nullptr, 16); }

// The part of a seal's text after the hash of the row.
std::string blocks_of(const std::string& seal) {
  return seal.size() > kHashDigits ? seal.substr(kHashDigits) : std::string();
}

uint64_t chained(uint64_t before, uint64_t seal) {
  Hash hash;
  hash.add(before);
  hash.add(seal);
  return hash.value();
}

Result<std::string> meta(Database& database, const char* key) {
  Result<Statement> read = database.prepare("SELECT value FROM meta WHERE key = ?");
  if (!read) return Error{read.error()};
  const Result<bool> row = read.value().bind(std::string_view(key)).row();
  if (!row) return Error{row.error()};
  return row.value() ? read.value().text(0) : std::string();
}

Status set_meta(Database& database, const char* key, const std::string& value) {
  Result<Statement> put = database.prepare("INSERT OR REPLACE INTO meta VALUES (?, ?)");
  return put ? put.value().bind(std::string_view(key)).bind(value).run()
             : Status(Error{put.error()});
}

}  // namespace

Status Document::seal(StepId step) {
  auto& database = storage_->database;
  const Result<std::string> before = meta(database, "seal"), count = meta(database, "sealed_steps");
  if (!before || !count) return Error{before ? count.error() : before.error()};
  Result<uint64_t> chain = number_of(before.value());
  if (before.value().empty()) chain = seal_of_stock(database);
  if (!chain) return Error{chain.error()};
  std::array<uint64_t, 3> blocks{};
  for (size_t i = 0; i < blocks.size(); i++) {
    const Result<uint64_t> hash = hash_of_blocks(database, static_cast<BlockTable>(i), step);
    if (!hash) return Error{hash.error()};
    blocks[i] = hash.value();
  }
  const std::string sql = select_rows(true) + " WHERE step.id = ?";
  Result<Statement> read = database.prepare(sql.c_str());
  Result<Statement> parent = database.prepare("SELECT value FROM seal WHERE step = ?");
  Result<Statement> put = database.prepare("INSERT OR REPLACE INTO seal VALUES (?, ?)");
  if (!read) return Error{read.error()};
  if (!parent) return Error{parent.error()};
  if (!put) return Error{put.error()};
  const Result<bool> there = read.value().bind(step).row();
  if (!there) return Error{there.error()};
  if (!there.value()) return Error{"step " + std::to_string(step) + " is missing"};
  const Result<bool> follows = parent.value().bind(read.value().integer(1)).row();
  if (!follows) return Error{follows.error()};
  const uint64_t sealed = seal_of_row(
      read.value(), follows.value() ? parent.value().text(0) : std::string(), text_of(blocks));
  if (Status s = put.value().bind(step).bind(hash_text(sealed) + text_of(blocks)).run(); !s)
    return s;
  sealed_blocks_[step] = blocks;
  if (Status s = set_meta(database, "seal", hash_text(chained(chain.value(), sealed))); !s)
    return s;
  return set_meta(database, "sealed_steps",
                  std::to_string(std::strtoll(count.value().c_str(), nullptr, 10) + 1));
}

Status Document::seal_all() {
  std::vector<StepId> finished;
  {
    Result<Statement> read =
        storage_->database.prepare("SELECT id FROM step WHERE finished = 1 ORDER BY id");
    if (!read) return Error{read.error()};
    Status done = read.value().for_rows([&]() -> Status {
      finished.push_back(read.value().integer(0));
      return Ok{};
    });
    if (!done) return done;
  }
  for (const StepId step : finished)
    if (Status s = seal(step); !s) return s;
  return seal_versions();
}

Status Document::seal_versions() {
  const Result<std::string> now = seal_of_versions(storage_->database);
  return now ? set_meta(storage_->database, "version_seal", now.value())
             : Status(Error{now.error()});
}

Status Document::check_seals(
    const std::function<void(StepId, const std::string&)>& wrong_at) const {
  if (version_ < 5) return Ok{};
  auto& database = storage_->database;
  Result<uint64_t> chain = seal_of_stock(database);
  if (!chain) return Error{chain.error()};
  const std::string sql = select_rows(version_ >= 9) + " ORDER BY step.id";
  Result<Statement> read = database.prepare(sql.c_str());
  if (!read) return Error{read.error()};
  Statement& row = read.value();
  std::unordered_map<StepId, std::string> seals;
  int64_t count = 0;
  bool rows_hold = true;
  const auto wrong = [&](StepId step, const std::string& what) {
    rows_hold = false;
    wrong_at(step, "step " + std::to_string(step) + what);
  };
  Status done = row.for_rows([&]() -> Status {
    const StepId step = row.integer(0);
    std::string written = row.text(11);
    if (row.integer(10) == 0) {
      if (row.null(11)) return Ok{};
      seals.emplace(step, std::move(written));
      wrong(step, " is marked as unfinished, but it was finished");
      return Ok{};
    }
    const auto parent = seals.find(row.integer(1));
    const uint64_t sealed = seal_of_row(row, parent == seals.end() ? std::string() : parent->second,
                                        blocks_of(written));
    if (hash_text(sealed) + blocks_of(written) != written)
      wrong(step,
            ": its label, time, settings, numbers or parent step were changed since they were "
            "written");
    chain = chained(chain.value(), sealed);
    count++;
    seals.emplace(step, std::move(written));
    return Ok{};
  });
  if (!done) return done;
  const Result<std::string> sealed = meta(database, "sealed_steps"), last = meta(database, "seal"),
                            versions = meta(database, "version_seal"),
                            now = seal_of_versions(database);
  if (!sealed || !last || !versions || !now) return Error{"the seals can't be read"};
  const long long written = std::strtoll(sealed.value().c_str(), nullptr, 10);
  if (count != written)
    wrong_at(0, "it has only " + std::to_string(count) + " of " + std::to_string(written) +
                    " finished steps");
  else if (rows_hold && last.value() != hash_text(chain.value()))
    wrong_at(steps_.begin()->first,
             "the lattice, the stock or the order of the steps was changed since it was written");
  if (versions.value() != now.value()) wrong_at(0, kOtherVersions);
  const Result<std::string> head = meta(database, "head"), stands = meta(database, "head_seal");
  if (!head || !stands) return Error{"the head can't be read"};
  if (!stands.value().empty() && stands.value() != seal_of_head(head.value()))
    wrong_at(0, "its current step was changed since it was written");
  return Ok{};
}

void Document::look_at_seals() {
  if (version_ < 5) return;
  const Status read = check_seals([&](StepId step, const std::string& fault) {
    versions_changed_ |= fault == kOtherVersions;
    add_damage(step, fault);
  });
  if (!read) add_damage(0, "its seals can't be read (" + read.error() + ")");
  Result<Statement> seals = storage_->database.prepare("SELECT step, value FROM seal");
  if (!seals) return;
  static_cast<void>(seals.value().for_rows([&]() -> Status {
    const std::string blocks = blocks_of(seals.value().text(1));
    if (blocks.size() != 3 * (kHashDigits + 1)) return Ok{};
    std::array<uint64_t, 3>& hashes = sealed_blocks_[seals.value().integer(0)];
    for (size_t i = 0; i < hashes.size(); i++)
      hashes[i] = number_of(blocks.substr(i * (kHashDigits + 1) + 1, kHashDigits));
    return Ok{};
  }));
}

Status Document::write_head(StepId step) {
  Result<Statement> put =
      storage_->database.prepare("UPDATE meta SET value = ? WHERE key = 'head'");
  if (!put) return Error{put.error()};
  if (Status s = put.value().bind(step).run(); !s) return s;
  return set_meta(storage_->database, "head_seal", seal_of_head(std::to_string(step)));
}

// ---- Check that the log exists

Status Document::count_commit() {
  if (session_.empty() || !unsaved_.empty()) return Ok{};
  const std::string first = commits_ == 0 ? " after " + before_session_ : std::string();
  return set_meta(storage_->database, kCommit,
                  session_ + " " + std::to_string(commits_ + 1) + first);
}

Status Document::mark(bool writing) {
  may_go_to_memory_ = may_go_to_memory_ && writing;
  if (writing) {
    const Result<std::string> last = meta(storage_->database, kCommit);
    if (!last) return Error{last.error()};
    const std::string before = last.value().substr(0, last.value().find(" after "));
    before_session_ = before.empty() ? "-" : before;
    std::random_device random;
    session_ = hash_text(uint64_t{random()} << 32 | random());
    commits_ = 0;
  }
  Status marked = commit(writing ? "beginning to write" : "closing", [&]() -> Status {
    if (writing) return set_meta(storage_->database, "writing", "its log is beside it");
    return storage_->database.run("DELETE FROM meta WHERE key = 'writing'");
  });
  if (!marked) return marked;
  marked_ = writing;
  return storage_->database.run("PRAGMA wal_checkpoint(TRUNCATE)");
}

Status Document::look_for_log(bool there) {
  const Result<std::string> marked = meta(storage_->database, "writing");
  if (!marked) return wrong("is a damaged document (" + marked.error() + ")");
  // This must be reported before the next writer starts a new log.
  if (!there && !marked.value().empty())
    missing_ = name() +
               ": its last steps may be missing: the program that wrote it did not close it, and "
               "its -wal file is not next to it; find that file and put it there before you open "
               "the document for writing";
  return Ok{};
}

}  // namespace kibori
