// SPDX-License-Identifier: MIT
#include <kibori/formats/surface_file.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <kibori/base/check.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/surface_writer.h>

namespace kibori {
namespace {

static_assert(std::endian::native == std::endian::little,
              "binary files are written as they are in memory");

class StlWriter final : public SurfaceWriter {
 public:
  explicit StlWriter(NewFile& file) : file_(file) {
    const char header[84] = "Kibori, mm";
    file_.write(header, sizeof header);
  }

  void put(const SurfacePart& part) override {
    for (size_t done = 0; done < part.triangles.size();) {
      constexpr size_t kFacet = 50, kMany = 256;
      char bytes[kFacet * kMany];
      const size_t count = std::min(kMany, part.triangles.size() - done);
      for (size_t i = 0; i < count; i++)
        put_facet(part, part.triangles[done + i], bytes + kFacet * i);
      file_.write(bytes, kFacet * count);
      done += count;
    }
    count_ += part.triangles.size();
  }

  Status finish() override {
    if (count_ > std::numeric_limits<uint32_t>::max())
      return Error{"has more triangles than the STL format allows"};
    const auto count = static_cast<uint32_t>(count_);
    file_.overwrite(80, &count, sizeof count);
    return Ok{};
  }

 private:
  static void put_facet(const SurfacePart& part, const SurfaceTriangle& t, char* bytes) {
    const auto &a = part.vertices[t[0]].position, &b = part.vertices[t[1]].position,
               &c = part.vertices[t[2]].position;
    double u[3], v[3];
    for (size_t i = 0; i < 3; i++) {
      u[i] = static_cast<double>(b[i]) - static_cast<double>(a[i]);
      v[i] = static_cast<double>(c[i]) - static_cast<double>(a[i]);
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double scale = length > 0 ? 1 / length : 0;
    float facet[12];
    for (size_t i = 0; i < 3; i++) {
      facet[i] = static_cast<float>(n[i] * scale);
      facet[3 + i] = a[i];
      facet[6 + i] = b[i];
      facet[9 + i] = c[i];
    }
    std::memcpy(bytes, facet, sizeof facet);
    bytes[48] = bytes[49] = 0;
  }

  NewFile& file_;
  uint64_t count_ = 0;
};

// Base of formats in which all vertices precede the first triangle. A spool holds the triangles
// until then.
class IndexedWriter : public SurfaceWriter {
 public:
  IndexedWriter(NewFile& file, Spool& triangles, std::span<const Rgb> colors)
      : file_(file), triangles_(triangles), colors_(colors) {}

  void begin(const SurfaceObject& object) override {
    objects_.push_back({object.name, object.pose, vertex_count_, 0, triangle_count_, 0});
  }
  void put(const SurfacePart& part) override {
    Object& object = objects_.back();
    for (const SurfaceVertex& v : part.vertices.first(part.own))
      put_vertex(v, color_of(v, colors_));
    const auto first = static_cast<uint32_t>(object.first_vertex);
    for (const SurfaceTriangle& t : part.triangles) {
      const SurfaceTriangle numbers{part.number[t[0]] + first, part.number[t[1]] + first,
                                    part.number[t[2]] + first};
      triangles_.write(numbers.data(), sizeof numbers);
    }
    vertex_count_ += part.own;
    triangle_count_ += part.triangles.size();
    object.vertices += part.own;
    object.triangles += part.triangles.size();
  }

 protected:
  struct Object {
    std::string name;
    Pose pose;
    uint64_t first_vertex, vertices, first_triangle, triangles;
  };
  virtual void put_vertex(const SurfaceVertex& vertex, const Rgb& color) = 0;

  // Calls f(triangle) for all triangles.
  template <class F>
  Status for_triangles(F&& f) {
    const bool read =
        triangles_.read_back(sizeof(SurfaceTriangle), [&](const char* data, size_t bytes) {
          for (size_t at = 0; at < bytes; at += sizeof(SurfaceTriangle)) {
            SurfaceTriangle t;
            std::memcpy(t.data(), data + at, sizeof t);
            f(t);
          }
        });
    if (!read) return Error{"no space for temporary data next to the file"};
    return Ok{};
  }

