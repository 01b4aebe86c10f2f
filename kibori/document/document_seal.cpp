// SPDX-License-Identifier: MIT
// What tells that a row was changed or is missing. Each finished step has a seal, a hash over its
// row and the seal of the one before it; `meta` has the number of them, a hash over all in their
// order, and one over the versions. And where a document is being written, `meta` says so in the
// file itself: if the log beside it is lost, with the last steps in it, that is told.
#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

namespace kibori {
namespace {

void add(Hash& hash, std::string_view text) {
  hash.add(reinterpret_cast<const uint8_t*>(text.data()), text.size());
}

// How the lattice, the stock and what it came from begin the chain of steps.
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

// Of a step's row as it stands there, the bodies it left if they are others, and the seal of the
// one before it.
Result<uint64_t> seal_of_step(Database& database, StepId step, bool has_bodies) {
  Result<Statement> read = database.prepare(
      "SELECT parent, kind, label, json, start, ticks, removed_mm3, hash, made_at, (SELECT value "
      "FROM seal "
      "WHERE seal.step = parent) FROM step LEFT JOIN setting ON setting.id = setting WHERE step.id "
      "= ?");
  if (!read) return Error{read.error()};
  Statement& row = read.value();
  const Result<bool> there = row.bind(step).row();
  if (!there) return Error{there.error()};
  if (!there.value()) return Error{"step " + std::to_string(step) + " is missing"};
  Hash hash;
  hash.add(static_cast<uint64_t>(step));
  hash.add(static_cast<uint64_t>(row.integer(0)));
  for (const int column : {1, 2, 3}) add(hash, row.text(column));
  const Bytes start = row.bytes(4);
  hash.add(start.data(), start.size());
  hash.add(static_cast<uint64_t>(row.integer(5)));
  hash.add(row.real(6));
  for (const int column : {7, 8, 9}) add(hash, row.text(column));
  if (!has_bodies) return hash.value();
  Result<Statement> bodies = database.prepare("SELECT json FROM bodies WHERE step = ?");
  if (!bodies) return Error{bodies.error()};
  const Result<bool> others = bodies.value().bind(step).row();
  if (!others) return Error{others.error()};
  if (others.value()) add(hash, bodies.value().text(0));
  return hash.value();
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
  const Result<std::string> before = meta(storage_->database, "seal"),
                            count = meta(storage_->database, "sealed_steps");
  if (!before || !count) return Error{before ? count.error() : before.error()};
  Result<uint64_t> chain = std::strtoull(before.value().c_str(), nullptr, 16);
  if (before.value().empty()) chain = seal_of_stock(storage_->database);
  if (!chain) return Error{chain.error()};
  const Result<uint64_t> sealed = seal_of_step(storage_->database, step, version_ >= 9);
  if (!sealed) return Error{sealed.error()};
  Result<Statement> put = storage_->database.prepare("INSERT OR REPLACE INTO seal VALUES (?, ?)");
  if (!put) return Error{put.error()};
  if (Status s = put.value().bind(step).bind(hash_text(sealed.value())).run(); !s) return s;
  if (Status s =
          set_meta(storage_->database, "seal", hash_text(chained(chain.value(), sealed.value())));
      !s)
    return s;
  return set_meta(storage_->database, "sealed_steps",
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

Status Document::verify_seals(const std::function<void(const std::string&)>& wrong_at) const {
  if (version_ < 5) return Ok{};
  auto& database = storage_->database;
  Result<uint64_t> chain = seal_of_stock(database);
  if (!chain) return Error{chain.error()};
  Result<Statement> read = database.prepare(
      "SELECT step.id, seal.value FROM step LEFT JOIN seal ON seal.step = step.id WHERE finished = "
      "1 ORDER "
      "BY "
      "step.id");
  if (!read) return Error{read.error()};
  int64_t count = 0;
  bool rows_hold = true;
  Status done = read.value().for_rows([&]() -> Status {
    const StepId step = read.value().integer(0);
    const Result<uint64_t> sealed = seal_of_step(database, step, version_ >= 9);
    if (!sealed) return Error{sealed.error()};
    if (hash_text(sealed.value()) != read.value().text(1)) {
      rows_hold = false;
      wrong_at(
          "step " + std::to_string(step) +
          ": its label, time, settings, figures or the step before it are not what was written");
    }
    chain = chained(chain.value(), sealed.value());
    count++;
    return Ok{};
  });
  if (!done) return done;
  const Result<std::string> sealed = meta(database, "sealed_steps"), last = meta(database, "seal"),
                            versions = meta(database, "version_seal"),
                            now = seal_of_versions(database);
  if (!sealed || !last || !versions || !now) return Error{"the seals can't be read"};
  const long long written = std::strtoll(sealed.value().c_str(), nullptr, 10);
  if (count != written)
    wrong_at("it has " + std::to_string(count) + " finished steps of " + std::to_string(written));
  else if (rows_hold && last.value() != hash_text(chain.value()))
    wrong_at("the lattice, the stock or the order of the steps is not what was written");
  if (versions.value() != now.value()) wrong_at("the versions are not those that were named");
  return Ok{};
}

// ---- Whether the log is there

Status Document::mark(bool writing) {
  may_go_to_memory_ = may_go_to_memory_ && writing;
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
  if (marked.value().empty()) return Ok{};
  // Whoever writes it next puts the log away.
  if (there && !writes_) storage_->database.keep_log();
  if (!there)
    missing_ =
        name() +
        ": its last steps may be missing: what wrote it did not close it, and its -wal file is not "
        "beside it; look for that and put it there before the document is opened for writing";
  return Ok{};
}

}  // namespace kibori
