// SPDX-License-Identifier: MIT
#include <kibori/formats/nrrd.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kibori {
namespace {

constexpr int kMaxSide = 2048;
constexpr int64_t kMaxVoxels = int64_t{1} << 28;
constexpr size_t kMaxHeader = size_t{1} << 20;

struct NumberType {
  size_t bytes = 0;
  bool is_signed = false;
};

struct NrrdHeader {
  NumberType type;
  std::array<int, 3> sizes{};
  std::string encoding;
  bool big_endian = false;
  double unit_mm = 1;
  std::optional<Vec3> spacings;
  std::optional<Mat3> directions;  // columns: a step along each axis of the file
  std::string data_file;
  int64_t byte_skip = 0;  // -1: the data is at the end of the file
  int64_t line_skip = 0;
  Vec3 to_lps = Vec3::Ones();  // signs that turn the file's space into left, posterior, superior
  std::map<std::string, std::string> keys;
  size_t size = 0;  // bytes of the header
};

std::string_view trimmed_field(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t begins = text.find_first_not_of(kBlank);
  if (begins == text.npos) return {};
  return text.substr(begins, text.find_last_not_of(kBlank) - begins + 1);
}

// Removes the next word from a text and returns it.
std::string_view word_of(std::string_view& text) {
  text = trimmed_field(text);
  const size_t ends = std::min(text.find_first_of(" \t"), text.size());
  const std::string_view word = text.substr(0, ends);
  text.remove_prefix(ends);
  return word;
}

template <class T>
bool read_number(std::string_view word, T& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

std::optional<NumberType> type_of(std::string_view name) {
  struct Names {
    NumberType type;
    std::array<std::string_view, 7> names;
  };
  static constexpr Names kTypes[] = {
      {{1, true}, {"signed char", "int8", "int8_t"}},
      {{1, false}, {"uchar", "unsigned char", "uint8", "uint8_t"}},
      {{2, true}, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
      {{2, false}, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {{4, true}, {"int", "signed int", "int32", "int32_t"}},
      {{4, false}, {"uint", "unsigned int", "uint32", "uint32_t"}},
      {{8, true},
       {"longlong", "long long", "long long int", "signed long long", "signed long long int",
        "int64", "int64_t"}},
      {{8, false},
       {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}}};
  for (const Names& one : kTypes)
    if (!name.empty() && std::find(one.names.begin(), one.names.end(), name) != one.names.end())
      return one.type;
  return std::nullopt;
}

std::optional<Vec3> three_numbers(std::string_view text) {
  Vec3 v;
  for (int i = 0; i < 3; i++)
    if (!read_number(word_of(text), v[i]) || !std::isfinite(v[i])) return std::nullopt;
  return trimmed_field(text).empty() ? std::optional(v) : std::nullopt;
}

// Parses "(1,0,0) (0,1,0) (0,0,1)".
std::optional<Mat3> three_vectors(std::string text) {
  if (std::count(text.begin(), text.end(), '(') != 3) return std::nullopt;
  for (char& c : text)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::string_view rest = text;
  Mat3 m;
  for (int column = 0; column < 3; column++)
    for (int row = 0; row < 3; row++)
      if (!read_number(word_of(rest), m(row, column)) || !std::isfinite(m(row, column)))
        return std::nullopt;
  return trimmed_field(rest).empty() ? std::optional(m) : std::nullopt;
}

// The signs that turn a space into left, posterior, superior; nullopt if the space is unknown.
std::optional<Vec3> signs_of(std::string_view space) {
  std::string name(space);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (name == "left-posterior-superior" || name == "lps") return Vec3(1, 1, 1);
  if (name == "right-anterior-superior" || name == "ras") return Vec3(-1, -1, 1);
  if (name == "left-anterior-superior" || name == "las") return Vec3(1, -1, 1);
  if (name == "scanner-xyz" || name == "3d-right-handed") return Vec3(1, 1, 1);
  if (name == "3d-left-handed") return Vec3(-1, 1, 1);
  return std::nullopt;
}

// Reads one field into `header` and `dimension`. Returns an error message without the file's name;
// empty if there is no error.
std::string read_field(std::string_view name, std::string_view value, NrrdHeader& header,
                       std::string& dimension) {
  const std::string value_text(value);
  if (name == "type") {
    const std::optional<NumberType> type = type_of(value);
    if (!type) return "has numbers of type '" + value_text + "'; labels are whole numbers";
    header.type = *type;
  } else if (name == "dimension") {
    dimension = value_text;
    if (value != "3") return "has " + value_text + " axes; a labelled volume has three";
  } else if (name == "sizes") {
    std::string_view rest = value;
    for (int& size : header.sizes)
      if (!read_number(word_of(rest), size) || size < 1 || size > kMaxSide)
        return "has sizes '" + value_text + "'; they must be three numbers from 1 to 2048";
    if (!trimmed_field(rest).empty())
      return "has sizes '" + value_text + "'; they must be three numbers";
  } else if (name == "encoding") {
    header.encoding = value == "gz"                       ? "gzip"
                      : value == "text" || value == "txt" ? "ascii"
                                                          : value_text;
    if (header.encoding != "raw" && header.encoding != "gzip" && header.encoding != "ascii")
      return "is encoded as '" + value_text + "'; raw, gzip and ascii can be read";
  } else if (name == "endian") {
    if (value != "little" && value != "big") return "has the unknown endian '" + value_text + "'";
    header.big_endian = value == "big";
  } else if (name == "spacings") {
    header.spacings = three_numbers(value);
    if (!header.spacings) return "has spacings '" + value_text + "'; they must be three numbers";
  } else if (name == "space directions") {
    header.directions = three_vectors(value_text);
    if (!header.directions)
      return "has space directions '" + value_text +
             "'; they must be three vectors of three numbers";
  } else if (name == "space units") {
    const size_t begins = value.find('"'), ends = value.find('"', begins + 1);
    const std::string unit(
        begins < ends && ends != value.npos ? value.substr(begins + 1, ends - begins - 1) : value);
    static const std::map<std::string, double> kUnits = {
        {"mm", 1},    {"millimeter", 1},   {"cm", 10},      {"m", 1000},
        {"um", 1e-3}, {"\xC2\xB5m", 1e-3}, {"micron", 1e-3}};
    const auto known = kUnits.find(unit);
    if (known == kUnits.end()) return "has the unit '" + unit + "'; use mm, cm, m or um";
    header.unit_mm = known->second;
  } else if (name == "data file" || name == "datafile") {
    header.data_file = value_text;
  } else if (name == "line skip" || name == "lineskip") {
    if (!read_number(value, header.line_skip) || header.line_skip < 0)
      return "has line skip '" + value_text + "'; it must be a whole number from 0";
  } else if (name == "byte skip" || name == "byteskip") {
    if (!read_number(value, header.byte_skip) || header.byte_skip < -1)
      return "has byte skip '" + value_text + "'; it must be a whole number from -1";
  } else if (name == "space") {
    const std::optional<Vec3> signs = signs_of(value);
    if (!signs)
      return "is in the space '" + value_text +
             "'; left-posterior-superior, right-anterior-superior, left-anterior-superior, "
             "scanner-xyz and 3D spaces can be read";
    header.to_lps = *signs;
  } else if (name == "space dimension") {
    if (value != "3")
      return "has a space of " + value_text + " dimensions; a labelled volume has three";
  }
  return {};
}

// Decompresses a gzip stream of exactly `skip` + `wanted` bytes, and drops the first `skip`.
// Returns nullopt if it is damaged, shorter or longer.
std::optional<std::vector<char>> inflated(std::span<const char> bytes, size_t skip, size_t wanted) {
  z_stream stream{};
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) return std::nullopt;
  std::vector<char> out;
  std::array<char, 1 << 16> block;
  // The max compression ratio of deflate is 1032.
  out.reserve(std::min(wanted, 1032 * bytes.size()) + block.size());
  size_t read = 0, left = skip;  // `left`: bytes still to be dropped
  int result = Z_OK;
  while (result == Z_OK && out.size() <= wanted) {
    if (stream.avail_in == 0) {
      const size_t next = std::min(bytes.size() - read, size_t{1} << 24);
      if (next == 0) break;
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + read));
      stream.avail_in = static_cast<uInt>(next);
      read += next;
    }
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    result = inflate(&stream, Z_NO_FLUSH);
    const size_t got = block.size() - stream.avail_out, dropped = std::min(left, got);
    left -= dropped;
    out.insert(out.end(), block.data() + dropped, block.data() + got);
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END || left > 0 || out.size() != wanted) return std::nullopt;
  return out;
}

// Labels of raw numbers, in the file's order; nullopt if a number is not a valid label.
std::optional<std::vector<uint16_t>> labels_of(std::span<const char> bytes,
                                               const NrrdHeader& header, size_t count) {
  std::vector<uint16_t> labels(count);
  const size_t step = header.type.bytes;
  for (size_t i = 0; i < count; i++) {
    uint64_t value = 0;
    for (size_t b = 0; b < step; b++) {
      const size_t place = header.big_endian ? b : step - 1 - b;
      value = value << 8 | static_cast<uint8_t>(bytes[i * step + place]);
    }
    const bool negative = header.type.is_signed && (value >> (8 * step - 1)) != 0;
    if (negative || value > 0xffff) return std::nullopt;
    labels[i] = static_cast<uint16_t>(value);
  }
  return labels;
}

std::optional<std::vector<uint16_t>> labels_of_text(std::string text, size_t count) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::string_view rest = text;
  std::vector<uint16_t> labels;
  while (labels.size() <= count) {
    const std::string_view word = word_of(rest);
    if (word.empty()) break;
    uint16_t label = 0;
    if (!read_number(word, label)) return std::nullopt;
    labels.push_back(label);
  }
  if (labels.size() != count) return std::nullopt;
  return labels;
}

