// SPDX-License-Identifier: MIT
// A GLB file is a header, a chunk of JSON and a chunk of bytes. A .gltf file is the JSON alone; its
// bytes are in data URIs or in files next to it. Both describe:
//
//   scene -> nodes (a tree of transforms) -> meshes -> primitives -> accessors -> buffer views
//
// A file may be malicious. Therefore, the parser checks the type of each member of the JSON before
// use, and compares each range with the size of the data.
#include <kibori/formats/glb.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/base/tolerances.h>
#include <kibori/formats/text.h>

namespace kibori {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kGlbMagic = "glTF", kJsonChunk = "JSON", kBinChunk = {"BIN\0", 4};
constexpr size_t kGlbHeader = 12, kChunkHeader = 8;
constexpr size_t kShownJsonBytes =
    120;  // max length of the JSON parser's message, which quotes the file
constexpr double kMmPerMetre = 1000;
constexpr std::string_view kDraco = "KHR_draco_mesh_compression";

// An exception that does not leave this file. It stops the parser, and parse_glb converts it to an
// Error.
struct Refusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// --- JSON

const Json& member(const Json& object, const char* key) {
  static const Json kNone;
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found == object.end() ? kNone : *found;
}

// Converts a number to an integer from 0 to 2^53; nullopt for anything else. Some programs write
// integers as 24.0.
std::optional<uint64_t> whole(const Json& value) {
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  if (!(number >= 0 && number <= 9007199254740992.0) || number != std::floor(number))
    return std::nullopt;
  return static_cast<uint64_t>(number);
}
uint64_t whole_member(const Json& object, const char* key, const std::string& where,
                      std::optional<uint64_t> otherwise = std::nullopt) {
  const Json& value = member(object, key);
  if (value.is_null() && otherwise) return *otherwise;
  const std::optional<uint64_t> number = whole(value);
  if (!number)
    throw Refusal(where + " has no '" + key + "' that is a whole number; export it again");
  return *number;
}
std::string text_of(const Json& value) {
  return value.is_string() ? value.get_ref<const std::string&>() : std::string();
}
std::vector<double> numbers_of(const Json& value, size_t count, const std::string& where) {
  std::vector<double> numbers;
  if (value.is_array() && value.size() == count)
    for (const Json& number : value)
      if (number.is_number() && std::isfinite(number.get<double>()))
        numbers.push_back(number.get<double>());
  if (numbers.size() != count)
    throw Refusal(where + " is not " + std::to_string(count) + " numbers; export it again");
  return numbers;
}
const Json& list(const Json& object, const char* key) {
  static const Json kEmpty = Json::array();
  const Json& found = member(object, key);
  return found.is_array() ? found : kEmpty;
}

Json parse_object(std::string_view text) {
  text = without_bom(text);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);  // some files end with NUL
  std::string why, ascii(text);
  Json json = parse_json(ascii, &why);
  if (json.is_discarded()) {
    // The text may be invalid because it contains names that are not UTF-8. Names of objects are
    // not used, so all bytes beyond ASCII are replaced. A data file with such a name is then not
    // found.
    for (char& c : ascii)
      if (static_cast<unsigned char>(c) >= 0x80) c = '?';
    json = parse_json(ascii, &why);
  }
  if (json.is_discarded())
    throw Refusal("its JSON is invalid (" + why.substr(0, kShownJsonBytes) + "); export it again");
  if (!json.is_object()) throw Refusal("its JSON is not an object; export it again");
  return json;
}

// --- container

struct Container {
  std::string_view json;
  std::optional<std::string_view> bytes;  // data of the first buffer
};

