// SPDX-License-Identifier: MIT
#include <kibori/report/import_report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/base/memory.h>
#include <kibori/dexel/tile.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/volume_file.h>
#include <kibori/geometry/cluster.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/haptics/materials.h>
#include <kibori/solid/grid_solid.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

// Plausible lengths of a mesh. A smaller mesh is shorter than the width of the studio's first tool.
// A larger one is longer than a workbench.
constexpr double kMinMeantMm = 10, kMaxMeantMm = 1000;
constexpr size_t kPreviewTriangles = 30000;
constexpr int kPreviewPixels = 160;
constexpr double kPreviewNodes = 96;  // along a volume's longest side
// A search for holes in this number of triangles takes about a second and 300 MB.
constexpr size_t kMaxLookedAt = 2000000;

// Minimum share of the footprint that must touch the floor, so that the shape has a flat base.
constexpr double kFlat = 0.05;

// [mm^2]
double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles)
    area += 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                      .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                      .norm();
  return area;
}

std::string length_text(double mm) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g mm", mm);
  return text;
}

// The share of a mesh's footprint that touches the floor: triangles within a hundredth of its
// height.
double support(const TriangleMesh& mesh, const Box& box, int up) {
  const int u = (up + 1) % 3, v = (up + 2) % 3;
  const Vec3 size = box.size();
  const double floor = box.min[up] + 0.01 * size[up], footprint = size[u] * size[v];
  if (!(footprint > 0)) return 0;
  double touching = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    if (std::max({a[up], b[up], c[up]}) <= floor)
      touching += 0.5 * std::abs((b - a).cross(c - a)[up]);
  }
  return std::min(1.0, touching / footprint);
}

// The height of the centroid of a mesh's surface, as a share of the mesh's height.
double middle_height(const TriangleMesh& mesh, const Box& box, int up) {
  double area = 0, moment = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double one = (b - a).cross(c - a).norm();
    area += one;
    moment += one * ((a[up] + b[up] + c[up]) / 3 - box.min[up]);
  }
  const double height = box.size()[up];
  return area > 0 && height > 0 ? moment / (area * height) : 0.5;
}

std::vector<std::string> repairs_of(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > kMaxLookedAt)
    return {"It has too many triangles to search for holes; holes are closed during the import."};
  const Surface surface = surface_of_mesh(mesh);
  const MeshInfo info = mesh_info(surface, mesh.triangles.size() - surface.triangles.size());
  std::vector<std::string> repairs;
  const auto number = [](size_t count, const char* one, const char* many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
  };
  if (info.open_edges)
    repairs.push_back("It is open at " + number(info.open_edges, "edge", "edges") +
                      ": a hole is closed if two of the three directions agree.");
  else if (info.volume_mm3 < 0)
    repairs.push_back("Its faces point inward: they are reversed.");
  if (info.overfull_edges)
    repairs.push_back(number(info.overfull_edges, "edge has", "edges have") +
                      " more than two faces: the insides are united.");
  if (info.components > 1)
    repairs.push_back("It has " + std::to_string(info.components) +
                      " pieces: they are united where they overlap.");
  if (info.degenerate)
    repairs.push_back(number(info.degenerate, "triangle", "triangles") +
                      " without area: left out.");
  return repairs;
}

GreyMap shrunk(const GreyMap& map) {
  const int longest = std::max(map.width, map.height);
  if (longest <= kPreviewPixels) return map;
  const double step = static_cast<double>(longest) / kPreviewPixels;
  GreyMap small;
  small.width = std::max(2, static_cast<int>(map.width / step));
  small.height = std::max(2, static_cast<int>(map.height / step));
  for (int y = 0; y < small.height; y++)
    for (int x = 0; x < small.width; x++) {
      const int64_t x0 = int64_t{x} * map.width / small.width,
                    y0 = int64_t{y} * map.height / small.height;
      const int64_t x1 = std::max(x0 + 1, int64_t{x + 1} * map.width / small.width),
                    y1 = std::max(y0 + 1, int64_t{y + 1} * map.height / small.height);
      uint64_t sum = 0, count = 0;
      for (int64_t j = y0; j < std::min<int64_t>(y1, map.height); j++)
        for (int64_t i = x0; i < std::min<int64_t>(x1, map.width); i++, count++)
          sum += map.pixels[static_cast<size_t>(j * map.width + i)];
      small.pixels.push_back(static_cast<uint16_t>(count ? sum / count : 0));
    }
  return small;
}

