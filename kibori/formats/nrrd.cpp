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

#include <kibori/base/file.h>

namespace kibori {
namespace {

constexpr int kMaxSide = 2048;
constexpr int64_t kMaxVoxels = int64_t{1} << 28;
constexpr size_t kMaxHeader = size_t{1} << 20;

struct NumberType {
  size_t bytes = 0;
  bool is_signed = false;
};

struct Header {
  NumberType type;
  std::array<int, 3> sizes{};
  std::string encoding;
  bool big_endian = false;
  double unit_mm = 1;
  std::optional<Vec3> spacings;
  std::optional<Mat3> directions;  // columns: a step along each axis of the file
  std::string data_file;
  std::map<std::string, std::string> keys;
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t begins = text.find_first_not_of(kBlank);
  if (begins == text.npos) return {};
  return text.substr(begins, text.find_last_not_of(kBlank) - begins + 1);
}

// The next word of a text, which is shortened by it.
std::string_view word_of(std::string_view& text) {
  text = trimmed(text);
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
    std::array<std::string_view, 6> names;
  };
  static constexpr Names kTypes[] = {
      {{1, true}, {"signed char", "int8", "int8_t"}},
      {{1, false}, {"uchar", "unsigned char", "uint8", "uint8_t"}},
      {{2, true}, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
      {{2, false}, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {{4, true}, {"int", "signed int", "int32", "int32_t"}},
      {{4, false}, {"uint", "unsigned int", "uint32", "uint32_t"}}};
  for (const Names& one : kTypes)
    if (std::find(one.names.begin(), one.names.end(), name) != one.names.end()) return one.type;
  return std::nullopt;
}

std::optional<Vec3> three_numbers(std::string_view text) {
  Vec3 v;
  for (int i = 0; i < 3; i++)
    if (!read_number(word_of(text), v[i]) || !std::isfinite(v[i])) return std::nullopt;
  return trimmed(text).empty() ? std::optional(v) : std::nullopt;
}

// "(1,0,0) (0,1,0) (0,0,1)"
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
  return trimmed(rest).empty() ? std::optional(m) : std::nullopt;
}

// One sentence without the file's name, or none where all is well.
std::string read_field(std::string_view name, std::string_view value, Header& header,
                       std::string& dimension) {
  const std::string said(value);
  if (name == "type") {
    const std::optional<NumberType> type = type_of(value);
    if (!type) return "has numbers of type '" + said + "'; labels are whole numbers";
    header.type = *type;
  } else if (name == "dimension") {
    dimension = said;
    if (value != "3") return "has " + said + " axes; a labelled volume has three";
  } else if (name == "sizes") {
    std::string_view rest = value;
    for (int& size : header.sizes)
      if (!read_number(word_of(rest), size) || size < 1 || size > kMaxSide)
        return "has sizes '" + said + "'; they must be three numbers from 1 to 2048";
    if (!trimmed(rest).empty()) return "has sizes '" + said + "'; they must be three";
  } else if (name == "encoding") {
    header.encoding = value == "gz" ? "gzip" : value == "text" || value == "txt" ? "ascii" : said;
    if (header.encoding != "raw" && header.encoding != "gzip" && header.encoding != "ascii")
      return "is encoded as '" + said + "'; raw, gzip and ascii can be read";
  } else if (name == "endian") {
    if (value != "little" && value != "big") return "has no endian called '" + said + "'";
    header.big_endian = value == "big";
  } else if (name == "spacings") {
    header.spacings = three_numbers(value);
    if (!header.spacings) return "has spacings '" + said + "'; they must be three numbers";
  } else if (name == "space directions") {
    header.directions = three_vectors(said);
    if (!header.directions)
      return "has space directions '" + said + "'; they must be three vectors of three numbers";
  } else if (name == "space units") {
    const size_t begins = value.find('"'), ends = value.find('"', begins + 1);
    const std::string unit(
        begins < ends && ends != value.npos ? value.substr(begins + 1, ends - begins - 1) : value);
    static const std::map<std::string, double> kUnits = {
        {"mm", 1},    {"millimeter", 1},   {"cm", 10},      {"m", 1000},
        {"um", 1e-3}, {"\xC2\xB5m", 1e-3}, {"micron", 1e-3}};
    const auto known = kUnits.find(unit);
    if (known == kUnits.end()) return "has lengths in '" + unit + "'; mm, cm, m and um are known";
    header.unit_mm = known->second;
  } else if (name == "data file" || name == "datafile") {
    header.data_file = said;
  } else if (name == "line skip" || name == "lineskip" || name == "byte skip" ||
             name == "byteskip") {
    if (value != "0") return "skips a part of its data; write it without";
  }
  return {};
}

// All of a gzip stream, as many bytes as wanted; nothing where it is damaged, shorter or longer.
std::optional<std::vector<char>> inflated(std::span<const char> bytes, size_t wanted) {
  z_stream stream{};
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) return std::nullopt;
  std::vector<char> out;
  std::array<char, 1 << 16> block;
  size_t read = 0;
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
    out.insert(out.end(), block.data(), block.data() + (block.size() - stream.avail_out));
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END || out.size() != wanted) return std::nullopt;
  return out;
}

