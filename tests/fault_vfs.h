// SPDX-License-Identifier: MIT
// A SQLite file system, on top of the machine's own, that fails on request. It records every write
// and sync, so that tests can simulate a loss of power.
#pragma once

#include <atomic>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <sqlite3.h>

namespace kibori::test {

class FaultVfs {
 public:
  static constexpr const char* kName = "kibori-fault";

  struct Op {
    enum Kind { write, truncate, sync, remove } kind;
    std::string file;
    int64_t at = 0;  // truncate: the length
    std::vector<char> data;
  };

  // Operations that change a file are counted from 1. `fail_at` is the first one that fails (0:
  // none). If `fail_on` is set, later ones also fail. `error` is the code of a failed write.
  std::atomic<int64_t> fail_at = 0;
  std::atomic<bool> fail_on = false;
  std::atomic<int> error = SQLITE_IOERR_WRITE;
  std::atomic<bool> half_written = false;  // the failing write writes its first half
  std::atomic<int64_t> count = 0;
  std::atomic<bool> log = false;
  std::vector<Op> ops;

  static FaultVfs& get() {
    static FaultVfs vfs;
    return vfs;
  }
  void reset() {
    fail_at = 0;
    count = 0;
    fail_on = false;
    half_written = false;
    log = false;
    error = SQLITE_IOERR_WRITE;
    ops.clear();
  }

 private:
  struct File {
    sqlite3_file base;
    std::string* name;
    sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
  };

  FaultVfs() {
    real_ = sqlite3_vfs_find(nullptr);
    vfs_ = *real_;
    vfs_.zName = kName;
    vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
    vfs_.pNext = nullptr;
    vfs_.xOpen = [](sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
      auto* f = reinterpret_cast<File*>(file);
      f->base.pMethods = nullptr;
      const int code = get().real_->xOpen(get().real_, name, f->real(), flags, out);
      if (code != SQLITE_OK) return code;
      f->name = new std::string(name ? std::filesystem::path(name).filename().string() : "");
      f->base.pMethods = &get().methods_;
      return SQLITE_OK;
    };
    vfs_.xDelete = [](sqlite3_vfs*, const char* name, int sync) {
      const std::lock_guard lock(get().mutex_);
      if (get().fails()) return SQLITE_IOERR_DELETE;
      get().note({Op::remove, std::filesystem::path(name).filename().string(), 0, {}});
      return get().real_->xDelete(get().real_, name, sync);
    };
    methods_.iVersion = 2;
    methods_.xClose = [](sqlite3_file* f) {
      delete of(f)->name;
      return real(f)->pMethods->xClose(real(f));
    };
    methods_.xRead = [](sqlite3_file* f, void* to, int n, sqlite3_int64 at) {
      return real(f)->pMethods->xRead(real(f), to, n, at);
    };
    methods_.xWrite = [](sqlite3_file* f, const void* from, int n, sqlite3_int64 at) {
      const std::lock_guard lock(get().mutex_);
      if (get().fails()) {
        if (get().half_written) real(f)->pMethods->xWrite(real(f), from, n / 2, at);
        return get().error.load();
      }
      const auto* bytes = static_cast<const char*>(from);
      get().note({Op::write, *of(f)->name, at, std::vector<char>(bytes, bytes + n)});
      return real(f)->pMethods->xWrite(real(f), from, n, at);
    };
    methods_.xTruncate = [](sqlite3_file* f, sqlite3_int64 size) {
      const std::lock_guard lock(get().mutex_);
      if (get().fails()) return SQLITE_IOERR_TRUNCATE;
      get().note({Op::truncate, *of(f)->name, size, {}});
      return real(f)->pMethods->xTruncate(real(f), size);
    };
    methods_.xSync = [](sqlite3_file* f, int) {
      const std::lock_guard lock(get().mutex_);
      if (get().fails()) return SQLITE_IOERR_FSYNC;
      get().note({Op::sync, *of(f)->name, 0, {}});
      return SQLITE_OK;  // the test needs no real sync, which would take time
    };
    methods_.xFileSize = [](sqlite3_file* f, sqlite3_int64* size) {
      return real(f)->pMethods->xFileSize(real(f), size);
    };
    methods_.xLock = [](sqlite3_file* f, int lock) {
      return real(f)->pMethods->xLock(real(f), lock);
    };
    methods_.xUnlock = [](sqlite3_file* f, int lock) {
      return real(f)->pMethods->xUnlock(real(f), lock);
    };
    methods_.xCheckReservedLock = [](sqlite3_file* f, int* out) {
      return real(f)->pMethods->xCheckReservedLock(real(f), out);
    };
    methods_.xFileControl = [](sqlite3_file* f, int op, void* arg) {
      return real(f)->pMethods->xFileControl(real(f), op, arg);
    };
    methods_.xSectorSize = [](sqlite3_file*) { return 512; };
    methods_.xDeviceCharacteristics = [](sqlite3_file*) { return 0; };
    methods_.xShmMap = [](sqlite3_file* f, int page, int size, int extend, void volatile** out) {
      return real(f)->pMethods->xShmMap(real(f), page, size, extend, out);
    };
    methods_.xShmLock = [](sqlite3_file* f, int at, int n, int flags) {
      return real(f)->pMethods->xShmLock(real(f), at, n, flags);
    };
    methods_.xShmBarrier = [](sqlite3_file* f) { real(f)->pMethods->xShmBarrier(real(f)); };
    methods_.xShmUnmap = [](sqlite3_file* f, int remove) {
      return real(f)->pMethods->xShmUnmap(real(f), remove);
    };
    sqlite3_vfs_register(&vfs_, 0);
  }

  static File* of(sqlite3_file* f) { return reinterpret_cast<File*>(f); }
  static sqlite3_file* real(sqlite3_file* f) { return of(f)->real(); }
  bool fails() {
    count++;
    return fail_at > 0 && (fail_on ? count >= fail_at : count == fail_at);
  }
  void note(Op op) {
    if (log) ops.push_back(std::move(op));
  }

  std::mutex mutex_;  // several threads of a document may write
  sqlite3_vfs* real_ = nullptr;
  sqlite3_vfs vfs_{};
  sqlite3_io_methods methods_{};
};

}  // namespace kibori::test