class Bytes32 {
 public:
  void put(uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes_.push_back(static_cast<uint8_t>(value >> shift));
  }
  void put(double value) {
    const auto single = static_cast<float>(value);
    uint32_t bits = 0;
    std::memcpy(&bits, &single, sizeof bits);
    put(bits);
  }
  std::vector<uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<uint8_t> bytes_;
};

}  // namespace

SizeGuess guess_size(const std::string& ending, double longest_mm) {
  const MeshFormat* const format = mesh_format_of(ending);
  const bool metres = format && format->unit_mm == 1000;
  const std::string note = format ? format->unit_note : kMeshFormats[0].unit_note;
  if (longest_mm >= kMinMeantMm && longest_mm <= kMaxMeantMm)
    return {metres ? "m" : "mm", longest_mm, note + "."};
  return {"fit", kUsualLongestMm,
          note + ", but it would be " + length_text(longest_mm) + " long: made " +
              length_text(kUsualLongestMm) + "."};
}

UpGuess guess_up(const std::string& ending, const TriangleMesh& mesh) {
  using Up = MeshFormat::Up;
  const MeshFormat* const format = mesh_format_of(ending);
  const Up usual = format ? format->up : Up::mostly_z;
  if (usual == Up::turned) return {{}, "Files of this format have y up, so it was turned."};
  const Box box = mesh.bounds();
  const bool custom_y = usual == Up::mostly_y;
  const int custom = custom_y ? 1 : 2, other = 3 - custom;
  const auto up = [](int axis) {
    return standing(axis == 1 ? SignedAxis::plus_y : SignedAxis::plus_z);
  };
  const std::string name[] = {"x", "y", "z"};
  const double here = support(mesh, box, custom), there = support(mesh, box, other);
  if (there > kFlat && there > 3 * here)
    return {up(other), "It has a flat base when " + name[other] + " is up."};
  if (usual == Up::perhaps_z && here < kFlat &&
      middle_height(mesh, box, other) + 0.08 < middle_height(mesh, box, custom))
    return {up(other), "Its centre of mass is lower when " + name[other] + " is up."};
  return {up(custom),
          (custom_y ? "OBJ files mostly have y up" : "Files like this one mostly have z up") +
              std::string(here > kFlat ? ", and it has a flat base so." : ".")};
}

namespace {

// The label of the nearest voxel with material around a place.
uint16_t label_near(const LabelVolume& volume, const Vec3& at_mm) {
  const Vec3 at = at_mm.cwiseQuotient(volume.voxel_mm) - Vec3::Constant(0.5);
  const Eigen::Vector3i middle = at.array().round().matrix().cast<int>();
  uint16_t found = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int z = -1; z <= 1; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++) {
        const Eigen::Vector3i voxel = middle + Eigen::Vector3i(x, y, z);
        const uint16_t label = volume.at(voxel.x(), voxel.y(), voxel.z(), 0);
        const double far = (voxel.cast<double>() - at).cwiseProduct(volume.voxel_mm).squaredNorm();
        if (label == 0 || far >= nearest) continue;
        found = label;
        nearest = far;
      }
  return found;
}

