// SPDX-License-Identifier: MIT
// Opens documents for reading without changing any file.
//
//   state of the document             how it is read
//   a process writes it               by SQLite's protocol for readers, with its log
//   its last writer closed it         the same; SQLite removes the files that it creates
//   its last writer was killed        from a private copy of the document and its log
//
// SQLite copies any log that it finds next to a document into it, even the log of another document.
// So readers and writers first check whether the log belongs to the document (see LogOwner).
#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <vector>

#include <sys/stat.h>

#include <kibori/base/file.h>
#include <kibori/document/document.h>
#include <kibori/document/storage.h>

namespace kibori {
namespace {

namespace fs = std::filesystem;

// The file with this ending next to a document. If the document is a link, it is next to the
// target, as SQLite puts it.
fs::path with_suffix(const fs::path& path, const char* ending) {
  std::error_code none;
  const fs::path real = fs::is_symlink(path, none) ? fs::canonical(path, none) : path;
  return real.string() + ending;
}

bool has_content(const fs::path& path) {
  std::error_code none;
  const auto size = fs::file_size(path, none);
  return !none && size > 0;
}

// The state of a file. A write or a replacement of the file changes it.
struct Stamp {
  uint64_t file = 0;
  int64_t size = -1, time_s = 0, time_ns = 0;
  bool operator==(const Stamp&) const = default;
};
std::array<Stamp, 3> stamps(const fs::path& path) {
  std::array<Stamp, 3> all;
  const char* const endings[] = {"", "-wal", "-journal"};
  for (size_t i = 0; i < all.size(); i++)
    if (struct stat s = {}; ::stat(with_suffix(path, endings[i]).c_str(), &s) == 0)
      all[i] = {s.st_ino, s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
  return all;
}

uint32_t big_endian(const uint8_t* bytes) {
  return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 | bytes[3];
}

// Size of the file by its header (https://www.sqlite.org/fileformat2.html); 0 if the header does
// not state it.
struct Pages {
  uint64_t count = 0, size = 0;
};
Pages pages_of(const fs::path& path) {
  Result<Database> file = Database::open(path, Database::Access::frozen);
  std::array<uint8_t, 100> header{};
  if (!file || !file.value().read_bytes(0, header.data(), header.size())) return {};
  if (std::memcmp(header.data(), "SQLite format 3", 16) != 0) return {};
  if (std::memcmp(&header[24], &header[92], 4) != 0) return {};  // by an SQLite before 2010
  const uint64_t size = uint64_t{header[16]} << 8 | header[17];
  return {big_endian(&header[28]), size == 1 ? 65536 : size};
}

// Number of bytes of a write-ahead log up to the end of its first commit
// (https://www.sqlite.org/walformat.html); 0 if it has none. SQLite checks the content.
uint64_t first_commit_end(const fs::path& log) {
  constexpr uint64_t kHeader = 32, kFrameHeader = 24;
  std::ifstream file(log, std::ios::binary);
  std::array<uint8_t, kHeader> header{};
  file.read(reinterpret_cast<char*>(header.data()), kHeader);
  const uint64_t frame = kFrameHeader + big_endian(&header[8]);
  for (uint64_t at = kHeader; file; at += frame) {
    std::array<uint8_t, kFrameHeader> begin{};
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(begin.data()), kFrameHeader);
    if (!file || std::memcmp(&begin[8], &header[16], 8) != 0) return 0;
    if (big_endian(&begin[4]) != 0) return at + frame;
  }
  return 0;
}

// A commit as `meta` names it: "session number" or "session number after session number".
struct Commit {
  std::string text, session, before;
  int64_t number = 0;

