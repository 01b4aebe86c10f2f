// SPDX-License-Identifier: MIT
// ZIP archives as 3MF needs them: stored and deflated entries, no encryption. Archives above 4 GB,
// and archives with 64-bit sizes, can be read but not written. Internal to `formats`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/result.h>

struct z_stream_s;

namespace kibori {

// Writes an archive to a file, entry by entry.
class ZipWriter {
 public:
  explicit ZipWriter(NewFile& file);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  // For each entry, call begin(), then write() any number of times, then end().
  void begin(const std::string& name);
  void write(std::string_view data);
  void end();
  // Writes the directory. Errors: the archive or an entry has more than 4 GB.
  Status finish();

 private:
  struct Entry {
    std::string name;
    uint32_t crc;
    uint64_t packed, whole, at;
  };
  void deflate_some(std::string_view data, int flush);

  NewFile& file_;
  std::unique_ptr<z_stream_s> stream_;
  std::vector<Entry> entries_;
};

// Reads an archive, which may be malicious. Every offset and every size is checked against the
// available bytes before use.
class ZipReader {
 public:
  // `bytes` must outlive the reader. Errors: this is not an archive; it is truncated; it has too
  // many entries; the name of an entry leads out of the archive's folder; an entry is encrypted; an
  // entry has a compression ratio that no real file has.
  static Result<ZipReader> open(std::span<const char> bytes);

  bool has(const std::string& name) const { return find(name) != nullptr; }
  // Passes the content of an entry to `f`, piece by piece. `f` returns false to stop. Errors: there
  // is no such entry; its compression method is not supported; its content is damaged; its size is
  // not the declared one.
  Status read(const std::string& name, const std::function<bool(std::string_view)>& f) const;

 private:
  struct Entry {
    std::string name;
    uint16_t method;
    uint32_t crc;
    uint64_t packed, whole;
    size_t at;  // offset of the packed bytes in bytes_
  };
  const Entry* find(const std::string& name) const;

  std::span<const char> bytes_;
  std::vector<Entry> entries_;
};

}  // namespace kibori
