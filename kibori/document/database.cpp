// SPDX-License-Identifier: MIT
#include <kibori/document/database.h>

#include <cstdio>

#include <sqlite3.h>

namespace kibori {

Statement::~Statement() { sqlite3_finalize(statement_); }

namespace {

// Maximum size of any value in a document.
constexpr size_t kMaxValueBytes = size_t{1} << 30;

}  // namespace

int Statement::next() {
  if (bound_ == 0) sqlite3_reset(statement_);
  return ++bound_;
}

Statement& Statement::bind(int64_t value) {
  if (const int code = sqlite3_bind_int64(statement_, next(), value); !failed_) failed_ = code;
  return *this;
}
Statement& Statement::bind(double value) {
  if (const int code = sqlite3_bind_double(statement_, next(), value); !failed_) failed_ = code;
  return *this;
}
Statement& Statement::bind(std::string_view text) {
  const int code = sqlite3_bind_text64(statement_, next(), text.data(), text.size(),
                                       SQLITE_TRANSIENT, SQLITE_UTF8);
  if (!failed_) failed_ = code;
  return *this;
}
Statement& Statement::bind(const Bytes& bytes) {
  const int code = bytes.empty() ? sqlite3_bind_zeroblob(statement_, next(), 0)
                                 : sqlite3_bind_blob64(statement_, next(), bytes.data(),
                                                       bytes.size(), SQLITE_TRANSIENT);
  if (!failed_) failed_ = code;
  return *this;
}
Statement& Statement::bind_null() {
  if (const int code = sqlite3_bind_null(statement_, next()); !failed_) failed_ = code;
  return *this;
}

Result<bool> Statement::row() {
  if (!failed_) {
    const int code = sqlite3_step(statement_);
    bound_ = 0;
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) {
      sqlite3_reset(statement_);
      return false;
    }
  }
  // The message may quote the content of the file, which is not trusted.
  const std::string message = sanitize_message(sqlite3_errmsg(db_));
  sqlite3_reset(statement_);
  failed_ = bound_ = 0;
  return Error{message};
}

Status Statement::run() {
  const Result<bool> done = row();
  if (!done) return Error{done.error()};
  return Ok{};
}

int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }
bool Statement::null(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}
std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return text ? std::string(text, static_cast<size_t>(sqlite3_column_bytes(statement_, column)))
              : std::string();
}
Bytes Statement::bytes(int column) const {
  const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column));
  const auto size = static_cast<size_t>(sqlite3_column_bytes(statement_, column));
  return data && size <= kMaxValueBytes ? Bytes(data, data + size) : Bytes();
}

void Database::Close::operator()(sqlite3* db) const { sqlite3_close_v2(db); }

Result<Database> Database::open(const std::filesystem::path& path, Access access, const char* vfs) {
  Database database;
  database.name_ = sanitize_message(path.string());
  // Readers also open the file for writing. Otherwise, if a reader is the last to close it, it
  // could not remove the files that SQLite has created next to it. If the file is not writable,
  // SQLite opens it for reading.
  const int flags = SQLITE_OPEN_READWRITE | (access == Access::create ? SQLITE_OPEN_CREATE : 0);
  // SQLite treats a name that begins with "file:" as a URI.
  std::error_code none;
  const bool memory = path == ":memory:";
  const std::filesystem::path file = memory ? path : std::filesystem::absolute(path, none);
  if (access != Access::frozen) {
    if (!database.connect(file.string(), flags, vfs)) return database.error("cannot be opened");
    if (access != Access::read) return database;
    if (const Status s = database.run("SELECT 1 FROM sqlite_master; PRAGMA query_only = 1"); s)
      return database;
    // The query fails if no file can be created next to the database: the folder is read-only, or
    // the disk is full. Then no process writes there, and the database can be read as frozen. If
    // there is a log, the caller reads a copy instead.
    const std::filesystem::path log = file.string() + "-wal";
    if (!database.disk_failed() ||
        (std::filesystem::exists(log, none) && std::filesystem::file_size(log, none) > 0))
      return database;
  }
  std::string uri = "file:";
  for (const char c : file.string()) {
    char escaped[4] = {c, 0};
    if (c == '%' || c == '?' || c == '#') std::snprintf(escaped, sizeof escaped, "%%%02X", c);
    uri += escaped;
  }
  if (!database.connect(uri + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, vfs))
    return database.error("cannot be opened");
  return database;
}

bool Database::connect(const std::string& name, int flags, const char* vfs) {
  sqlite3* db = nullptr;
  const int code =
      sqlite3_open_v2(name.c_str(), &db, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, vfs);
  db_.reset(db);
  if (code != SQLITE_OK) return false;
  sqlite3_busy_timeout(db, 5000);
  // The file may be malicious.
  sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_limit(db, SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxValueBytes));
  return true;
}

Result<Database> Database::in_memory(const Database& from) {
  Result<Database> memory = open(":memory:", Access::create);
  if (!memory) return memory;
  memory.value().name_ = from.name_;
  if (const Status s = memory.value().become(from); !s) return Error{s.error()};
  if (const Status s = memory.value().run("PRAGMA foreign_keys = ON"); !s) return Error{s.error()};
  return memory;
}

Status Database::become(const Database& from) {
  sqlite3_backup* backup = sqlite3_backup_init(db_.get(), "main", from.db_.get(), "main");
  if (backup) sqlite3_backup_step(backup, -1);
  if (sqlite3_backup_finish(backup) == SQLITE_OK && backup) return Ok{};
  return Error{sanitize_message(sqlite3_errmsg(db_.get()))};
}

Status Database::run(const char* sql) {
  if (sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr) == SQLITE_OK) return Ok{};
  return Error{sanitize_message(sqlite3_errmsg(db_.get()))};
}

Result<Statement> Database::prepare(const char* sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(db_.get(), sql, -1, &statement, nullptr) != SQLITE_OK)
    return Error{sanitize_message(sqlite3_errmsg(db_.get()))};
  return Statement(db_.get(), statement);
}

bool Database::read_only() const { return sqlite3_db_readonly(db_.get(), "main") == 1; }

bool Database::read_bytes(uint64_t at, void* bytes, size_t count) {
  sqlite3_file* file = nullptr;
  return sqlite3_file_control(db_.get(), "main", SQLITE_FCNTL_FILE_POINTER, &file) == SQLITE_OK &&
         file && file->pMethods &&
         file->pMethods->xRead(file, bytes, static_cast<int>(count),
                               static_cast<sqlite3_int64>(at)) == SQLITE_OK;
}

void Database::keep_log() {
  sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
}

bool Database::disk_failed() const {
  switch (sqlite3_errcode(db_.get()) & 0xff) {
    case SQLITE_IOERR:
    case SQLITE_FULL:
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return true;
    default:
      return false;
  }
}
bool Database::is_malformed() const {
  const int code = sqlite3_errcode(db_.get()) & 0xff;
  return code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
}
int64_t Database::last_row() const { return sqlite3_last_insert_rowid(db_.get()); }

Error Database::error(const std::string& doing) const {
  return Error{name_ + ": " + doing + " (" +
               sanitize_message(db_ ? sqlite3_errmsg(db_.get()) : "out of memory") + ")"};
}

}  // namespace kibori