  NewFile& file_;
  Spool& triangles_;
  std::span<const Rgb> colors_;
  std::vector<Object> objects_;
  uint64_t vertex_count_ = 0, triangle_count_ = 0;
};

class PlyWriter final : public IndexedWriter {
 public:
  PlyWriter(NewFile& file, Spool& spool, std::span<const Rgb> colors)
      : IndexedWriter(file, spool, colors) {
    file_.write(header());
  }
  Status finish() override {
    const std::string text = header();
    file_.overwrite(0, text.data(), text.size());
    return for_triangles([&](const SurfaceTriangle& t) {
      char bytes[13] = {3};
      std::memcpy(bytes + 1, t.data(), 12);
      file_.write(bytes, sizeof bytes);
    });
  }

 private:
  // Has a fixed length, because the counts are known only at the end.
  std::string header() const {
    char text[500];
    std::snprintf(
        text, sizeof text,
        "ply\nformat binary_little_endian 1.0\ncomment Kibori, mm, Z up\nelement vertex %-10llu\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face %-10llu\nproperty list uchar uint vertex_indices\nend_header\n",
        static_cast<unsigned long long>(vertex_count_),
        static_cast<unsigned long long>(triangle_count_));
    return text;
  }
  void put_vertex(const SurfaceVertex& v, const Rgb& color) override {
    char bytes[27];
    std::memcpy(bytes, v.position.data(), 12);
    std::memcpy(bytes + 12, v.normal.data(), 12);
    std::memcpy(bytes + 24, color.data(), 3);
    file_.write(bytes, sizeof bytes);
  }
};

// Many readers end a name at its first space.
std::string one_word(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return name;
}

class ObjWriter final : public IndexedWriter {
 public:
  ObjWriter(NewFile& file, Spool& spool, std::span<const Rgb> colors)
      : IndexedWriter(file, spool, colors) {
    file_.write("# Kibori, mm, Z up\n");
  }
  Status finish() override {
    size_t next = 0;
    uint64_t done = 0;
    return for_triangles([&](const SurfaceTriangle& t) {
      // An object without triangles gets no line.
      for (; next < objects_.size() && done >= objects_[next].first_triangle; next++)
        if (!objects_[next].name.empty() && objects_[next].triangles > 0)
          file_.write("o " + one_word(objects_[next].name) + "\n");
      done++;
      char line[100];
      const int length = std::snprintf(line, sizeof line, "f %u//%u %u//%u %u//%u\n", t[0] + 1,
                                       t[0] + 1, t[1] + 1, t[1] + 1, t[2] + 1, t[2] + 1);
      file_.write(line, static_cast<size_t>(length));
    });
  }

