// SPDX-License-Identifier: MIT
#include <kibori/session/convert.h>

#include <array>

#include <kibori/formats/mesh_file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/session/stock.h>
#include <kibori/surface/surface.h>

namespace kibori {

Result<ConvertSummary> convert(const std::filesystem::path& in, const std::filesystem::path& out,
                               const ConvertOptions& options) {
  if (const Status known = check_surface_ending(out); !known) return Error{known.error()};
  Result<TriangleMesh> mesh = read_mesh(in);
  if (!mesh) return Error{mesh.error()};
  const Box box = mesh.value().bounds();
  const double longest = box.size().maxCoeff();
  if (!(longest > 0)) return Error{in.string() + ": has no extent"};
  ConvertSummary summary;
  summary.pitch_mm = options.pitch_mm.value_or(longest / 256);
  summary.triangles_in = mesh.value().triangles.size();
  Result<MeshStock> stock =
      stock_of_mesh(mesh.value(), summary.pitch_mm, 2 * summary.pitch_mm, 0, options.threads, options.force);
  if (!stock) return Error{in.string() + ": " + stock.error()};
  if (stock.value().report.repaired() && options.warning)
    options.warning(in.string() + ": " + stock.value().report.warning());
  const Snapshot model = stock.value().model->snapshot();
  summary.volume_mm3 = model.volume_mm3();
  const Surface surface = extract_surface(model, options.threads);
  if (surface.triangles.empty())
    return Error{in.string() + ": holds no material at this pitch; use a finer one"};
  summary.triangles_out = surface.triangles.size();
  const std::array<uint8_t, 3> white{255, 255, 255};
  if (const Status written = write_surface(out, surface, {&white, 1}); !written)
    return Error{written.error()};
  return summary;
}

}  // namespace kibori