uint32_t number_at(std::string_view bytes, size_t at) {
  uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Container open_container(std::string_view bytes) {
  if (!bytes.starts_with(kGlbMagic)) {
    const std::string_view text = without_bom(bytes);
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos && text[first] == '{') return {text, std::nullopt};
    throw Refusal("it does not begin with 'glTF'; check that it is a GLB file");
  }
  if (bytes.size() < kGlbHeader + kChunkHeader) throw Refusal("it is cut short; export it again");
  if (const uint32_t version = number_at(bytes, 4); version != 2)
    throw Refusal("has version " + std::to_string(version) + " of glTF; export it as version 2");
  // The padding of the last chunk may be missing.
  if (const uint64_t length = number_at(bytes, 8); length > bytes.size() + 3)
    throw Refusal("byte 8 promises " + std::to_string(length) + " bytes, but the file has " +
                  std::to_string(bytes.size()) + " (cut short?); export it again");
  const size_t json = kGlbHeader + kChunkHeader, size = number_at(bytes, kGlbHeader);
  if (bytes.substr(kGlbHeader + 4, 4) != kJsonChunk)
    throw Refusal("its first chunk is not JSON; export it again");
  if (size > bytes.size() - json) throw Refusal("its JSON is cut short; export it again");
  Container container{bytes.substr(json, size), std::nullopt};
  // Chunks begin at multiples of four bytes. Older programs did not pad the JSON. Therefore, a
  // binary chunk directly after it is accepted, too.
  for (size_t at = json + size; at <= bytes.size() && bytes.size() - at >= kChunkHeader;) {
    const size_t padded = (at + 3) / 4 * 4;
    const auto type = [&](size_t begin) {
      return bytes.substr(std::min(begin + 4, bytes.size()), 4);
    };
    if (type(at) != kBinChunk) at = padded;
    if (at > bytes.size() || bytes.size() - at < kChunkHeader) break;
    const size_t room = bytes.size() - at - kChunkHeader, length = number_at(bytes, at);
    if (length > room + 3)
      throw Refusal("its chunk at byte " + std::to_string(at) + " promises " +
                    std::to_string(length) + " bytes, but the file has " + std::to_string(room) +
                    " (cut short?); export it again");
    if (type(at) == kBinChunk) {
      container.bytes = bytes.substr(at + kChunkHeader, length);
      break;
    }
    at += kChunkHeader + std::min(length, room);
  }
  return container;
}

std::string decode_base64(std::string_view text, const std::string& where) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    const uint32_t value = c >= 'A' && c <= 'Z'   ? static_cast<uint32_t>(c - 'A')
                           : c >= 'a' && c <= 'z' ? static_cast<uint32_t>(c - 'a' + 26)
                           : c >= '0' && c <= '9' ? static_cast<uint32_t>(c - '0' + 52)
                           : c == '+' || c == '-' ? 62
                           : c == '/' || c == '_' ? 63
                                                  : 64;
    if (value == 64) throw Refusal(where + " has a data URI that is not base64; export it again");
    bits = bits << 6 | value;
    if ((held += 6) < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<char>(bits >> held));
  }
  return bytes;
}

// --- data in other files

constexpr std::string_view kDataUri = "data:";
// The end of messages about other files.
constexpr const char* kUseGlb = ", or save all as one GLB file (.glb)";

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char lower = static_cast<char>(c | 0x20);
  return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

// Decodes the %XX escapes of a URI. A % without two hex digits is kept, because some programs do
// not escape names.
std::string unescaped(std::string_view uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); i++) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1,
              low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
    text.push_back(low >= 0 ? static_cast<char>(16 * high + low) : uri[i]);
    if (low >= 0) i += 2;
  }
  return text;
}

// True if a path is absolute or contains `..`. A \ counts as a /, because it is a separator on
// Windows.
bool leaves_folder(const std::string& path) {
  const auto is_separator = [](char c) { return c == '/' || c == '\\'; };
  if (is_separator(path.front())) return true;
  for (size_t begin = 0; begin <= path.size();) {
    size_t end = begin;
    while (end < path.size() && !is_separator(path[end])) end++;
    if (path.substr(begin, end - begin) == "..") return true;
    begin = end + 1;
  }
  return false;
}