// For each axis of the file: the nearest axis of the space, and whether the two are opposite.
struct Turn {
  std::array<int, 3> axis{0, 1, 2};
  std::array<bool, 3> against{};
};

std::optional<Turn> turn_of(const Mat3& directions) {
  // Tries all permutations of the three axes, and takes the one with the best alignment.
  std::array<int, 3> order{0, 1, 2};
  double largest = 0;
  Turn best;
  do {
    double along = 0, product = 1;
    for (int i = 0; i < 3; i++) {
      const double size = directions.col(i).norm();
      if (!(size > 0)) return std::nullopt;
      const double share = std::abs(directions(order[static_cast<size_t>(i)], i)) / size;
      along += share;
      product *= share;
    }
    if (along > largest && product > 1e-9) {
      largest = along;
      best.axis = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  if (!(largest > 0)) return std::nullopt;
  for (int i = 0; i < 3; i++)
    best.against[static_cast<size_t>(i)] = directions(best.axis[static_cast<size_t>(i)], i) < 0;
  return best;
}

// Reads pairs such as "Segment3_LabelValue:=3" and "Segment3_Name:=Enamel".
void read_names(const NrrdHeader& header, LabelVolume& volume) {
  for (const auto& [key, value] : header.keys) {
    constexpr std::string_view kEnding = "_LabelValue";
    if (!key.starts_with("Segment") || !key.ends_with(kEnding)) continue;
    const auto name = header.keys.find(key.substr(0, key.size() - kEnding.size()).append("_Name"));
    uint16_t label = 0;
    if (name != header.keys.end() && read_number(std::string_view(value), label))
      volume.names[label] = sanitize_message(name->second);
  }
}

// Reads the lines up to an empty line or to the end of the file. Error messages do not contain the
// file's name.
Result<NrrdHeader> read_header(std::span<const char> bytes) {
  const std::string_view all = std::string_view(bytes.data(), bytes.size()).substr(0, kMaxHeader);
  if (!all.starts_with("NRRD000")) return Error{"is not an NRRD file"};
  NrrdHeader header;
  std::string dimension;
  size_t line_number = 0, at = 0;
  header.size = bytes.size();
  while (at < all.size()) {
    const size_t ends = std::min(all.find('\n', at), all.size());
    const std::string_view line = trimmed_field(all.substr(at, ends - at));
    at = std::min(ends + 1, all.size());
    if (line_number++ == 0) continue;
    if (line.empty()) {
      header.size = at;
      break;
    }
    if (line.front() == '#') continue;
    const size_t colon = line.find(':');
    if (colon == line.npos)
      return Error{"has a header that can't be read in line " + std::to_string(line_number)};
    const std::string_view value = line.substr(colon + 1);
    if (value.starts_with('=')) {
      header.keys.emplace(trimmed_field(line.substr(0, colon)), trimmed_field(value.substr(1)));
      continue;
    }
    if (trimmed_field(value).empty()) continue;
    std::string name(trimmed_field(line.substr(0, colon)));
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    const std::string fault = read_field(name, trimmed_field(value), header, dimension);
    if (!fault.empty()) return Error{fault};
  }
  for (const auto& [there, name] : {std::pair{header.type.bytes > 0, "type"},
                                    {!dimension.empty(), "dimension"},
                                    {header.sizes[0] > 0, "sizes"},
                                    {!header.encoding.empty(), "encoding"}})
    if (!there)
      return Error{std::string("has no field '") + name + "'; write it again with all fields"};
  int64_t voxels = 1;
  for (const int size : header.sizes) voxels *= size;
  if (voxels > kMaxVoxels)
    return Error{"has more than 268 million voxels; crop it, or halve its resolution"};
  if (header.byte_skip < 0 && header.encoding != "raw")
    return Error{"has byte skip -1, which only raw data can have"};
  return header;
}

Error wrong(const std::filesystem::path& path, const std::string& what) {
  return Error{path.string() + " " + sanitize_message(what)};
}

// The data after the first `lines` line feeds; nullopt if there are fewer.
std::optional<std::span<const char>> without_lines(std::span<const char> data, int64_t lines) {
  for (; lines > 0; lines--) {
    const auto feed = std::find(data.begin(), data.end(), '\n');
    if (feed == data.end()) return std::nullopt;
    data = data.subspan(static_cast<size_t>(feed - data.begin()) + 1);
  }
  return data;
}

}  // namespace

Result<std::filesystem::path> nrrd_data_file(std::span<const char> bytes,
                                             const std::filesystem::path& path) {
  const Result<NrrdHeader> header = read_header(bytes);
  if (!header) return wrong(path, header.error());
  const std::string& value_text = header.value().data_file;
  if (value_text.empty()) return std::filesystem::path();
  const std::filesystem::path name = std::filesystem::path(value_text).lexically_normal();
  if (name.filename() != name || name.empty() || name == ".." || name == "." ||
      value_text.starts_with("LIST") || value_text.find('%') != std::string::npos)
    return wrong(path, "must have its data in one file in the same folder");
  return path.parent_path() / name;
}

Result<LabelVolume> parse_nrrd(std::span<const char> bytes, std::span<const char> detached,
                               const std::filesystem::path& path) {
  const auto wrong = [&](const std::string& what) { return kibori::wrong(path, what); };
  const Result<NrrdHeader> read = read_header(bytes);
  if (!read) return wrong(read.error());
  const NrrdHeader& header = read.value();
  size_t count = 1;
  for (const int size : header.sizes) count *= static_cast<size_t>(size);

  // ---- The data.
  std::span<const char> data = header.data_file.empty() ? bytes.subspan(header.size) : detached;
  const std::string short_of =
                        "is damaged, or the number of its labels is not the product of its sizes; "
                        "export it again",
                    no_label = "has a number that is not a label; labels must be from 0 to 65535";
  const std::optional<std::span<const char>> after_lines = without_lines(data, header.line_skip);
  if (!after_lines) return wrong("has fewer lines than its line skip states");
  data = *after_lines;
  const auto skip = static_cast<size_t>(std::max<int64_t>(header.byte_skip, 0));
  std::optional<std::vector<uint16_t>> labels;
  if (header.encoding == "ascii") {
    if (skip > data.size()) return wrong(short_of);
    data = data.subspan(skip);
    labels = labels_of_text(std::string(data.data(), data.size()), count);
    if (!labels) return wrong(short_of);
  } else {
    const size_t wanted = count * header.type.bytes;
    std::vector<char> unpacked;
    if (header.encoding == "gzip") {
      std::optional<std::vector<char>> out = inflated(data, skip, wanted);
      if (!out) return wrong(short_of);
      unpacked = std::move(*out);
      data = unpacked;
    } else if (header.byte_skip < 0 && data.size() >= wanted) {
      data = data.last(wanted);
    } else if (skip <= data.size()) {
      data = data.subspan(skip);
    }
    if (data.size() != wanted) return wrong(short_of);
    labels = labels_of(data, header, count);
    if (!labels) return wrong(no_label);
  }

  // ---- Convert to x, y, z of the space.
  const Mat3 directions = header.directions
                              ? Mat3(header.to_lps.asDiagonal() * *header.directions)
                              : Mat3(header.spacings.value_or(Vec3::Ones()).asDiagonal());
  const std::optional<Turn> turn = turn_of(directions);
  if (!turn) return wrong("has axes that are not linearly independent");
  LabelVolume volume;
  std::array<int64_t, 3> stride{};
  for (size_t i = 0; i < 3; i++) {
    const int axis = turn->axis[i];
    volume.size[axis] = header.sizes[i];
    volume.voxel_mm[axis] = directions.col(static_cast<int>(i)).norm() * header.unit_mm;
  }
  if (!(volume.voxel_mm.minCoeff() >= 1e-6 && volume.voxel_mm.maxCoeff() <= 1e6))
    return wrong("has voxels of an invalid size; it must be 1e-6 to 1e6 mm");
  stride[0] = 1;
  stride[1] = volume.size.x();
  stride[2] = int64_t{1} * volume.size.x() * volume.size.y();
  volume.values.resize(count);
  size_t next = 0;
  std::array<int, 3> index{};
  for (index[2] = 0; index[2] < header.sizes[2]; index[2]++)
    for (index[1] = 0; index[1] < header.sizes[1]; index[1]++)
      for (index[0] = 0; index[0] < header.sizes[0]; index[0]++) {
        int64_t to = 0;
        for (size_t i = 0; i < 3; i++)
          to += stride[static_cast<size_t>(turn->axis[i])] *
                (turn->against[i] ? header.sizes[i] - 1 - index[i] : index[i]);
        volume.values[static_cast<size_t>(to)] = (*labels)[next++];
      }
  read_names(header, volume);
  return volume;
}

}  // namespace kibori