// Keeps every n-th voxel along each axis, because the preview does not resolve more. The new voxels
// are about `max_mm` long at most, unless the old ones are longer.
LabelVolume thinned(const LabelVolume& volume, double max_mm) {
  LabelVolume thin;
  thin.names = volume.names;
  std::array<int, 3> step, first;
  for (int i = 0; i < 3; i++) {
    const auto n = static_cast<size_t>(i);
    step[n] = std::clamp(static_cast<int>(max_mm / volume.voxel_mm[i]), 1,
                         static_cast<int>(volume.size[i]));
    first[n] = step[n] / 2;
    thin.size[i] = (volume.size[i] - first[n] + step[n] - 1) / step[n];
    thin.voxel_mm[i] = volume.size_mm()[i] / static_cast<double>(thin.size[i]);
  }
  thin.values.reserve(static_cast<size_t>(thin.size.prod()));
  for (int z = first[2]; z < volume.size[2]; z += step[2])
    for (int y = first[1]; y < volume.size[1]; y += step[1])
      for (int x = first[0]; x < volume.size[0]; x += step[0])
        thin.values.push_back(volume.values[volume.index(x, y, z)]);
  return thin;
}

std::vector<LabelReport> report_labels(const LabelVolume& volume) {
  const std::vector<Material>& materials = known_materials();
  std::map<uint16_t, size_t> voxels;
  for (const uint16_t label : volume.values)
    if (label != 0) voxels[label]++;
  std::vector<LabelReport> labels;
  for (const auto& [label, count] : voxels) {
    LabelReport one;
    one.label = label;
    const auto named = volume.names.find(label);
    one.name = named == volume.names.end() ? "label " + std::to_string(label)
                                           : sanitize_message(named->second);
    one.volume_mm3 = static_cast<double>(count) * volume.voxel_mm.prod();
    // Neighbours in the list of materials look similar, so labels use every third one.
    one.material = static_cast<uint8_t>(3 * labels.size() % materials.size());
    std::string called = one.name;
    std::transform(called.begin(), called.end(), called.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    for (size_t i = 0; i < materials.size(); i++)
      if (materials[i].name == called) one.material = static_cast<uint8_t>(i);
    labels.push_back(std::move(one));
  }
  return labels;
}

Result<ImportReport> report_volume(const std::filesystem::path& path) {
  const Result<LabelVolume> read = read_volume(path);
  if (!read) return Error{read.error()};
  ImportReport report;
  report.kind = ImportReport::Kind::volume;
  report.labels = report_labels(read.value());
  if (report.labels.empty()) return Error{path.string() + ": contains only air"};
  if (report.labels.size() > kMaxMaterials)
    return Error{path.string() + ": has " + std::to_string(report.labels.size()) +
                 " labels, but a piece can have at most " + std::to_string(kMaxMaterials) +
                 " materials; is it a segmentation?"};
  report.size_mm = read.value().size_mm();
  const double longest = report.size_mm.maxCoeff(), pitch = longest / kPreviewNodes;
  const LabelVolume volume = thinned(read.value(), 0.5 * pitch);
  const Result<Lattice> lattice = make_lattice(report.size_mm, pitch, 2 * pitch);
  if (!lattice) return Error{path.string() + ": " + lattice.error()};
  const ShapeGrid whole = shape_of_labels(volume, [](uint16_t label) { return label != 0; });
  TriDexel model(lattice.value());
  Removed added;
  deposit(model, GridSolid(whole, Vec3::Zero(), lattice.value()), 0, {}, added);
  const Surface surface = extract_surface(model.snapshot());
  if (surface.triangles.empty())
    return Error{path.string() + ": its material is too thin to be carved"};
  TriangleMesh mesh;
  for (const SurfaceVertex& vertex : surface.vertices)
    mesh.vertices.emplace_back(vertex.position[0], vertex.position[1], vertex.position[2]);
  mesh.triangles.assign(surface.triangles.begin(), surface.triangles.end());
  report.triangles = mesh.triangles.size();
  report.area_mm2 = area_of(mesh);
  report.preview = cluster(mesh, kPreviewTriangles);
  for (Vec3& p : report.preview.vertices) {
    const uint16_t label = label_near(volume, p);
    const auto kind = std::find_if(report.labels.begin(), report.labels.end(),
                                   [&](const LabelReport& one) { return one.label == label; });
    report.kinds.push_back(
        kind == report.labels.end() ? 0 : static_cast<uint32_t>(kind - report.labels.begin()));
    p /= longest;
  }
  return report;
}

}  // namespace