 private:
  void put_vertex(const SurfaceVertex& v, const Rgb& c) override {
    char lines[300];
    const auto real = [](float x) { return static_cast<double>(x); };
    const int length = std::snprintf(
        lines, sizeof lines, "v %.9g %.9g %.9g %.4g %.4g %.4g\nvn %.5g %.5g %.5g\n",
        real(v.position[0]), real(v.position[1]), real(v.position[2]), c[0] / 255.0, c[1] / 255.0,
        c[2] / 255.0, real(v.normal[0]), real(v.normal[1]), real(v.normal[2]));
    file_.write(lines, static_cast<size_t>(length));
  }
};

// Binary glTF 2.0: metres and Y up, so (x, y, z) mm becomes (x, z, -y) / 1000. Each surface becomes
// one mesh.
class GlbWriter final : public IndexedWriter {
 public:
  GlbWriter(NewFile& file, Spool& spool, std::span<const Rgb> colors,
            std::span<const SurfaceObject> objects)
      : IndexedWriter(file, spool, colors), json_bytes_(kJson) {
    for (const SurfaceObject& object : objects)
      json_bytes_ += kObjectJson + static_cast<uint32_t>(OrderedJson(object.name).dump().size());
    json_bytes_ += (4 - json_bytes_ % 4) % 4;
    file_.write(std::string(before_binary(), ' '));
  }
  bool places() const override { return true; }
  void begin(const SurfaceObject& object) override {
    IndexedWriter::begin(object);
    bounds_.emplace_back();
  }
  Status finish() override {
    const uint64_t vertex_bytes = vertex_count_ * kStride,
                   binary = vertex_bytes + triangle_count_ * sizeof(SurfaceTriangle);
    if (before_binary() + binary > std::numeric_limits<uint32_t>::max())
      return Error{
          "the surface exceeds the limit of 4 GB of a GLB file; use a coarser pitch or a "
          "tolerance"};
    std::string json =
        describe(vertex_bytes).dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
    if (json.size() > json_bytes_)
      return Error{"the names exceed the size limit of a GLB file; use fewer or shorter ones"};
    json.resize(json_bytes_, ' ');
    const uint32_t head[5] = {0x46546c67, 2, static_cast<uint32_t>(before_binary() + binary),
                              json_bytes_, 0x4e4f534a};
    const uint32_t chunk[2] = {static_cast<uint32_t>(binary), 0x004e4942};
    file_.overwrite(0, head, sizeof head);
    file_.overwrite(sizeof head, json.data(), json.size());
    file_.overwrite(sizeof head + json.size(), chunk, sizeof chunk);
    // Each mesh numbers its vertices from 0.
    size_t at = 0;
    uint64_t done = 0;
    return for_triangles([&](const SurfaceTriangle& t) {
      while (done >= objects_[at].first_triangle + objects_[at].triangles) at++;
      done++;
      const auto first = static_cast<uint32_t>(objects_[at].first_vertex);
      const SurfaceTriangle own{t[0] - first, t[1] - first, t[2] - first};
      file_.write(own.data(), sizeof own);
    });
  }

 private:
  using OrderedJson = nlohmann::ordered_json;
  // The file begins with a header and the JSON. The JSON is padded with spaces to a fixed length,
  // because its counts are known only at the end. kJson is the number of bytes for the data that
  // all objects share. kObjectJson is the number of bytes per object, without its name.
  static constexpr uint32_t kJson = 500, kObjectJson = 1400;
  static constexpr size_t kStride = 28;
  struct Bounds {
    std::array<float, 3> low{kFarthest, kFarthest, kFarthest},
        high{-kFarthest, -kFarthest, -kFarthest};
  };
  static constexpr float kFarthest = std::numeric_limits<float>::infinity();

  uint64_t before_binary() const { return 12 + 8 + json_bytes_ + 8; }