// The numbers in the file's order; nothing where one is no label.
std::optional<std::vector<uint16_t>> labels_of(std::span<const char> bytes, const Header& header,
                                               size_t count) {
  std::vector<uint16_t> labels(count);
  const size_t step = header.type.bytes;
  for (size_t i = 0; i < count; i++) {
    uint32_t value = 0;
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

// Which of the space's axes each of the file's is nearest to, and whether it runs against it.
struct Turn {
  std::array<int, 3> axis{0, 1, 2};
  std::array<bool, 3> against{};
};

std::optional<Turn> turn_of(const Mat3& directions) {
  // Of all ways to match them, the one with the most along: three axes are soon tried.
  std::array<int, 3> order{0, 1, 2};
  double most = 0;
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
    if (along > most && product > 1e-9) {
      most = along;
      best.axis = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  if (!(most > 0)) return std::nullopt;
  for (int i = 0; i < 3; i++)
    best.against[static_cast<size_t>(i)] = directions(best.axis[static_cast<size_t>(i)], i) < 0;
  return best;
}

// "Segment3_LabelValue:=3" and "Segment3_Name:=Enamel".
void read_names(const Header& header, LabelVolume& volume) {
  for (const auto& [key, value] : header.keys) {
    constexpr std::string_view kEnding = "_LabelValue";
    if (!key.starts_with("Segment") || !key.ends_with(kEnding)) continue;
    const auto name = header.keys.find(key.substr(0, key.size() - kEnding.size()).append("_Name"));
    uint16_t label = 0;
    if (name != header.keys.end() && read_number(std::string_view(value), label))
      volume.names[label] = sanitize_message(name->second);
  }
}

}  // namespace

Result<LabelVolume> parse_nrrd(std::span<const char> bytes, const std::filesystem::path& path) {
  const auto wrong = [&](const std::string& what) {
    return Error{path.string() + " " + sanitize_message(what)};
  };
  std::string_view rest(bytes.data(), bytes.size());
  if (!rest.starts_with("NRRD000")) return wrong("is no NRRD file");
  // ---- The header: lines up to an empty one, or to the end.
  Header header;
  std::string dimension;
  size_t line_number = 0;
  const std::string_view all = rest.substr(0, kMaxHeader);
  size_t at = 0;
  bool ended = false;
  while (at < all.size()) {
    const size_t ends = std::min(all.find('\n', at), all.size());
    const std::string_view line = trimmed(all.substr(at, ends - at));
    at = std::min(ends + 1, all.size());
    if (line_number++ == 0) continue;
    if (line.empty()) {
      ended = true;
      break;
    }
    if (line.front() == '#') continue;
    const size_t colon = line.find(':');
    if (colon == line.npos || colon + 1 >= line.size())
      return wrong("has a header that can't be read in line " + std::to_string(line_number));
    if (line[colon + 1] == '=') {
      header.keys.emplace(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 2)));
      continue;
    }
    std::string name(trimmed(line.substr(0, colon)));
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    const std::string fault = read_field(name, trimmed(line.substr(colon + 1)), header, dimension);
    if (!fault.empty()) return wrong(fault);
  }
  for (const auto& [there, name] : {std::pair{header.type.bytes > 0, "type"},
                                    {!dimension.empty(), "dimension"},
                                    {header.sizes[0] > 0, "sizes"},
                                    {!header.encoding.empty(), "encoding"}})
    if (!there) return wrong(std::string("does not say its ") + name);
  int64_t voxels = 1;
  for (const int size : header.sizes) voxels *= size;
  if (voxels > kMaxVoxels) return wrong("has more than 268 million voxels; cut or halve it");
  const auto count = static_cast<size_t>(voxels);

  // ---- The data.
  std::vector<char> beside;
  std::span<const char> data = bytes.subspan(ended ? at : bytes.size());
  if (!header.data_file.empty()) {
    const std::filesystem::path name = header.data_file;
    if (name.filename() != name || header.data_file.starts_with("LIST") ||
        header.data_file.find('%') != std::string::npos)
      return wrong("must have its data in one file in the same folder");
    Result<std::vector<char>> read = read_file(path.parent_path() / name);
    if (!read) return Error{read.error()};
    beside = std::move(read).value();
    data = beside;
  }
  const std::string short_of = "does not have as many labels as its sizes say, or is damaged",
                    no_label = "has a number that is no label; labels are from 0 to 65535";
  std::optional<std::vector<uint16_t>> labels;
  if (header.encoding == "ascii") {
    labels = labels_of_text(std::string(data.data(), data.size()), count);
    if (!labels) return wrong(short_of);
  } else {
    const size_t wanted = count * header.type.bytes;
    std::vector<char> unpacked;
    if (header.encoding == "gzip") {
      std::optional<std::vector<char>> out = inflated(data, wanted);
      if (!out) return wrong(short_of);
      unpacked = std::move(*out);
      data = unpacked;
    }
    if (data.size() != wanted) return wrong(short_of);
    labels = labels_of(data, header, count);
    if (!labels) return wrong(no_label);
  }

  // ---- As x, y, z of the space.
  const Mat3 directions =
      header.directions.value_or(Mat3(header.spacings.value_or(Vec3::Ones()).asDiagonal()));
  const std::optional<Turn> turn = turn_of(directions);
  if (!turn) return wrong("has axes that do not span space");
  LabelVolume volume;
  std::array<int64_t, 3> stride{};
  for (size_t i = 0; i < 3; i++) {
    const int axis = turn->axis[i];
    volume.size[axis] = header.sizes[i];
    volume.voxel_mm[axis] = directions.col(static_cast<int>(i)).norm() * header.unit_mm;
  }
  if (!(volume.voxel_mm.minCoeff() >= 1e-6 && volume.voxel_mm.maxCoeff() <= 1e6))
    return wrong("has voxels of a size that can't be; they must be 1e-6 to 1e6 mm");
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

Result<LabelVolume> read_nrrd(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path);
  if (!bytes) return Error{bytes.error()};
  return parse_nrrd(bytes.value(), path);
}

}  // namespace kibori
