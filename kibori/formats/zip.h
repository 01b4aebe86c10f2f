// SPDX-License-Identifier: MIT
// ZIP archives, as far as 3MF needs them: stored and deflated entries, no encryption, under 4 GB.
// Internal to `formats`.
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

class ZipWriter {
 public:
  explicit ZipWriter(NewFile& file);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  // One entry after the other: begin, write as often as need be, end.
  void begin(const std::string& name);
  void write(std::string_view data);
  void end();
  // The directory. Error: more than 4 GB.
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

// Reads an archive that may be hostile: nothing is believed before it is checked against the bytes
// there are.
class ZipReader {
 public:
  // `bytes` must outlive the reader. Errors: no archive, cut short, entry names that leave the
  // archive's folder, encrypted or oversized entries.
  static Result<ZipReader> open(std::span<const char> bytes);

  bool has(const std::string& name) const { return find(name) != nullptr; }
  // Sends the entry's content piece by piece; `f` returns false to stop. Errors: no such entry,
  // damaged content, more of it than promised, or so much more than its packed size that it is no
  // honest file.
  Status read(const std::string& name, const std::function<bool(std::string_view)>& f) const;

 private:
  struct Entry {
    std::string name;
    uint16_t method;
    uint32_t crc;
    uint64_t packed, whole;
    size_t at;  // of the packed bytes
  };
  const Entry* find(const std::string& name) const;

  std::span<const char> bytes_;
  std::vector<Entry> entries_;
};

}  // namespace kibori