  OrderedJson describe(uint64_t vertex_bytes) const {
    OrderedJson nodes = OrderedJson::array(), meshes = OrderedJson::array(),
                accessors = OrderedJson::array(), views = OrderedJson::array(),
                shown = OrderedJson::array();
    for (size_t i = 0; i < objects_.size(); i++) {
      const Object& object = objects_[i];
      if (object.triangles == 0) continue;
      const size_t view = views.size(), accessor = accessors.size();
      views.push_back({{"buffer", 0},
                       {"byteOffset", object.first_vertex * kStride},
                       {"byteLength", object.vertices * kStride},
                       {"byteStride", kStride},
                       {"target", 34962}});
      views.push_back({{"buffer", 0},
                       {"byteOffset", vertex_bytes + object.first_triangle * 12},
                       {"byteLength", object.triangles * 12},
                       {"target", 34963}});
      accessors.push_back({{"bufferView", view},
                           {"componentType", 5126},
                           {"count", object.vertices},
                           {"type", "VEC3"},
                           {"min", bounds_[i].low},
                           {"max", bounds_[i].high}});
      accessors.push_back({{"bufferView", view},
                           {"byteOffset", 12},
                           {"componentType", 5126},
                           {"count", object.vertices},
                           {"type", "VEC3"}});
      accessors.push_back({{"bufferView", view},
                           {"byteOffset", 24},
                           {"componentType", 5121},
                           {"normalized", true},
                           {"count", object.vertices},
                           {"type", "VEC4"}});
      accessors.push_back({{"bufferView", view + 1},
                           {"componentType", 5125},
                           {"count", 3 * object.triangles},
                           {"type", "SCALAR"}});
      OrderedJson primitive{
          {"attributes",
           {{"POSITION", accessor}, {"NORMAL", accessor + 1}, {"COLOR_0", accessor + 2}}},
          {"indices", accessor + 3},
          {"material", 0}};
      OrderedJson node{{"mesh", meshes.size()}};
      if (!object.name.empty()) node["name"] = object.name;
      const Vec3& tip = object.pose.tip;
      const Mat3& frame = object.pose.frame;
      if (tip != Vec3::Zero() || frame != Mat3::Identity()) {
        // glTF stores a matrix by columns. The pose maps one coordinate system to another. In both,
        // (x, y, z) becomes (x, z, -y).
        Mat3 turned;
        constexpr int kFrom[3] = {0, 2, 1};
        constexpr double kSign[3] = {1, 1, -1};
        for (int row = 0; row < 3; row++)
          for (int column = 0; column < 3; column++)
            turned(row, column) = kSign[row] * kSign[column] * frame(kFrom[row], kFrom[column]);
        OrderedJson matrix = OrderedJson::array();
        for (int column = 0; column < 3; column++) {
          for (int row = 0; row < 3; row++) matrix.push_back(turned(row, column));
          matrix.push_back(0);
        }
        for (const double x : {tip.x() / 1000, tip.z() / 1000, -tip.y() / 1000, 1.0})
          matrix.push_back(x);
        node["matrix"] = std::move(matrix);
      }
      shown.push_back(nodes.size());
      nodes.push_back(std::move(node));
      meshes.push_back({{"primitives", OrderedJson::array({std::move(primitive)})}});
    }
    return {
        {"asset", {{"version", "2.0"}, {"generator", "Kibori"}}},
        {"scene", 0},
        {"scenes", OrderedJson::array({{{"nodes", std::move(shown)}}})},
        {"nodes", std::move(nodes)},
        {"meshes", std::move(meshes)},
        {"materials", OrderedJson::array({{{"pbrMetallicRoughness",
                                            {{"metallicFactor", 0}, {"roughnessFactor", 0.8}}}}})},
        {"buffers", OrderedJson::array({{{"byteLength", vertex_bytes + triangle_count_ * 12}}})},
        {"bufferViews", std::move(views)},
        {"accessors", std::move(accessors)}};
  }

  void put_vertex(const SurfaceVertex& v, const Rgb& color) override {
    const auto metres = [](float mm) { return static_cast<float>(static_cast<double>(mm) / 1000); };
    const std::array<float, 3> at{metres(v.position[0]), metres(v.position[2]),
                                  metres(-v.position[1])};
    const std::array<float, 3> normal{v.normal[0], v.normal[2], -v.normal[1]};
    Bounds& bounds = bounds_.back();
    char bytes[kStride];
    std::memcpy(bytes, at.data(), 12);
    std::memcpy(bytes + 12, normal.data(), 12);
    for (size_t i = 0; i < 3; i++) {
      bytes[24 + i] = static_cast<char>(linear(color[i]));
      bounds.low[i] = std::min(bounds.low[i], at[i]);
      bounds.high[i] = std::max(bounds.high[i], at[i]);
    }
    bytes[27] = static_cast<char>(255);
    file_.write(bytes, sizeof bytes);
  }
  // glTF's vertex colours are linear. Kibori's are sRGB.
  static uint8_t linear(uint8_t srgb) {
    const double x = srgb / 255.0,
                 y = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    return static_cast<uint8_t>(std::lround(255 * y));
  }

