// SPDX-License-Identifier: MIT
// Writes MCAP files (https://mcap.dev/spec). A file has messages of several channels in chunks, and
// an index. Debian does not package the MCAP library, so this code replaces it.
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
  // Starts a file. `program` is the name of the program that writes it.
  McapWriter(const std::filesystem::path& path, const std::string& program);

  // Adds a channel for JSON messages and returns its number. The first channel has the number 1.
  // `json_schema` is a JSON Schema that the messages must match.
  uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                       const std::string& json_schema);
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& entries);
  // Adds a message. Calls must be in the order of `time_ns`, across all channels.
  void write(uint16_t channel, uint64_t time_ns, const std::string& message);
  // Writes the index and moves the file to `path`. Errors: the file cannot be written. Then a file
  // that existed at `path` before is unchanged.
  Status commit();

 private:
  using Record = std::string;
  struct Channel {
    Record schema, channel;
    uint64_t messages = 0;
    Record index;            // times and offsets of the channel's messages in the current chunk
    bool announced = false;  // true if the current chunk contains the channel and its schema
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
