// SPDX-License-Identifier: MIT
// SQLite with errors as values, reduced to what a document needs. Internal to `document`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/file.h>
#include <kibori/base/result.h>

struct sqlite3;
struct sqlite3_stmt;

namespace kibori {

// A prepared statement. Bind in order, step through rows, read columns in order. The first bind
// after a step resets it.
class Statement {
 public:
  Statement() = default;
  Statement(sqlite3* db, sqlite3_stmt* statement) : db_(db), statement_(statement) {}
  ~Statement();
  Statement(Statement&& other) noexcept { swap(other); }
  Statement& operator=(Statement&& other) noexcept {
    swap(other);
    return *this;
  }

  Statement& bind(int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view text);
  Statement& bind(const Bytes& bytes);
  Statement& bind_null();
  // Steps to the next row and returns true. Returns false if there is none; then the statement is
  // ready for new bindings.
  Result<bool> row();
  // For statements without rows.
  Status run();
  // Calls f() for every row. An error of f ends the loop and is returned.
  template <class F>
  Status for_rows(F&& f) {
    for (;;) {
      const Result<bool> there = row();
      if (!there) return Error{there.error()};
      if (!there.value()) return Ok{};
      if (Status s = f(); !s) return s;
    }
  }

  int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;
  Bytes bytes(int column) const;
  bool null(int column) const;

 private:
  int next();  // the index of the next binding
  void swap(Statement& other) noexcept {
    std::swap(db_, other.db_);
    std::swap(statement_, other.statement_);
    std::swap(bound_, other.bound_);
    std::swap(failed_, other.failed_);
  }
  sqlite3* db_ = nullptr;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  int failed_ = 0;  // the first error of a bind
};

// A connection to a database file, or a database in memory. For one thread.
class Database {
 public:
  // `frozen`: for reading a file that does not change. Its log is ignored, and SQLite creates no
  // files next to it.
  enum class Access { create, write, read, frozen };
  // `vfs` names a registered SQLite file system, for tests. Errors name the file.
  static Result<Database> open(const std::filesystem::path& path, Access access,
                               const char* vfs = nullptr);

  // A database in memory with a copy of another one's contents.
  static Result<Database> in_memory(const Database& from);
  // Replaces the contents by those of `from`, or leaves them unchanged on failure.
  Status become(const Database& from);

  // Runs one or several statements without results.
  Status run(const char* sql);
  Result<Statement> prepare(const char* sql);
  int64_t last_row() const;
  // For a connection to a copy: errors name the original, and the copy's folder is removed with the
  // connection.
  void stands_for(const std::string& name, std::shared_ptr<TemporaryFolder> folder) {
    name_ = name;
    copied_ = std::move(folder);
  }
  // Reads bytes of the file as they are stored. It uses SQLite's descriptor: if this process opened
  // the file again, closing that descriptor would drop SQLite's locks. Returns false if the file is
  // shorter, or on failure.
  bool read_bytes(uint64_t at, void* bytes, size_t count);
  // Keeps the log file when this connection is the last to close it.
  void keep_log();
  // True if the file was opened for reading only, because it is not writable.
  bool read_only() const;
  // True if the last failure was caused by the disk: full, missing, or not writable.
  bool disk_failed() const;
  // True if the last failure was caused by the file's content.
  bool is_malformed() const;
  // The last error, as a sentence that names the file.
  Error error(const std::string& doing) const;
  const std::string& name() const { return name_; }

 private:
  bool connect(const std::string& name, int flags, const char* vfs);
  struct Close {
    void operator()(sqlite3* db) const;
  };
  // The folder of the copy that is read; null: the original file is read.
  std::shared_ptr<TemporaryFolder> copied_;
  std::unique_ptr<sqlite3, Close> db_;
  std::string name_;
};

}  // namespace kibori
