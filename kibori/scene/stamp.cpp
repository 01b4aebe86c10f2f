// SPDX-License-Identifier: MIT
#include <kibori/scene/stamp.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include <kibori/scene/relief.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/surface/simplify.h>

namespace kibori {
namespace {

// Maximum number of pixels along the width of a picture, at any pitch.
constexpr double kMaxAcross = 128;
// Smallest tolerance of the letters' outlines, as a share of the pitch.
constexpr double kTextPitches = 0.05;
// Maximum distance between a simplified relief and the picture, as a share of the pitch.
constexpr double kSimplifyPitches = 0.1;

Status check_triangles(const TriangleMesh& mesh, const std::string& name) {
  if (mesh.triangles.size() <= kMaxStampTriangles) return Ok{};
  return Error{name + ": has " + std::to_string(mesh.triangles.size()) +
               " triangles, and a stamp may have at most " + std::to_string(kMaxStampTriangles) +
               "; use a simpler one"};
}

// Moves the mesh so that its tip is at the origin. The tip is the middle of its bounds in x and y,
// at the height of the lowest point.
void center_on_tip(TriangleMesh& mesh) {
  const Box box = mesh.bounds();
  const Vec3 tip(box.centre().x(), box.centre().y(), box.min.z());
  for (Vec3& p : mesh.vertices) p -= tip;
}

Tool tool_of(TriangleMesh mesh) {
  return MeshTool{std::make_shared<TriangleMesh>(std::move(mesh))};
}

}  // namespace

Result<Tool> text_stamp(Lettering lettering, double pitch_mm) {
  lettering.tolerance_mm = std::max(lettering.tolerance_mm, kTextPitches * pitch_mm);
  Result<TriangleMesh> mesh = letter_mesh(lettering);
  if (!mesh) return Error{mesh.error()};
  if (const Status fits = check_triangles(mesh.value(), "the text"); !fits)
    return Error{fits.error()};
  return tool_of(std::move(mesh).value());
}

Result<Tool> picture_stamp(const std::filesystem::path& picture, const PictureStamp& size,
                           double pitch_mm) {
  const auto fits = [](double mm) { return mm >= 0.1 && mm <= 1000; };
  if (!fits(size.width_mm) || !fits(size.depth_mm) || !fits(size.back_mm))
    return Error{"the width and the depth of a stamp must be 0.1 to 1000 mm"};
  // read_relief averages pixels that are smaller than half of this pitch.
  const double resolved = std::max(pitch_mm, 2 * size.width_mm / kMaxAcross);
  Result<TriangleMesh> relief =
      read_relief(picture, {size.width_mm, size.depth_mm, size.back_mm, size.invert}, resolved);
  if (!relief) return Error{relief.error()};
  const Surface surface = simplify(surface_of_mesh(relief.value()), kSimplifyPitches * pitch_mm);
  // A stamp's relief is on its lower side. So z is mirrored and the triangles are reversed.
  TriangleMesh mesh;
  mesh.vertices.reserve(surface.vertices.size());
  for (const SurfaceVertex& v : surface.vertices)
    mesh.vertices.emplace_back(v.position[0], v.position[1], -double{v.position[2]});
  mesh.triangles.reserve(surface.triangles.size());
  for (const SurfaceTriangle& t : surface.triangles) mesh.triangles.push_back({t[0], t[2], t[1]});
  if (const Status few = check_triangles(mesh, picture.string()); !few) return Error{few.error()};
  center_on_tip(mesh);
  return tool_of(std::move(mesh));
}

Result<Tool> mesh_stamp(const std::filesystem::path& file, double width_mm) {
  Result<TriangleMesh> read = read_mesh(file);
  if (!read) return Error{read.error()};
  TriangleMesh mesh = std::move(read).value();
  if (const Status few = check_triangles(mesh, file.string()); !few) return Error{few.error()};
  if (!mesh_info(surface_of_mesh(mesh)).closed)
    return Error{
        file.string() +
        ": a stamp must be closed, and this mesh has holes; repair it with 'kibori convert'"};
  center_on_tip(mesh);
  const Vec3 size = mesh.bounds().size();
  const double across = std::max(size.x(), size.y());
  if (!(across > 0)) return Error{file.string() + ": the mesh has no width; use a solid mesh"};
  if (width_mm > 0)
    for (Vec3& p : mesh.vertices) p *= width_mm / across;
  return tool_of(std::move(mesh));
}

}  // namespace kibori