// Reads the file that the URI of a buffer names, in the folder of the file `from`.
Result<std::vector<char>> read_named(const std::string& uri, const std::filesystem::path& from) {
  namespace fs = std::filesystem;
  const auto refused = [&](const std::string& why) {
    return Error{"is in " + in_quotes(uri) + ", " + why + kUseGlb};
  };
  const std::string name = unescaped(uri), outside = "outside of the file's folder; copy it there";
  if (name.empty() || name.find('\0') != std::string::npos)
    return refused("which is not the name of a file; export it again");
  if (const size_t colon = name.find(':'); colon < name.find_first_of("/\\")) {
    // A single letter before the colon is a Windows drive.
    if (colon == 1) return refused(outside);
    if (colon != std::string::npos)
      return refused("but Kibori does not load web addresses; save it next to the file");
  }
  if (leaves_folder(name)) return refused(outside);
  const fs::path folder = from.parent_path().empty() ? fs::path(".") : from.parent_path();
  std::error_code error;
  const fs::path inside = fs::canonical(folder, error), path = fs::canonical(folder / name, error);
  if (error) return refused("which does not exist; put it next to the file");
  // A link may lead out of the folder.
  const fs::path steps = path.lexically_relative(inside);
  if (steps.empty() || *steps.begin() == "..") return refused(outside);
  Result<std::vector<char>> bytes = read_file(path);
  if (!bytes) return refused("which is no file that can be read; put it next to the file");
  return bytes;
}

// --- accessors

enum class ComponentType : uint64_t {
  int8 = 5120,
  uint8 = 5121,
  int16 = 5122,
  uint16 = 5123,
  uint32 = 5125,
  float32 = 5126
};

size_t component_bytes(ComponentType type) {
  switch (type) {
    case ComponentType::int8:
    case ComponentType::uint8:
      return 1;
    case ComponentType::int16:
    case ComponentType::uint16:
      return 2;
    case ComponentType::uint32:
    case ComponentType::float32:
      return 4;
  }
  return 0;
}

template <class T>
double value_at(const char* at, bool normalized) {
  T value;
  std::memcpy(&value, at, sizeof value);
  if constexpr (std::is_integral_v<T>)
    if (normalized)
      return std::max(static_cast<double>(value) / std::numeric_limits<T>::max(), -1.0);
  return static_cast<double>(value);
}

// Elements of one component type. A sparse accessor replaces some of them.
struct Accessor {
  ComponentType type = ComponentType::float32;
  bool normalized = false;
  size_t count = 0, components = 1;
  const char* data = nullptr;  // null: zeros
  size_t stride = 0;
  std::vector<uint64_t> replaced;      // indices of the replaced elements, ascending
  const char* replacements = nullptr;  // their new values

  double at(size_t index, size_t component) const {
    const size_t size = component_bytes(type);
    const char* element = data ? data + index * stride : nullptr;
    if (!replaced.empty())
      if (const auto found = std::ranges::lower_bound(replaced, index);
          found != replaced.end() && *found == index)
        element = replacements + static_cast<size_t>(found - replaced.begin()) * size * components;
    if (!element) return 0;
    element += size * component;
    switch (type) {
      case ComponentType::int8:
        return value_at<int8_t>(element, normalized);
      case ComponentType::uint8:
        return value_at<uint8_t>(element, normalized);
      case ComponentType::int16:
        return value_at<int16_t>(element, normalized);
      case ComponentType::uint16:
        return value_at<uint16_t>(element, normalized);
      case ComponentType::uint32:
        return value_at<uint32_t>(element, normalized);
      case ComponentType::float32:
        return value_at<float>(element, false);
    }
    return 0;
  }
};

// --- the file

class GlbParser {
 public:
  GlbParser(std::string_view bytes, std::vector<std::string>* notes, const GltfFiles* files)
      : container_(open_container(bytes)),
        json_(parse_object(container_.json)),
        files_(files),
        size_(bytes.size() + bytes_of(files)),
        notes_(notes) {}

