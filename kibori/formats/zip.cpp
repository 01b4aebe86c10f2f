// SPDX-License-Identifier: MIT
#include <kibori/formats/zip.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <limits>

#include <zlib.h>

namespace kibori {
namespace {

constexpr uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50;
constexpr uint32_t kEnd64 = 0x06064b50, kLocator64 = 0x07064b50;
constexpr size_t kLocalSize = 30, kCentralSize = 46, kEndSize = 22, kEnd64Size = 56,
                 kLocator64Size = 20;
constexpr uint32_t kSizes64 = 1;  // id of the extra field with 64-bit sizes
constexpr size_t kMaxEntries = 10000;
// Deflate reduces meshes in XML to a tenth of their size, and no real file to less than a
// hundredth. The first kFreeBytes of an entry are always allowed.
constexpr uint64_t kMaxRatio = 100, kFreeBytes = 1 << 20;
constexpr uint64_t kMax32 = std::numeric_limits<uint32_t>::max();

void put(std::string& to, uint64_t value, int bytes) {
  for (int i = 0; i < bytes; i++) to.push_back(static_cast<char>(value >> (8 * i)));
}

uint64_t get64(std::span<const char> bytes, size_t at, int count = 8) {
  uint64_t value = 0;
  for (int i = 0; i < count; i++)
    value |= static_cast<uint64_t>(static_cast<unsigned char>(bytes[at + static_cast<size_t>(i)]))
             << (8 * i);
  return value;
}
uint32_t get(std::span<const char> bytes, size_t at, int count) {
  return static_cast<uint32_t>(get64(bytes, at, count));
}

// Replaces each number that equals 0xffffffff with the next number of the extra field with 64-bit
// sizes. Returns false if that field is too short. `extras`: the extra fields of a directory entry.
bool take_sizes64(std::span<const char> extras, std::initializer_list<uint64_t*> numbers) {
  std::span<const char> field;
  while (extras.size() >= 4) {
    const size_t size = get(extras, 2, 2);
    if (size > extras.size() - 4) break;
    if (get(extras, 0, 2) == kSizes64) field = extras.subspan(4, size);
    extras = extras.subspan(4 + size);
  }
  for (uint64_t* number : numbers) {
    if (*number != kMax32) continue;
    if (field.size() < 8)
      return field.empty();  // without the extra field, 0xffffffff is the real size
    *number = get64(field, 0);
    field = field.subspan(8);
  }
  return true;
}

// The fields that a local header and a directory entry share.
void put_common(std::string& to, uint32_t crc, uint64_t packed, uint64_t whole, size_t name) {
  put(to, 20, 2);    // version needed
  put(to, 0, 2);     // flags
  put(to, 8, 2);     // deflate
  put(to, 0, 2);     // time
  put(to, 0x21, 2);  // 1 January 1980, so that equal models make equal files
  put(to, crc, 4);
  put(to, packed, 4);
  put(to, whole, 4);
  put(to, name, 2);
  put(to, 0, 2);  // extra
}

}  // namespace

ZipWriter::ZipWriter(NewFile& file) : file_(file), stream_(std::make_unique<z_stream>()) {}
ZipWriter::~ZipWriter() = default;

void ZipWriter::begin(const std::string& name) {
  entries_.push_back({name, 0, 0, 0, file_.size()});
  std::string header;
  put(header, kLocal, 4);
  put_common(header, 0, 0, 0, name.size());
  file_.write(header + name);
  *stream_ = {};
  // Raw deflate. Level 3 is 4 times as fast as the default, and its output is 10 % larger.
  KIBORI_CHECK(deflateInit2(stream_.get(), 3, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY) == Z_OK);
}

void ZipWriter::deflate_some(std::string_view data, int flush) {
  Entry& entry = entries_.back();
  stream_->next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(data.data()));
  stream_->avail_in = static_cast<uInt>(data.size());
  int state = Z_OK;
  do {
    char packed[1 << 14];
    stream_->next_out = reinterpret_cast<Bytef*>(packed);
    stream_->avail_out = sizeof packed;
    state = deflate(stream_.get(), flush);
    const size_t bytes = sizeof packed - stream_->avail_out;
    file_.write(packed, bytes);
    entry.packed += bytes;
  } while (stream_->avail_out == 0 && state != Z_STREAM_END);
}

