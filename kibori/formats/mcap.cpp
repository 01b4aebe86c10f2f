// SPDX-License-Identifier: MIT
#include <kibori/formats/mcap.h>

#include <algorithm>

#include <zlib.h>

namespace kibori {
namespace {

enum RecordKind : uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 0x0b,
  kMetadata = 0x0c,
  kMetadataIndex = 0x0d,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f
};

constexpr char kMcapMagic[] = {'\x89', 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr size_t kChunkBytes = 1 << 20;
constexpr uint64_t kHead = 9;  // bytes of a record before its content

// Appends a number in little-endian order.
template <class Number>
void add(std::string& to, Number number) {
  for (size_t i = 0; i < sizeof(Number); i++)
    to += static_cast<char>(static_cast<uint64_t>(number) >> (8 * i) & 0xff);
}
void add_text(std::string& to, const std::string& text) {
  add(to, static_cast<uint32_t>(text.size()));
  to += text;
}
void add_texts(std::string& to, const std::map<std::string, std::string>& texts) {
  std::string all;
  for (const auto& [key, value] : texts) {
    add_text(all, key);
    add_text(all, value);
  }
  add_text(to, all);
}
template <class Key>
void add_numbers(std::string& to, const std::map<Key, uint64_t>& numbers) {
  std::string all;
  for (const auto& [key, value] : numbers) {
    add(all, key);
    add(all, value);
  }
  add_text(to, all);
}
std::string record(uint8_t kind, const std::string& content) {
  std::string all(1, static_cast<char>(kind));
  add(all, uint64_t{content.size()});
  return all + content;
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, const std::string& program)
    : file_(path) {
  file_.write(kMcapMagic, sizeof kMcapMagic);
  std::string header;
  add_text(header, "");
  add_text(header, program);
  put(kHeader, header);
}

void McapWriter::put(uint8_t kind, const Record& content) { file_.write(record(kind, content)); }

uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                 const std::string& json_schema) {
  const auto id = static_cast<uint16_t>(channels_.size() + 1);
  Channel made;
  add(made.schema, id);
  add_text(made.schema, schema_name);
  add_text(made.schema, "jsonschema");
  add_text(made.schema, json_schema);
  add(made.channel, id);
  add(made.channel, id);
  add_text(made.channel, topic);
  add_text(made.channel, "json");
  add_texts(made.channel, {});
  channels_.push_back(std::move(made));
  return id;
}

void McapWriter::add_metadata(const std::string& name,
                              const std::map<std::string, std::string>& entries) {
  end_chunk();
  std::string content;
  add_text(content, name);
  add_texts(content, entries);
  std::string index;
  add(index, file_.size());
  add(index, content.size() + kHead);
  add_text(index, name);
  metadata_indices_.push_back(index);
  put(kMetadata, content);
  metadata_++;
}

void McapWriter::write(uint16_t channel, uint64_t time_ns, const std::string& message) {
  Channel& to = channels_[channel - 1u];
  if (chunk_.empty()) chunk_first_ = time_ns;
  chunk_last_ = time_ns;
  if (messages_ == 0) first_ns_ = time_ns;
  last_ns_ = time_ns;
  // Each chunk repeats the schemas and the channels, so that a reader can read the chunk alone.
  if (!std::exchange(to.announced, true)) {
    chunk_ += record(kSchema, to.schema);
    chunk_ += record(kChannel, to.channel);
  }
  add(to.index, time_ns);
  add(to.index, uint64_t{chunk_.size()});
  std::string content;
  add(content, channel);
  add(content, static_cast<uint32_t>(to.messages));
  add(content, time_ns);
  add(content, time_ns);
  chunk_ += record(kMessage, content + message);
  to.messages++;
  messages_++;
  if (chunk_.size() >= kChunkBytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (chunk_.empty()) return;
  Chunk chunk{chunk_first_, chunk_last_, file_.size(), 0, 0, chunk_.size(), {}};
  std::string content;
  add(content, chunk.first_ns);
  add(content, chunk.last_ns);
  add(content, chunk.size);
  add(content, static_cast<uint32_t>(
                   crc32_z(0, reinterpret_cast<const Bytef*>(chunk_.data()), chunk_.size())));
  add_text(content, "");
  add(content, chunk.size);
  put(kChunk, content + chunk_);
  chunk.bytes = file_.size() - chunk.at;
  for (size_t i = 0; i < channels_.size(); i++) {
    Channel& channel = channels_[i];
    channel.announced = false;
    if (channel.index.empty()) continue;
    const auto id = static_cast<uint16_t>(i + 1);
    chunk.indices[id] = file_.size();
    std::string index;
    add(index, id);
    add_text(index, channel.index);
    put(kMessageIndex, index);
    channel.index.clear();
  }
  chunk.index_bytes = file_.size() - chunk.at - chunk.bytes;
  chunks_.push_back(chunk);
  chunk_.clear();
}

Status McapWriter::commit() {
  end_chunk();
  std::string end;
  add(end, uint32_t{0});
  put(kDataEnd, end);
  const uint64_t summary = file_.size();
  std::string offsets;
  const auto group = [&](uint8_t kind, const auto& write) {
    const uint64_t from = file_.size();
    write();
    if (file_.size() == from) return;
    std::string offset;
    add(offset, kind);
    add(offset, from);
    add(offset, file_.size() - from);
    offsets += record(kSummaryOffset, offset);
  };
  group(kSchema, [&] {
    for (const Channel& channel : channels_) put(kSchema, channel.schema);
  });
  group(kChannel, [&] {
    for (const Channel& channel : channels_) put(kChannel, channel.channel);
  });
  group(kStatistics, [&] {
    std::string statistics;
    add(statistics, messages_);
    add(statistics, static_cast<uint16_t>(channels_.size()));
    add(statistics, static_cast<uint32_t>(channels_.size()));
    add(statistics, uint32_t{0});
    add(statistics, metadata_);
    add(statistics, static_cast<uint32_t>(chunks_.size()));
    add(statistics, first_ns_);
    add(statistics, last_ns_);
    std::map<uint16_t, uint64_t> counts;
    for (size_t i = 0; i < channels_.size(); i++)
      counts[static_cast<uint16_t>(i + 1)] = channels_[i].messages;
    add_numbers(statistics, counts);
    put(kStatistics, statistics);
  });
  group(kMetadataIndex, [&] {
    for (const Record& index : metadata_indices_) put(kMetadataIndex, index);
  });
  group(kChunkIndex, [&] {
    for (const Chunk& chunk : chunks_) {
      std::string index;
      add(index, chunk.first_ns);
      add(index, chunk.last_ns);
      add(index, chunk.at);
      add(index, chunk.bytes);
      add_numbers(index, chunk.indices);
      add(index, chunk.index_bytes);
      add_text(index, "");
      add(index, chunk.size);
      add(index, chunk.size);
      put(kChunkIndex, index);
    }
  });
  const uint64_t offset = file_.size();
  file_.write(offsets);
  std::string footer;
  add(footer, summary);
  add(footer, offset);
  add(footer, uint32_t{0});
  put(kFooter, footer);
  file_.write(kMcapMagic, sizeof kMcapMagic);
  return file_.commit();
}

}  // namespace kibori
