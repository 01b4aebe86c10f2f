// SPDX-License-Identifier: MIT
// SQLite with errors as values: as much of it as a document needs. Internal to `document`.
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

// A prepared statement: bind in order, step through rows, read columns in order. Reset by its first
// bind after a step.
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
  // The next row: true; no more: false, and the statement is ready for the next bindings.
  Result<bool> row();
  // For statements without rows.
  Status run();
  // Calls f() at every row; what it says ends it.
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
  int next();  // the place of the next binding
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

class Database {
 public:
  enum class Access { create, write, read };
  // `vfs`: of a registered SQLite file system, for tests. Errors name the file.
  static Result<Database> open(const std::filesystem::path& path, Access access,
                               const char* vfs = nullptr);

  // A database in memory with all that another one holds.
  static Result<Database> in_memory(const Database& from);
  // Makes all of this one as `from` is, or leaves it as it was.
  Status become(const Database& from);

  // One or several statements without results.
  Status run(const char* sql);
  Result<Statement> prepare(const char* sql);
  int64_t last_row() const;
  // The log stays where it is when this is the last to close it.
  void keep_log();
  // Whether the file was opened for reading only, as it can't be written.
  bool read_only() const;
  // Whether what failed last failed for the disk: full, gone, not to be written.
  bool disk_failed() const;
  // The last error, as a sentence that names the file.
  Error error(const std::string& doing) const;
  const std::string& name() const { return name_; }

 private:
  bool connect(const std::string& name, int flags, const char* vfs);
  struct Close {
    void operator()(sqlite3* db) const;
  };
  // In which the file is that is read; none: where it belongs.
  std::shared_ptr<TemporaryFolder> copied_;
  std::unique_ptr<sqlite3, Close> db_;
  std::string name_;
};

}  // namespace kibori