void ZipWriter::write(std::string_view data) {
  while (!data.empty()) {
    const std::string_view some = data.substr(0, 1 << 30);
    Entry& entry = entries_.back();
    entry.whole += some.size();
    entry.crc = static_cast<uint32_t>(crc32(entry.crc, reinterpret_cast<const Bytef*>(some.data()),
                                            static_cast<uInt>(some.size())));
    deflate_some(some, Z_NO_FLUSH);
    data.remove_prefix(some.size());
  }
}

void ZipWriter::end() {
  deflate_some({}, Z_FINISH);
  deflateEnd(stream_.get());
  const Entry& entry = entries_.back();
  std::string header;
  put(header, kLocal, 4);
  put_common(header, entry.crc, entry.packed, entry.whole, entry.name.size());
  file_.overwrite(entry.at, header.data(), header.size());
}

Status ZipWriter::finish() {
  const uint64_t at = file_.size();
  std::string directory;
  uint64_t max = at;
  for (const Entry& e : entries_) {
    max = std::max(max, e.whole);
    put(directory, kCentral, 4);
    put(directory, 20, 2);  // made by
    put_common(directory, e.crc, e.packed, e.whole, e.name.size());
    put(directory, 0, 2);  // comment
    put(directory, 0, 2);  // disk
    put(directory, 0, 2);  // attributes
    put(directory, 0, 4);
    put(directory, e.at, 4);
    directory += e.name;
  }
  const size_t size = directory.size();
  put(directory, kEnd, 4);
  put(directory, 0, 4);  // disks
  put(directory, entries_.size(), 2);
  put(directory, entries_.size(), 2);
  put(directory, size, 4);
  put(directory, at, 4);
  put(directory, 0, 2);  // comment
  file_.write(directory);
  if (max > kMax32)
    return Error{
        "exceeds the limit of 4 GB of a 3MF file; use a coarser pitch, a tolerance or another "
        "format"};
  return Ok{};
}

