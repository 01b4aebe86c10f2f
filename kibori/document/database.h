// SPDX-License-Identifier: MIT
// A wrapper of SQLite with errors as values. It has only what a document needs. Internal to
// `document`.
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

// A prepared statement. Bind the values in order, step through the rows, and read columns by their
// index. The first bind after the last row starts new bindings.
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
  // Steps to the next row and returns true. If there is no row, returns false. Then the statement
  // is ready for new bindings.
  Result<bool> row();
  // Runs a statement that has no rows.
  Status run();
  // Calls f() for every row. If f returns an error, stops and returns this error.
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
  int next();  // returns the index of the next binding
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

// A connection to a database file, or a database in memory. One thread may use it.
class Database {
 public:
  // `frozen` is for reading a file that does not change. It ignores the file's log, and SQLite
  // creates no files next to the file.
  enum class Access { create, write, read, frozen };
  // Opens a database. `vfs` is the name of a registered SQLite file system, for tests. Errors: the
  // file cannot be opened; the message names the file.
  static Result<Database> open(const std::filesystem::path& path, Access access,
                               const char* vfs = nullptr);

  // Makes a database in memory with the contents of `from`.
  static Result<Database> in_memory(const Database& from);
  // Replaces the contents by those of `from`. If this fails, the contents stay unchanged.
  Status become(const Database& from);

  // Runs one or several statements, and ignores their rows. Errors have only SQLite's reason.
  Status run(const char* sql);
  Result<Statement> prepare(const char* sql);
  int64_t last_row() const;
  // For a connection to a copy of a file: errors then contain `name`, the name of the original. The
  // copy's folder is removed when the connection is closed.
  void stands_for(const std::string& name, std::shared_ptr<TemporaryFolder> folder) {
    name_ = name;
    copied_ = std::move(folder);
  }
  // Reads bytes of the file as they are on the disk. Uses the file descriptor of SQLite. (If this
  // process opened and closed the file itself, SQLite would lose its locks.) Returns false if the
  // file is too short, or if reading fails.
  bool read_bytes(uint64_t at, void* bytes, size_t count);
  // Makes SQLite keep the log file, even if this connection is the last one to close it.
  void keep_log();
  // Returns true if SQLite opened the file for reading because the file is not writable.
  bool read_only() const;
  // Returns true if the disk caused the last failure: it is full, missing, or not writable.
  bool disk_failed() const;
  // Returns true if the content of the file caused the last failure.
  bool is_malformed() const;
  // Returns the last error as a sentence for the user. It names the file and `doing`.
  Error error(const std::string& doing) const;
  const std::string& name() const { return name_; }

 private:
  bool connect(const std::string& name, int flags, const char* vfs);
  struct Close {
    void operator()(sqlite3* db) const;
  };
  // Folder of the copy that this connection reads. Null: the connection reads the original file.
  std::shared_ptr<TemporaryFolder> copied_;
  std::unique_ptr<sqlite3, Close> db_;
  std::string name_;
};

}  // namespace kibori
