// SPDX-License-Identifier: MIT
// The files and connections of a Document. Internal to `document`.
#pragma once

#include <memory>

#include <kibori/document/database.h>
#include <kibori/document/file_lock.h>
#include <kibori/document/log_keeper.h>

namespace kibori {

// Members are destroyed from the last to the first. So the files are closed before the lock, the
// first member, is released.
struct DocumentStorage {
  FileLock lock;
  // The file. While the file is not writable, this is a copy in memory.
  Database database;
  Database file;                      // the file, while `database` is a copy in memory
  std::filesystem::path log;          // path of the -wal file next to the document
  std::unique_ptr<LogKeeper> keeper;  // null if the document is open for reading
};

}  // namespace kibori