  uint32_t json_bytes_;
  std::vector<Bounds> bounds_;  // per object
};

// Returns a sink that applies the pose to the vertices of each piece and passes it to `sink`.
SurfaceSink placed(const Pose& pose, const SurfaceSink& sink) {
  return [pose, sink, vertices = std::vector<SurfaceVertex>()](const SurfacePart& part) mutable {
    vertices.assign(part.vertices.begin(), part.vertices.end());
    for (SurfaceVertex& v : vertices) {
      const Vec3 at = pose.to_world(Vec3(v.position[0], v.position[1], v.position[2])),
                 out = pose.frame * Vec3(v.normal[0], v.normal[1], v.normal[2]);
      for (int i = 0; i < 3; i++) {
        v.position[static_cast<size_t>(i)] = static_cast<float>(at[i]);
        v.normal[static_cast<size_t>(i)] = static_cast<float>(out[i]);
      }
    }
    SurfacePart moved = part;
    moved.vertices = vertices;
    sink(moved);
  };
}

Status write_pieces(SurfaceWriter& writer, std::span<const SurfaceObject> objects) {
  bool any = false;
  for (const SurfaceObject& object : objects) {
    writer.begin(object);
    const SurfaceSink sink = [&](const SurfacePart& part) {
      any |= !part.triangles.empty();
      writer.put(part);
    };
    const bool at_origin = object.pose.tip == Vec3::Zero() && object.pose.frame == Mat3::Identity();
    object.surface(at_origin || writer.places() ? sink : placed(object.pose, sink));
  }
  if (!any)
    return Error{
        "there is no surface to write: there is no material, or all of it is thinner than the "
        "pitch"};
  return writer.finish();
}

}  // namespace

Rgb color_of(const SurfaceVertex& v, std::span<const Rgb> colors) {
  if (is_painted(v.paint))
    return {static_cast<uint8_t>(v.paint), static_cast<uint8_t>(v.paint >> 8),
            static_cast<uint8_t>(v.paint >> 16)};
  return v.material < colors.size() ? colors[v.material] : Rgb{255, 255, 255};
}

Status check_surface_ending(const std::filesystem::path& path) {
  if (is_one_of(kMeshesWritten, ending_of(path))) return Ok{};
  return Error{path.string() + ": a surface can be written as " +
               list_of(kMeshesWritten, ", ", " or ")};
}

Status write_surface(const std::filesystem::path& path, const SurfaceSource& surface,
                     std::span<const Rgb> material_colors) {
  const SurfaceObject one{{}, {}, surface};
  return write_objects(path, {&one, 1}, material_colors);
}

Status write_objects(const std::filesystem::path& path, std::span<const SurfaceObject> objects,
                     std::span<const Rgb> material_colors) {
  if (Status known = check_surface_ending(path); !known) return known;
  if (Status can = check_writable(path); !can) return can;
  const std::string ending = ending_of(path);
  NewFile file(path);
  Spool spool(path), more(path);
  std::unique_ptr<SurfaceWriter> writer;
  if (ending == ".stl") writer = std::make_unique<StlWriter>(file);
  if (ending == ".ply") writer = std::make_unique<PlyWriter>(file, spool, material_colors);
  if (ending == ".obj") writer = std::make_unique<ObjWriter>(file, spool, material_colors);
  if (ending == ".glb") writer = std::make_unique<GlbWriter>(file, spool, material_colors, objects);
  if (ending == ".3mf") writer = threemf_writer(file, spool, more, material_colors);
  KIBORI_CHECK(writer);  // every ending of kMeshesWritten has a writer
  if (const Status done = write_pieces(*writer, objects); !done)
    return Error{path.string() + ": " + done.error()};
  return file.commit();
}

}  // namespace kibori
