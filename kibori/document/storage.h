// SPDX-License-Identifier: MIT
// The files and connections of a Document. Internal to `document`.
#pragma once

#include <memory>

#include <kibori/document/database.h>
#include <kibori/document/file_lock.h>
#include <kibori/document/log_keeper.h>

namespace kibori {

// Members are destroyed from the last to the first. So the lock, which is the first, is released
// after the files are closed.
struct DocumentStorage {
  FileLock lock;
  // The file, or a copy in memory while the file is not writable.
  Database database;
  Database file;                      // the file, while `database` is in memory
  std::filesystem::path log;          // the -wal file next to the document
  std::unique_ptr<LogKeeper> keeper;  // null: the document is open for reading
};

}  // namespace kibori