Result<ZipReader> ZipReader::open(std::span<const char> bytes) {
  ZipReader zip;
  zip.bytes_ = bytes;
  if (bytes.size() < kEndSize) return Error{"is not a ZIP archive (cut short?)"};
  // The end record is last, before a comment of at most 65535 bytes.
  size_t end = bytes.size() - kEndSize;
  const size_t stop = end - std::min<size_t>(end, 65535);
  while (get(bytes, end, 4) != kEnd || get(bytes, end + 20, 2) != bytes.size() - end - kEndSize) {
    if (end == stop) return Error{"is not a ZIP archive (cut short?)"};
    end--;
  }
  uint64_t count = get(bytes, end + 10, 2), at = get(bytes, end + 16, 4);
  // 64-bit numbers are in a separate record. A locator before the end record gives its position.
  if (end >= kLocator64Size && get(bytes, end - kLocator64Size, 4) == kLocator64) {
    const uint64_t record = get64(bytes, end - kLocator64Size + 8);
    if (record > end || end - record < kEnd64Size || get(bytes, record, 4) != kEnd64)
      return Error{"has a damaged directory (cut short?)"};
    count = get64(bytes, record + 32);
    at = get64(bytes, record + 48);
  }
  if (count > kMaxEntries) return Error{"has too many entries for a 3MF file"};
  for (uint64_t i = 0; i < count; i++) {
    if (at > end || end - at < kCentralSize || get(bytes, at, 4) != kCentral)
      return Error{"has a damaged directory (cut short?)"};
    const size_t name_size = get(bytes, at + 28, 2);
    const size_t extras = size_t{get(bytes, at + 30, 2)} + get(bytes, at + 32, 2);
    if (end - at - kCentralSize < name_size + extras)
      return Error{"has a damaged directory (cut short?)"};
    Entry e;
    e.name.assign(bytes.data() + at + kCentralSize, name_size);
    const std::string shown = "has an entry '" + e.name.substr(0, 60) + "' ";
    const std::string framed = "/" + e.name + "/";
    if (e.name.empty() || e.name[0] == '/' || e.name.find('\\') != std::string::npos ||
        e.name.find('\0') != std::string::npos || framed.find("/../") != std::string::npos)
      return Error{"has an entry whose name points outside the archive; do not trust this file"};
    if (get(bytes, at + 8, 2) & 1)
      return Error{shown + "that is encrypted; save it without a password"};
    e.method = static_cast<uint16_t>(get(bytes, at + 10, 2));
    e.crc = get(bytes, at + 16, 4);
    e.packed = get(bytes, at + 20, 4);
    e.whole = get(bytes, at + 24, 4);
    uint64_t local = get(bytes, at + 42, 4);
    if (!take_sizes64(bytes.subspan(at + kCentralSize + name_size, get(bytes, at + 30, 2)),
                      {&e.whole, &e.packed, &local}))
      return Error{shown + "without its 64-bit sizes; save the file again"};
    if (local > bytes.size() || bytes.size() - local < kLocalSize || get(bytes, local, 4) != kLocal)
      return Error{shown + "that is missing at the position in the directory"};
    e.at = local + kLocalSize + get(bytes, local + 26, 2) + get(bytes, local + 28, 2);
    if (e.at > bytes.size() || bytes.size() - e.at < e.packed)
      return Error{shown + "that is cut short"};
    if (e.whole > kFreeBytes + kMaxRatio * e.packed)
      return Error{shown + "that claims to unpack to more than " + std::to_string(kMaxRatio) +
                   " times its size; do not trust this file"};
    at += kCentralSize + name_size + extras;
    zip.entries_.push_back(std::move(e));
  }
  return zip;
}

const ZipReader::Entry* ZipReader::find(const std::string& name) const {
  for (const Entry& e : entries_)
    if (e.name == name) return &e;
  return nullptr;
}

Status ZipReader::read(const std::string& name,
                       const std::function<bool(std::string_view)>& f) const {
  const Entry* entry = find(name);
  if (!entry) return Error{"has no entry '" + name.substr(0, 60) + "'"};
  const std::string shown = "entry '" + name.substr(0, 60) + "' ";
  if (entry->method == 0) {
    if (entry->packed != entry->whole)
      return Error{shown + "has two different sizes; export it again"};
    if (crc32_z(0, reinterpret_cast<const Bytef*>(bytes_.data() + entry->at), entry->whole) !=
        entry->crc)
      return Error{shown + "is damaged (its checksum is wrong)"};
    f({bytes_.data() + entry->at, entry->whole});
    return Ok{};
  }
  if (entry->method != 8) return Error{shown + "has an unsupported compression method"};
  z_stream stream = {};
  if (inflateInit2(&stream, -15) != Z_OK) return Error{"out of memory"};
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes_.data() + entry->at));
  stream.avail_in = static_cast<uInt>(entry->packed);
  std::vector<char> block(1 << 16);
  uint64_t whole = 0;
  uLong crc = 0;
  int state = Z_OK;
  bool wanted = true;
  while (wanted && state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    state = inflate(&stream, Z_NO_FLUSH);
    const size_t bytes = block.size() - stream.avail_out;
    if (bytes == 0 && state == Z_OK) break;
    whole += bytes;
    if (whole > entry->whole) break;
    crc = crc32_z(crc, reinterpret_cast<const Bytef*>(block.data()), bytes);
    wanted = f({block.data(), bytes});
  }
  inflateEnd(&stream);
  if (!wanted) return Ok{};
  if (state != Z_STREAM_END || whole != entry->whole || crc != entry->crc)
    return Error{shown +
                 "is damaged (its size or checksum is not the one that the archive states)"};
  return Ok{};
}

}  // namespace kibori