Result<ImportReport> report_import(const std::filesystem::path& path) {
  ImportReport report;
  const std::string ending = ending_of(path);
  if (is_volume(path)) return report_volume(path);
  if (ending == ".png") {
    const Result<GreyMap> picture = read_png_grey(path);
    if (!picture) return Error{picture.error()};
    report.kind = ImportReport::Kind::relief;
    report.width = picture.value().width;
    report.height = picture.value().height;
    report.picture = shrunk(picture.value());
    return report;
  }
  std::vector<std::string> notes;
  const Result<TriangleMesh> read = read_mesh(path, &notes);
  if (!read) return Error{read.error()};
  const TriangleMesh& mesh = read.value();
  report.triangles = mesh.triangles.size();
  report.size_mm = mesh.bounds().size();
  const double longest = report.size_mm.maxCoeff();
  if (!(longest > 0)) return Error{path.string() + ": has no extent"};
  report.area_mm2 = area_of(mesh);
  const MeshFormat* const format = mesh_format_of(ending);
  report.unit_mm = format ? format->unit_mm : 1;
  report.size = guess_size(ending, longest);
  report.up = guess_up(ending, mesh);
  report.repairs = repairs_of(mesh);
  const size_t folder = path.string().size() - path.filename().string().size();
  for (const std::string& note : notes)
    report.repairs.push_back(note.substr(std::min(folder, note.size())) + ".");
  report.preview = cluster(mesh, kPreviewTriangles);
  const Vec3 corner = mesh.bounds().min;
  for (Vec3& p : report.preview.vertices) p = (p - corner) / longest;
  return report;
}

std::string import_report_json(const ImportReport& report) {
  // Bytes per ray, as check_memory counts them.
  Json json{{"ray_bytes", static_cast<double>(sizeof(Tile)) / kTileRays + 40},
            {"free_bytes", available_bytes()}};
  const Json size{report.size_mm.x(), report.size_mm.y(), report.size_mm.z()};
  if (report.kind == ImportReport::Kind::relief) {
    json.update({{"kind", "relief"}, {"width", report.width}, {"height", report.height}});
  } else if (report.kind == ImportReport::Kind::volume) {
    json.update({{"kind", "volume"}, {"size_mm", size}, {"area_mm2", report.area_mm2}});
    for (const LabelReport& one : report.labels)
      json["labels"].push_back({{"label", one.label},
                                {"name", one.name},
                                {"volume_mm3", one.volume_mm3},
                                {"material", one.material}});
  } else {
    json.update({{"kind", "mesh"},
                 {"triangles", report.triangles},
                 {"size_mm", size},
                 {"area_mm2", report.area_mm2},
                 {"unit_mm", report.unit_mm},
                 {"unit", report.size.unit},
                 {"unit_why", report.size.why},
                 {"longest_mm", report.size.longest_mm},
                 {"up", signed_axis_text(report.up.orientation.up)},
                 {"front", signed_axis_text(report.up.orientation.front)},
                 {"up_why", report.up.why},
                 {"repairs", report.repairs}});
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<uint8_t> import_preview(const ImportReport& report) {
  Bytes32 out;
  if (report.kind == ImportReport::Kind::relief) {
    out.put(static_cast<uint32_t>(report.picture.width));
    out.put(static_cast<uint32_t>(report.picture.height));
    for (const uint16_t pixel : report.picture.pixels) out.put(pixel / 65535.0);
    return out.take();
  }
  out.put(static_cast<uint32_t>(report.preview.vertices.size()));
  out.put(static_cast<uint32_t>(report.preview.triangles.size()));
  for (const Vec3& p : report.preview.vertices)
    for (int i = 0; i < 3; i++) out.put(p[i]);
  for (const auto& triangle : report.preview.triangles)
    for (const uint32_t corner : triangle) out.put(corner);
  for (const uint32_t kind : report.kinds) out.put(kind);
  return out.take();
}

}  // namespace kibori
