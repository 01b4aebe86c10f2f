// SPDX-License-Identifier: MIT
#include <kibori/formats/surface_file.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <kibori/formats/endings.h>
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
      return Error{"more triangles than an STL file can count"};
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

// Formats in which all vertices come before the first triangle: triangles wait in a spool.
class IndexedWriter : public SurfaceWriter {
 public:
  IndexedWriter(NewFile& file, Spool& triangles, std::span<const Rgb> colors)
      : file_(file), triangles_(triangles), colors_(colors) {}

  void put(const SurfacePart& part) override {
    for (const SurfaceVertex& v : part.vertices.first(part.own))
      put_vertex(v, color_of(v, colors_));
    vertex_count_ += part.own;
    for (const SurfaceTriangle& t : part.triangles) {
      const SurfaceTriangle numbers{part.number[t[0]], part.number[t[1]], part.number[t[2]]};
      triangles_.write(numbers.data(), sizeof numbers);
    }
    triangle_count_ += part.triangles.size();
  }

 protected:
  virtual void put_vertex(const SurfaceVertex& vertex, const Rgb& color) = 0;

  // Calls f(triangle) for all of them.
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
    if (!read) return Error{"no space for temporary data beside the file"};
    return Ok{};
  }

  NewFile& file_;
  Spool& triangles_;
  std::span<const Rgb> colors_;
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
  // Always of the same length: the counts are known at the end.
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

class ObjWriter final : public IndexedWriter {
 public:
  ObjWriter(NewFile& file, Spool& spool, std::span<const Rgb> colors)
      : IndexedWriter(file, spool, colors) {
    file_.write("# Kibori, mm, Z up\n");
  }
  Status finish() override {
    return for_triangles([&](const SurfaceTriangle& t) {
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

// Binary glTF 2.0: metres and Y up, so (x, y, z) mm becomes (x, z, -y) / 1000.
class GlbWriter final : public IndexedWriter {
 public:
  GlbWriter(NewFile& file, Spool& spool, std::span<const Rgb> colors)
      : IndexedWriter(file, spool, colors) {
    const std::string nothing(kBinary, ' ');
    file_.write(nothing);
    least_.fill(std::numeric_limits<float>::infinity());
    most_.fill(-std::numeric_limits<float>::infinity());
  }
  Status finish() override {
    const uint64_t vertex_bytes = vertex_count_ * kStride,
                   index_bytes = triangle_count_ * sizeof(SurfaceTriangle),
                   binary = vertex_bytes + index_bytes;
    if (kBinary + binary > std::numeric_limits<uint32_t>::max())
      return Error{
          "a GLB file can hold 4 GB, and this surface takes more; use a coarser pitch or a "
          "tolerance"};
    char json[kJson + 1];
    const auto real = [](float x) { return static_cast<double>(x); };
    const int length = std::snprintf(
        json, sizeof json,
        R"({"asset":{"version":"2.0","generator":"Kibori"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"COLOR_0":2},"indices":3,"material":0}]}],)"
        R"("materials":[{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.8}}],)"
        R"("buffers":[{"byteLength":%llu}],"bufferViews":[{"buffer":0,"byteLength":%llu,"byteStride":%u,"target":34962},)"
        R"({"buffer":0,"byteOffset":%llu,"byteLength":%llu,"target":34963}],"accessors":[)"
        R"({"bufferView":0,"componentType":5126,"count":%llu,"type":"VEC3","min":[%.9g,%.9g,%.9g],"max":[%.9g,%.9g,%.9g]},)"
        R"({"bufferView":0,"byteOffset":12,"componentType":5126,"count":%llu,"type":"VEC3"},)"
        R"({"bufferView":0,"byteOffset":24,"componentType":5121,"normalized":true,"count":%llu,"type":"VEC4"},)"
        R"({"bufferView":1,"componentType":5125,"count":%llu,"type":"SCALAR"}]})",
        number(binary), number(vertex_bytes), static_cast<unsigned>(kStride), number(vertex_bytes),
        number(index_bytes), number(vertex_count_), real(least_[0]), real(least_[1]),
        real(least_[2]), real(most_[0]), real(most_[1]), real(most_[2]), number(vertex_count_),
        number(vertex_count_), number(3 * triangle_count_));
    std::memset(json + length, ' ', kJson - static_cast<size_t>(length));
    const uint32_t head[5] = {0x46546c67, 2, static_cast<uint32_t>(kBinary + binary), kJson,
                              0x4e4f534a};
    const uint32_t chunk[2] = {static_cast<uint32_t>(binary), 0x004e4942};
    file_.overwrite(0, head, sizeof head);
    file_.overwrite(sizeof head, json, kJson);
    file_.overwrite(sizeof head + kJson, chunk, sizeof chunk);
    return for_triangles([&](const SurfaceTriangle& t) { file_.write(t.data(), sizeof t); });
  }

 private:
  // Two heads and a JSON chunk of fixed size, padded with spaces, as counts are known at the end.
  static constexpr uint32_t kJson = 1400, kBinary = 12 + 8 + kJson + 8;
  static constexpr size_t kStride = 28;

  static unsigned long long number(uint64_t n) { return n; }

  void put_vertex(const SurfaceVertex& v, const Rgb& color) override {
    const auto metres = [](float mm) { return static_cast<float>(static_cast<double>(mm) / 1000); };
    const std::array<float, 3> at{metres(v.position[0]), metres(v.position[2]),
                                  metres(-v.position[1])};
    const std::array<float, 3> normal{v.normal[0], v.normal[2], -v.normal[1]};
    char bytes[kStride];
    std::memcpy(bytes, at.data(), 12);
    std::memcpy(bytes + 12, normal.data(), 12);
    for (size_t i = 0; i < 3; i++) {
      bytes[24 + i] = static_cast<char>(linear(color[i]));
      least_[i] = std::min(least_[i], at[i]);
      most_[i] = std::max(most_[i], at[i]);
    }
    bytes[27] = static_cast<char>(255);
    file_.write(bytes, sizeof bytes);
  }
  // glTF's vertex colours are linear, ours sRGB.
  static uint8_t linear(uint8_t srgb) {
    const double x = srgb / 255.0,
                 y = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    return static_cast<uint8_t>(std::lround(255 * y));
  }

  std::array<float, 3> least_, most_;
};

Status write_pieces(SurfaceWriter& writer, const SurfaceSource& surface) {
  bool any = false;
  surface([&](const SurfacePart& part) {
    any |= !part.triangles.empty();
    writer.put(part);
  });
  if (!any)
    return Error{"there is no surface to write: no material, or none as thick as the pitch"};
  return writer.finish();
}

}  // namespace

Rgb color_of(const SurfaceVertex& v, std::span<const Rgb> colors) {
  if (v.paint)
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
  if (Status known = check_surface_ending(path); !known) return known;
  if (Status can = check_writable(path); !can) return can;
  const std::string ending = ending_of(path);
  NewFile file(path);
  Spool spool(path), more(path);
  std::unique_ptr<SurfaceWriter> writer;
  if (ending == ".stl") writer = std::make_unique<StlWriter>(file);
  if (ending == ".ply") writer = std::make_unique<PlyWriter>(file, spool, material_colors);
  if (ending == ".obj") writer = std::make_unique<ObjWriter>(file, spool, material_colors);
  if (ending == ".glb") writer = std::make_unique<GlbWriter>(file, spool, material_colors);
  if (ending == ".3mf") writer = threemf_writer(file, spool, more, material_colors);
  if (const Status done = write_pieces(*writer, surface); !done)
    return Error{path.string() + ": " + done.error()};
  return file.commit();
}

}  // namespace kibori
