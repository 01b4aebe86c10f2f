// SPDX-License-Identifier: MIT
// Writes MCAP files (https://mcap.dev/spec): messages of several channels in chunks, with an index.
// This code exists because Debian does not package the MCAP library.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/result.h>

namespace kibori {

class McapWriter {
 public:
  // `program`: name of the program that writes the file.
  McapWriter(const std::filesystem::path& path, const std::string& program);

  // Adds a channel and returns its number; the first is 1. Its messages are JSON. They must match
  // `json_schema`, which is a JSON Schema.
  uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                       const std::string& json_schema);
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& entries);
  // Call it in order of time, across all channels.
  void write(uint16_t channel, uint64_t time_ns, const std::string& message);
  // Writes the index and moves the file into place. Errors: the file cannot be written. Then a file
  // that existed at `path` before is unchanged.
  Status commit();

 private:
  using Record = std::string;
  struct Channel {
    Record schema, channel;
    uint64_t messages = 0;
    Record index;            // times and offsets of its messages in the current chunk
    bool announced = false;  // true if the current chunk contains its schema and channel
  };
  struct Chunk {
    uint64_t first_ns, last_ns, at, bytes, index_bytes, size;
    std::map<uint16_t, uint64_t> indices;
  };

  void put(uint8_t kind, const Record& content);
  void end_chunk();

  NewFile file_;
  std::vector<Channel> channels_;
  Record chunk_;
  uint64_t chunk_first_ = 0, chunk_last_ = 0, first_ns_ = 0, last_ns_ = 0;
  uint64_t messages_ = 0;
  uint32_t metadata_ = 0;
  std::vector<Record> metadata_indices_;
  std::vector<Chunk> chunks_;
};

}  // namespace kibori