  TriangleMesh run() {
    check_version();
    check_extensions();
    // The nodes to visit, each with the transform from its parent to the world.
    std::vector<std::pair<size_t, Eigen::Matrix4d>> open;
    const std::vector<uint64_t> roots = find_roots();
    for (auto root = roots.rbegin(); root != roots.rend(); ++root)
      open.emplace_back(*root, Eigen::Matrix4d::Identity());
    const Json& nodes = list(json_, "nodes");
    std::vector<bool> seen(nodes.size());
    while (!open.empty()) {
      const auto [index, above] = open.back();
      open.pop_back();
      const std::string where = "node " + std::to_string(index);
      if (index >= nodes.size())
        throw Refusal(where + " is referenced but missing; export it again");
      if (seen[index]) throw Refusal(where + " occurs twice in the scene; export it again");
      seen[index] = true;
      const Json& node = nodes[index];
      const Eigen::Matrix4d to_world = above * transform_of(node, where);
      note_node(node);
      if (node.contains("mesh")) add_mesh(whole_member(node, "mesh", where), to_world);
      const Json& children = list(node, "children");
      for (size_t i = children.size(); i > 0; i--) {
        const std::optional<uint64_t> child = whole(children[i - 1]);
        if (!child) throw Refusal(where + " has a child that is not a number; export it again");
        open.emplace_back(*child, to_world);
      }
    }
    if (mesh_.triangles.empty())
      throw Refusal(points_ ? "has no triangles, only points or lines; export it with faces"
                            : "has no triangles in its scene; export it with a mesh");
    if (points_) note("its points and lines are left out");
    return std::move(mesh_);
  }

 private:
  static size_t bytes_of(const GltfFiles* files) {
    size_t bytes = 0;
    if (files)
      for (const auto& [uri, file] : *files) bytes += file ? file.value().size() : 0;
    return bytes;
  }

  void note(const std::string& what) {
    if (notes_ && noted_.insert(what).second) notes_->push_back(sanitize_message(what));
  }

  const Json& item(const char* key, uint64_t index) const {
    const Json& all = list(json_, key);
    if (index >= all.size() || !all[index].is_object())
      throw Refusal(std::string("number ") + std::to_string(index) + " of '" + key +
                    "' is referenced but missing; export it again");
    return all[index];
  }

  void check_version() {
    const std::string version = text_of(member(member(json_, "asset"), "version"));
    if (!version.empty() && !version.starts_with("2."))
      throw Refusal("has version " + in_quotes(version) + " of glTF; export it as version 2.0");
  }

  // True if triangles are read correctly without regard to the extension.
  static bool is_harmless(std::string_view extension) {
    for (const std::string_view prefix :
         {"KHR_materials_", "EXT_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_",
          "KHR_lights_", "EXT_lights_", "KHR_xmp", "FB_ngon_encoding", "KHR_mesh_quantization"})
      if (extension.starts_with(prefix)) return true;
    return false;
  }
  static bool is_meshopt(std::string_view extension) {
    return extension == "EXT_meshopt_compression" || extension == "KHR_meshopt_compression";
  }
  [[noreturn]] static void refuse(const std::string& extension) {
    if (extension == kDraco || is_meshopt(extension))
      throw Refusal("its mesh is compressed with " + in_quotes(extension) +
                    ", which Kibori does not read; export it without mesh compression");
    throw Refusal("needs the extension " + in_quotes(extension) +
                  ", which Kibori does not read; export it without that extension");
  }
  void check_extensions() {
    std::set<std::string> required;
    for (const Json& one : list(json_, "extensionsRequired")) required.insert(text_of(one));
    for (const std::string& one : required)
      if (!is_harmless(one)) refuse(one);
    for (const Json& one : list(json_, "extensionsUsed"))
      if (const std::string used = text_of(one);
          !is_harmless(used) && used != kDraco && !is_meshopt(used))
        note("its extension " + in_quotes(used) + " is ignored");
  }