  explicit Commit(std::string written) : text(std::move(written)) {
    const size_t end = text.find(' '), after = text.find(" after ");
    if (end == std::string::npos) return;
    session = text.substr(0, end);
    std::from_chars(text.data() + end + 1, text.data() + text.size(), number);
    if (after != std::string::npos) before = text.substr(after + 7);
  }
  std::string id() const { return session.empty() ? "-" : session + " " + std::to_string(number); }
};

// Decides if a log belongs to a document. `alone` is the last commit in the document's own file.
// `first` and `last` are the first and the last commit in the log. The log belongs to the document
// if `alone` is the commit before `first`, or one of the log's commits.
enum class LogOwner { own, foreign, unknown };
LogOwner owner_of_log(const Commit& alone, const Commit& first, const Commit& last) {
  // The log is of an older Kibori, which did not number its commits.
  if (first.text == alone.text || first.session.empty()) return LogOwner::unknown;
  if (!first.before.empty() && first.before == alone.id()) return LogOwner::own;
  const bool after_first = alone.session == first.session && alone.number >= first.number - 1;
  const bool before_last = alone.session == last.session && alone.number <= last.number;
  const bool own =
      first.session == last.session ? after_first && before_last : after_first || before_last;
  return own ? LogOwner::own : LogOwner::foreign;
}

// Copies the document without its log.
Status copy_document(const fs::path& from, const fs::path& to) {
  Result<Database> source = Database::open(from, Database::Access::frozen);
  if (!source) return Error{source.error()};
  std::error_code code;
  const uint64_t size = fs::file_size(from, code);
  if (code) return Error{code.message()};
  std::ofstream file(to, std::ios::binary);
  std::vector<char> block(size_t{1} << 20);
  for (uint64_t at = 0; at < size; at += block.size()) {
    block.resize(std::min<uint64_t>(block.size(), size - at));
    if (!source.value().read_bytes(at, block.data(), block.size()))
      return Error{"it can't be read"};
    file.write(block.data(), static_cast<std::streamsize>(block.size()));
  }
  file.close();
  return file ? Status(Ok{}) : Status(Error{"no space is left"});
}

struct Copy {
  std::shared_ptr<TemporaryFolder> folder;
  fs::path document;
};

Result<Copy> copy_of(const fs::path& path, bool may_be_held) {
  const std::string name = sanitize_message(path.string());
  for (int attempt = 0; attempt < 5; attempt++) {
    const auto before = stamps(path);
    const auto folder = TemporaryFolder::make();
    if (!folder) return Error{name + ": " + folder.error()};
    Copy copy{folder.value(), folder.value()->path() / "copy.kibori"};
    Status done = copy_document(path, copy.document);
    for (const char* const ending : {"-wal", "-journal"}) {
      const fs::path from = with_suffix(path, ending), to = with_suffix(copy.document, ending);
      std::error_code code;
      if (!done || !has_content(from)) continue;
      if (!fs::copy_file(from, to, code)) done = Error{code.message()};
      fs::permissions(to, fs::perms::owner_read | fs::perms::owner_write, fs::perm_options::add,
                      code);
    }
    if (!done)
      return Error{name +
                   ": it was not closed, so it must be read from a copy, but the copy cannot be "
                   "written to the temporary folder (" +
                   done.error() + "); set TMPDIR to a folder with free space"};
    if (stamps(path) == before && (may_be_held || !FileLock::held(path))) return copy;
  }
  return Error{name + ": another program is changing it; try again later"};
}

}  // namespace

std::string Document::missing_pages(const fs::path& path) {
  const Pages pages = pages_of(path);
  std::error_code none;
  const uint64_t bytes = fs::file_size(path, none);
  if (none || pages.size == 0 || pages.count * pages.size <= bytes) return {};
  const uint64_t there = bytes / pages.size;
  return std::to_string(pages.count - there) + " of its " + std::to_string(pages.count) +
         " pages are missing at its end";
}

std::string Document::meta_of(Database& database, const char* key) {
  Document document(std::make_unique<DocumentStorage>());
  document.storage_->database = std::move(database);
  std::string value;
  if (document.check_kind()) {
    Result<Statement> read =
        document.storage_->database.prepare("SELECT value FROM meta WHERE key = ?");
    if (read)
      if (const Result<bool> row = read.value().bind(std::string_view(key)).row();
          row && row.value())
        value = read.value().text(0);
  }
  database = std::move(document.storage_->database);
  return value;
}

bool Document::is_complete(Database& database) {
  Document document(std::make_unique<DocumentStorage>());
  document.storage_->database = std::move(database);
  const bool good = [&] {
    if (!document.check_kind() && !document.is_newer()) return false;
    Result<Statement> check = document.storage_->database.prepare("PRAGMA quick_check(1)");
    if (!check) return false;
    const Result<bool> row = check.value().row();
    if (!row || !row.value() || check.value().text(0) != "ok") return false;
    return document.is_newer() || (document.read_tree().ok() && document.damage_.empty());
  }();
  database = std::move(document.storage_->database);
  return good;
}

Result<Database> Document::open_copy(const fs::path& path, bool may_be_held) {
  const std::string name = sanitize_message(path.string());
  const Result<Copy> copied = copy_of(path, may_be_held);
  if (!copied) return Error{copied.error()};
  const fs::path& copy = copied.value().document;
  const fs::path log = with_suffix(copy, "-wal"), all = with_suffix(copy, "-all");
  const bool logged = has_content(log), journaled = has_content(with_suffix(copy, "-journal"));
  // SQLite refuses to read a file with missing pages. With zeros in their place, it reads the rest.
  if (const Pages pages = pages_of(copy); pages.count > 0) {
    std::error_code none;
    if (pages.count * pages.size > fs::file_size(copy, none))
      fs::resize_file(copy, pages.count * pages.size, none);
  }
  LogOwner owner = logged || journaled ? LogOwner::unknown : LogOwner::own;
  Result<Database> alone = Database::open(copy, Database::Access::frozen);
  if (!alone) return Error{name + ": cannot be opened"};
  Commit first{""};
  if (logged) {
    std::error_code code;
    fs::rename(log, all, code);
    fs::copy_file(all, log, code);
    fs::resize_file(log, first_commit_end(all), code);
    if (code) return Error{name + ": cannot be copied (" + code.message() + ")"};
    if (Result<Database> begun = Database::open(copy, Database::Access::read)) {
      begun.value().keep_log();
      first = Commit(meta_of(begun.value(), "commit"));
    }
    fs::remove(with_suffix(copy, "-shm"), code);
    fs::rename(all, log, code);
  }
  const Commit before(meta_of(alone.value(), "commit"));
  // If there is a journal, SQLite changes the copy when it opens it. So the copy is checked before
  // that.
  bool alone_complete = journaled && is_complete(alone.value());
  Result<Database> whole = Database::open(copy, Database::Access::read);
  if (!whole) return Error{name + ": cannot be opened"};
  whole.value().stands_for(name, copied.value().folder);
  if (logged) owner = owner_of_log(before, first, Commit(meta_of(whole.value(), "commit")));
  if (owner != LogOwner::own && !journaled) alone_complete = is_complete(alone.value());
  // Without commit numbers to compare, the log belongs to the document if both together are a
  // complete document. It also does if the document alone is not complete.
  if (owner == LogOwner::unknown)
    owner = !alone_complete || is_complete(whole.value()) ? LogOwner::own : LogOwner::foreign;
  else if (owner == LogOwner::foreign && !alone_complete && is_complete(whole.value()))
    owner = LogOwner::own;
  if (owner == LogOwner::own) return whole;
  const std::string other =
      sanitize_message(with_suffix(path, logged ? "-wal" : "-journal").string());
  return Error{name + ": " + other +
               " next to it belongs to another document or to another state of this one, and would "
               "damage it; nothing was changed; move " +
               other + " to another folder, or put the document back that it belongs to"};
}

Result<std::string> Document::check_logs(const fs::path& path) {
  std::string missing = missing_pages(path);
  if (!has_content(with_suffix(path, "-wal")) && !has_content(with_suffix(path, "-journal")))
    return missing;
  Result<Database> own = open_copy(path, true);
  if (!own) return Error{own.error()};
  if (!missing.empty() && is_complete(own.value())) missing.clear();
  return missing;
}

Result<std::unique_ptr<Document>> Document::attach_reader(const fs::path& path, const char* vfs) {
  const bool held = FileLock::held(path);
  std::string cut = held ? std::string() : missing_pages(path);
  const auto was_left = [&] {
    if (held) return false;
    if (!cut.empty() || has_content(with_suffix(path, "-wal")) ||
        has_content(with_suffix(path, "-journal")))
      return true;
    Result<Database> alone = Database::open(path, Database::Access::frozen, vfs);
    return alone && !meta_of(alone.value(), "writing").empty();
  };
  const bool left = was_left();
  Result<Database> database =
      left ? open_copy(path, false) : Database::open(path, Database::Access::read, vfs);
  // The folder is read-only for this process, but another process writes the document.
  if (!left && held && database && database.value().disk_failed()) database = open_copy(path, true);
  if (!database) return Error{database.error()};
  // A log may hold the missing pages.
  if (!cut.empty() && is_complete(database.value())) cut.clear();
  std::unique_ptr<Document> document(new Document(std::make_unique<DocumentStorage>()));
  document->storage_->database = std::move(database).value();
  std::error_code none;
  document->storage_->log = with_suffix(fs::absolute(path, none), "-wal");
  // SQLite fixes the state that it reads at the first query. Later writes do not change it.
  static_cast<void>(document->storage_->database.run("BEGIN"));
  if (!cut.empty()) document->add_damage(0, cut);
  const auto refused = [&](const Status& fault) {
    return cut.empty() ? Error{fault.error()}
                       : document->wrong("is a damaged document: " + cut +
                                         ", and it cannot be read at all");
  };
  if (Status s = document->check_kind(); !s) return refused(s);
  if (Status s = document->look_for_log(held || fs::exists(document->storage_->log, none)); !s)
    return refused(s);
  return document;
}

}  // namespace kibori
