// SPDX-License-Identifier: MIT
// What a Document writes to. Internal to `document`.
#pragma once

#include <memory>

#include <kibori/document/database.h>
#include <kibori/document/file_lock.h>
#include <kibori/document/log_keeper.h>

namespace kibori {

// Members are destroyed from the last to the first: the lock is released after the files are
// closed.
struct DocumentStorage {
  FileLock lock;
  // The file, or all of it in memory while the file can't be written.
  Database database;
  Database file;                      // the file, while `database` is in memory
  std::unique_ptr<LogKeeper> keeper;  // null: the document is only read
};

}  // namespace kibori
