// SPDX-License-Identifier: MIT
#include <kibori/formats/surface_file.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <kibori/base/file.h>

namespace kibori {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they are in memory");

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

std::array<uint8_t, 3> color_of(const SurfaceVertex& v, std::span<const std::array<uint8_t, 3>> colors) {
  if (v.paint)
    return {static_cast<uint8_t>(v.paint), static_cast<uint8_t>(v.paint >> 8),
            static_cast<uint8_t>(v.paint >> 16)};
  return v.material < colors.size() ? colors[v.material] : std::array<uint8_t, 3>{255, 255, 255};
}

void write_stl(NewFile& file, const Surface& surface) {
  char header[80] = "Kibori, mm";
  file.write(header, sizeof header);
  const auto count = static_cast<uint32_t>(surface.triangles.size());
  file.write(&count, sizeof count);
  for (const SurfaceTriangle& t : surface.triangles) {
    const auto &a = surface.vertices[t[0]].position, &b = surface.vertices[t[1]].position,
               &c = surface.vertices[t[2]].position;
    double u[3], v[3];
    for (size_t i = 0; i < 3; i++) {
      u[i] = static_cast<double>(b[i]) - static_cast<double>(a[i]);
      v[i] = static_cast<double>(c[i]) - static_cast<double>(a[i]);
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    float facet[12];
    for (size_t i = 0; i < 3; i++) {
      facet[i] = static_cast<float>(length > 0 ? n[i] / length : 0);
      facet[3 + i] = a[i];
      facet[6 + i] = b[i];
      facet[9 + i] = c[i];
    }
    char bytes[50] = {};
    std::memcpy(bytes, facet, sizeof facet);
    file.write(bytes, sizeof bytes);
  }
}

void write_ply(NewFile& file, const Surface& surface, std::span<const std::array<uint8_t, 3>> colors) {
  file.write(
      "ply\nformat binary_little_endian 1.0\ncomment Kibori, mm, Z up\nelement vertex " +
      std::to_string(surface.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
      "property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
      std::to_string(surface.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n");
  for (const SurfaceVertex& v : surface.vertices) {
    char bytes[27];
    std::memcpy(bytes, v.position.data(), 12);
    std::memcpy(bytes + 12, v.normal.data(), 12);
    const auto color = color_of(v, colors);
    std::memcpy(bytes + 24, color.data(), 3);
    file.write(bytes, sizeof bytes);
  }
  for (const SurfaceTriangle& t : surface.triangles) {
    char bytes[13] = {3};
    std::memcpy(bytes + 1, t.data(), 12);
    file.write(bytes, sizeof bytes);
  }
}

void write_obj(NewFile& file, const Surface& surface, std::span<const std::array<uint8_t, 3>> colors) {
  file.write("# Kibori, mm, Z up\n");
  char line[200];
  const auto put = [&](int length) { file.write(line, static_cast<size_t>(length)); };
  const auto real = [](float x) { return static_cast<double>(x); };
  for (const SurfaceVertex& v : surface.vertices) {
    const auto c = color_of(v, colors);
    put(std::snprintf(line, sizeof line, "v %.9g %.9g %.9g %.4g %.4g %.4g\n", real(v.position[0]),
                      real(v.position[1]), real(v.position[2]), c[0] / 255.0, c[1] / 255.0, c[2] / 255.0));
  }
  for (const SurfaceVertex& v : surface.vertices)
    put(std::snprintf(line, sizeof line, "vn %.5g %.5g %.5g\n", real(v.normal[0]), real(v.normal[1]),
                      real(v.normal[2])));
  for (const SurfaceTriangle& t : surface.triangles)
    put(std::snprintf(line, sizeof line, "f %u//%u %u//%u %u//%u\n", t[0] + 1, t[0] + 1, t[1] + 1, t[1] + 1,
                      t[2] + 1, t[2] + 1));
}

}  // namespace

Status check_surface_ending(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  if (ending == ".stl" || ending == ".ply" || ending == ".obj") return Ok{};
  return Error{path.string() + ": a surface can be written as .stl, .ply or .obj"};
}

Status write_surface(const std::filesystem::path& path, const Surface& surface,
                     std::span<const std::array<uint8_t, 3>> material_colors) {
  if (const Status known = check_surface_ending(path); !known) return known;
  const std::string ending = ending_of(path);
  if (surface.triangles.size() > std::numeric_limits<uint32_t>::max())
    return Error{path.string() + ": more triangles than a file can count; use a coarser pitch"};
  NewFile file(path);
  if (ending == ".stl") write_stl(file, surface);
  if (ending == ".ply") write_ply(file, surface, material_colors);
  if (ending == ".obj") write_obj(file, surface, material_colors);
  return file.commit();
}

}  // namespace kibori