  // The nodes of the default scene. If the file has no scenes: the nodes without a parent.
  std::vector<uint64_t> find_roots() {
    const Json& scenes = list(json_, "scenes");
    std::vector<uint64_t> roots;
    if (scenes.empty()) {
      const Json& nodes = list(json_, "nodes");
      std::vector<bool> is_child(nodes.size());
      for (const Json& node : nodes)
        for (const Json& child : list(node, "children"))
          if (const auto index = whole(child); index && *index < nodes.size())
            is_child[*index] = true;
      for (size_t i = 0; i < nodes.size(); i++)
        if (!is_child[i]) roots.push_back(i);
      return roots;
    }
    const uint64_t which = whole_member(json_, "scene", "the file", 0);
    if (scenes.size() > 1)
      note("only scene " + std::to_string(which) + " of its " + std::to_string(scenes.size()) +
           " scenes is read");
    for (const Json& root : list(item("scenes", which), "nodes")) {
      const std::optional<uint64_t> index = whole(root);
      if (!index) throw Refusal("its scene has a node that is not a number; export it again");
      roots.push_back(*index);
    }
    return roots;
  }

  static Eigen::Matrix4d transform_of(const Json& node, const std::string& where) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    if (const Json& given = member(node, "matrix"); !given.is_null()) {
      const std::vector<double> m = numbers_of(given, 16, where + ": 'matrix'");
      return Eigen::Map<const Eigen::Matrix4d>(m.data());  // by columns, as in the file
    }
    const auto part = [&](const char* key, size_t count, auto&& use) {
      if (const Json& given = member(node, key); !given.is_null())
        use(numbers_of(given, count, where + ": '" + key + "'"));
    };
    part("rotation", 4, [&](const std::vector<double>& q) {
      const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
      if (!(rotation.norm() > 0)) throw Refusal(where + ": 'rotation' is zero; export it again");
      matrix.topLeftCorner<3, 3>() = rotation.normalized().toRotationMatrix();
    });
    part("scale", 3, [&](const std::vector<double>& s) {
      for (int i = 0; i < 3; i++) matrix.col(i).head<3>() *= s[static_cast<size_t>(i)];
    });
    part("translation", 3,
         [&](const std::vector<double>& t) { matrix.col(3).head<3>() = Vec3(t[0], t[1], t[2]); });
    return matrix;
  }

  void note_node(const Json& node) {
    if (!member(node, "skin").is_null())
      note("its skeletons are ignored: meshes keep their rest pose");
    if (!member(member(node, "extensions"), "EXT_mesh_gpu_instancing").is_null())
      note("the copies of EXT_mesh_gpu_instancing are ignored: each mesh is read once");
    note_weights(node);
  }
  void note_weights(const Json& holder) {
    for (const Json& weight : list(holder, "weights"))
      if (weight.is_number() && weight.get<double>() != 0)
        note("its morph targets are ignored: meshes keep their first shape");
  }

  void add_mesh(uint64_t index, const Eigen::Matrix4d& to_world) {
    const Json& mesh = item("meshes", index);
    note_weights(mesh);
    size_t number = 0;
    for (const Json& primitive : list(mesh, "primitives"))
      add_primitive(primitive, to_world,
                    "mesh " + std::to_string(index) + ", primitive " + std::to_string(number++));
  }

  void add_primitive(const Json& primitive, const Eigen::Matrix4d& to_world,
                     const std::string& where) {
    enum : uint64_t { kTriangles = 4, kStrip = 5, kFan = 6 };
    const uint64_t mode = whole_member(primitive, "mode", where, kTriangles);
    if (mode < kTriangles) points_ = true;
    if (mode < kTriangles) return;
    if (mode > kFan)
      throw Refusal(where + " has mode " + std::to_string(mode) + ", which glTF does not know");
    const Json& attributes = member(primitive, "attributes");
    if (member(attributes, "POSITION").is_null()) return;  // no geometry, according to glTF
    const bool packed = !member(member(primitive, "extensions"), kDraco.data()).is_null();
    const Accessor points = accessor(whole_member(attributes, "POSITION", where), 3, packed);
    std::vector<uint32_t> corners;
    if (member(primitive, "indices").is_null()) {
      for (size_t i = 0; i < points.count; i++) corners.push_back(static_cast<uint32_t>(i));
    } else {
      const Accessor indices = accessor(whole_member(primitive, "indices", where), 1, packed);
      corners.reserve(indices.count);
      for (size_t i = 0; i < indices.count; i++) {
        const double index = indices.at(i, 0);
        if (!(index >= 0 && index < static_cast<double>(points.count)) ||
            index != std::floor(index))
          throw Refusal(where + ": index " + std::to_string(i) + " refers to vertex " +
                        std::to_string(static_cast<int64_t>(index)) +
                        ", but the number of vertices is " + std::to_string(points.count) +
                        "; export it again");
        corners.push_back(static_cast<uint32_t>(index));
      }
    }
    if (mode == kTriangles && corners.size() % 3 != 0)
      throw Refusal(where + " has " + std::to_string(corners.size()) +
                    " corners, which is not a multiple of three; export it again");
    if (corners.size() < 3) return;
    const size_t triangles = mode == kTriangles ? corners.size() / 3 : corners.size() - 2;
    if (mesh_.triangles.size() + triangles > kMaxImportTriangles)
      throw Refusal("has more than 100 million triangles; export fewer");
    const std::vector<uint32_t> placed = add_vertices(points, corners, to_world, where);
    const bool mirrored = to_world.topLeftCorner<3, 3>().determinant() < 0;
    const auto add = [&](size_t a, size_t b, size_t c) {
      // In a strip or a fan, a degenerate triangle only connects to the next one.
      if (mode != kTriangles &&
          (corners[a] == corners[b] || corners[b] == corners[c] || corners[c] == corners[a]))
        return;
      if (mirrored) std::swap(b, c);
      mesh_.triangles.push_back({placed[a], placed[b], placed[c]});
    };
    for (size_t i = 0; i < triangles; i++)
      if (mode == kTriangles)
        add(3 * i, 3 * i + 1, 3 * i + 2);
      else if (mode == kStrip)
        add(i, i + 1 + i % 2, i + 2 - i % 2);
      else
        add(i + 1, i + 2, 0);
  }

  // Appends the vertices that `corners` refer to. Returns the new index of each corner. Other
  // vertices are left out: in the files of many programs, all parts share one list of vertices, and
  // each part uses a few of them.
  std::vector<uint32_t> add_vertices(const Accessor& points, const std::vector<uint32_t>& corners,
                                     const Eigen::Matrix4d& to_world, const std::string& where) {
    std::vector<uint32_t> used = corners;
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    if (mesh_.vertices.size() + used.size() > 3 * kMaxImportTriangles)
      throw Refusal("has more than 300 million vertices; export fewer");
    const size_t first = mesh_.vertices.size();
    for (const uint32_t i : used) {
      const Eigen::Vector4d at(points.at(i, 0), points.at(i, 1), points.at(i, 2), 1);
      const Eigen::Vector4d p = to_world * at;
      // From metres with y up to mm with z up.
      mesh_.vertices.push_back(kMmPerMetre * Vec3(p.x(), -p.z(), p.y()));
      if (!mesh_.vertices.back().allFinite())
        throw Refusal(where + ": vertex " + std::to_string(i) +
                      " has a coordinate that is not a finite number; export it again");
    }
    std::vector<uint32_t> placed(corners.size());
    for (size_t i = 0; i < corners.size(); i++)
      placed[i] = static_cast<uint32_t>(
          first + static_cast<size_t>(std::ranges::lower_bound(used, corners[i]) - used.begin()));
    return placed;
  }

  // The bytes of another file.
  std::string_view file_bytes(const std::string& uri, const std::string& where) const {
    if (!files_)
      throw Refusal(where + " is in another file, " + in_quotes(uri) + "; save it as one GLB file");
    const auto found = files_->find(uri);
    if (found == files_->end()) throw Refusal(where + " has no data; export it again");
    if (!found->second) throw Refusal(where + " " + found->second.error());
    return {found->second.value().data(), found->second.value().size()};
  }

  // The bytes of a buffer. Those of data URIs are decoded once.
  std::string_view buffer(uint64_t index) {
    const Json& about = item("buffers", index);
    const std::string where = "buffer " + std::to_string(index);
    const Json& uri = member(about, "uri");
    if (!uri.is_string()) {
      if (index == 0 && container_.bytes) return *container_.bytes;
      for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        if (!member(member(about, "extensions"), extension).is_null()) refuse(extension);
      throw Refusal(where + " has no data; export it again");
    }
    const std::string& text = uri.get_ref<const std::string&>();
    constexpr std::string_view kBase64 = ";base64,";
    const size_t comma = text.find(kBase64);
    if (!text.starts_with(kDataUri)) return file_bytes(text, where);
    if (comma == std::string::npos)
      throw Refusal(where + " has a data URI that is not base64; export it again");
    if (decoded_.size() <= index) decoded_.resize(index + 1);
    if (!decoded_[index])
      decoded_[index] = decode_base64(std::string_view(text).substr(comma + kBase64.size()), where);
    return *decoded_[index];
  }

  struct View {
    std::string_view bytes;
    size_t stride;  // 0: not given
  };
  View view(uint64_t index) {
    const Json& about = item("bufferViews", index);
    const std::string where = "bufferView " + std::to_string(index);
    const std::string_view all = buffer(whole_member(about, "buffer", where));
    const uint64_t from = whole_member(about, "byteOffset", where, 0),
                   length = whole_member(about, "byteLength", where);
    if (from > all.size() || length > all.size() - from)
      throw Refusal(where + " ends at byte " + std::to_string(from + length) +
                    ", but its buffer has " + std::to_string(all.size()) + "; export it again");
    return {all.substr(from, length), whole_member(about, "byteStride", where, 0)};
  }

  // Pointer to the first of `count` elements in a view. Throws if they exceed the view.
  const char* elements(const View& view, uint64_t offset, uint64_t count, size_t size,
                       size_t stride, const std::string& where) const {
    if (count == 0) return view.bytes.data();
    if (offset > view.bytes.size() || size > view.bytes.size() - offset ||
        count - 1 > (view.bytes.size() - offset - size) / stride)
      throw Refusal(where + " has " + std::to_string(count) + " elements, but its bufferView has " +
                    std::to_string(view.bytes.size()) + " bytes; export it again");
    return view.bytes.data() + offset;
  }

  static ComponentType component_of(const Json& about, const std::string& where) {
    const uint64_t type = whole_member(about, "componentType", where);
    for (const ComponentType known :
         {ComponentType::int8, ComponentType::uint8, ComponentType::int16, ComponentType::uint16,
          ComponentType::uint32, ComponentType::float32})
      if (type == static_cast<uint64_t>(known)) return known;
    throw Refusal(where + " has numbers of type " + std::to_string(type) +
                  ", which glTF does not know; export it again");
  }

  // `packed`: the primitive also has compressed data (Draco). Then an accessor without a bufferView
  // is an error, because its elements are only in the compressed data.
  Accessor accessor(uint64_t index, size_t components, bool packed) {
    const Json& about = item("accessors", index);
    const std::string where = "accessor " + std::to_string(index);
    if (text_of(member(about, "type")) != (components == 3 ? "VEC3" : "SCALAR"))
      throw Refusal(where + " has type " + in_quotes(text_of(member(about, "type"))) +
                    " instead of " + (components == 3 ? "VEC3" : "SCALAR") + "; export it again");
    Accessor made;
    made.components = components;
    made.type = component_of(about, where);
    if (components == 1 && made.type == ComponentType::float32)
      throw Refusal(where + " has indices that are not whole numbers; export it again");
    made.normalized = member(about, "normalized") == Json(true);
    const uint64_t count = whole_member(about, "count", where);
    // An accessor without a bufferView consists of zeros. It needs no bytes, so only this limit
    // keeps a malicious count small. Valid files do not reach the limit.
    if (count > size_)
      throw Refusal(where + " has " + std::to_string(count) + " elements, but the file has " +
                    std::to_string(size_) + " bytes; export it again");
    made.count = count;
    const size_t size = component_bytes(made.type) * components;
    if (member(about, "bufferView").is_null()) {
      if (packed) refuse(std::string(kDraco));
    } else {
      const View bytes = view(whole_member(about, "bufferView", where));
      made.stride = bytes.stride ? bytes.stride : size;
      if (made.stride < size)
        throw Refusal(where + " has elements of " + std::to_string(size) + " bytes every " +
                      std::to_string(made.stride) + " bytes; export it again");
      made.data = elements(bytes, whole_member(about, "byteOffset", where, 0), count, size,
                           made.stride, where);
    }
    if (const Json& sparse = member(about, "sparse"); !sparse.is_null())
      replace(made, sparse, size, where + ", sparse");
    return made;
  }
  void replace(Accessor& made, const Json& sparse, size_t size, const std::string& where) {
    const Json &at = member(sparse, "indices"), &values = member(sparse, "values");
    const uint64_t count = whole_member(sparse, "count", where);
    const ComponentType type = component_of(at, where);
    if (type == ComponentType::float32)
      throw Refusal(where + " has indices that are not whole numbers; export it again");
    Accessor indices;
    indices.type = type;
    indices.stride = component_bytes(type);
    indices.data = elements(view(whole_member(at, "bufferView", where)),
                            whole_member(at, "byteOffset", where, 0), count, indices.stride,
                            indices.stride, where);
    made.replacements =
        elements(view(whole_member(values, "bufferView", where)),
                 whole_member(values, "byteOffset", where, 0), count, size, size, where);
    for (size_t i = 0; i < count; i++) {
      const double index = indices.at(i, 0);
      if (!(index >= 0 && index < static_cast<double>(made.count)) ||
          (i > 0 && !(index > static_cast<double>(made.replaced.back()))))
        throw Refusal(where + " refers to elements out of range or out of order; export it again");
      made.replaced.push_back(static_cast<uint64_t>(index));
    }
  }

  const Container container_;
  const Json json_;
  const GltfFiles* files_;
  const size_t size_;  // bytes of the file and of the files that it names
  std::vector<std::string>* notes_;
  std::set<std::string> noted_;
  std::vector<std::optional<std::string>> decoded_;  // data URIs, by the index of the buffer
  TriangleMesh mesh_;
  bool points_ = false;
};

}  // namespace

GltfFiles read_gltf_files(std::string_view bytes, const std::filesystem::path& path) {
  GltfFiles files;
  try {
    const Json json = parse_object(open_container(bytes).json);
    for (const Json& buffer : list(json, "buffers"))
      if (const Json& uri = member(buffer, "uri"); uri.is_string())
        if (const std::string text = text_of(uri);
            !text.starts_with(kDataUri) && !files.contains(text))
          files.emplace(text, read_named(text, path));
  } catch (const Refusal&) {
    // parse_glb finds and reports the same error.
  }
  return files;
}

Result<TriangleMesh> parse_glb(std::string_view bytes, const std::string& name,
                               std::vector<std::string>* notes, const GltfFiles* files) {
  try {
    std::vector<std::string> found_notes;
    TriangleMesh mesh = GlbParser(bytes, &found_notes, files).run();
    for (const std::string& note : found_notes)
      if (notes) notes->push_back(name + ": " + note);
    return mesh;
  } catch (const Refusal& refusal) {
    return Error{sanitize_message(name + ": " + refusal.what())};
  }
}

}  // namespace kibori
