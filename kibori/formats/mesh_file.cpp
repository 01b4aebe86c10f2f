// SPDX-License-Identifier: MIT
#include <kibori/formats/mesh_file.h>

#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/tolerances.h>
#include <kibori/formats/import_helper.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/stl.h>

namespace kibori {

Result<TriangleMesh> read_mesh(const std::filesystem::path& path, std::vector<std::string>* notes) {
  const std::string ending = ending_of(path);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{path.string() + ": no such file"};
  if (!std::filesystem::is_regular_file(path, error))
    return Error{path.string() + ": is not a regular file but a folder, a pipe or a device"};
  Result<TriangleMesh> mesh = Error{};
  if (ending == ".stl") {
    const Result<std::vector<char>> bytes = read_file(path);
    if (!bytes) return Error{bytes.error()};
    mesh = parse_stl({bytes.value().data(), bytes.value().size()}, path.string(), notes);
  } else if (is_one_of(kMeshesRead, ending)) {
    mesh = read_in_helper(path, notes);
  } else {
    return Error{path.string() + ": meshes are read from " + list_of(kMeshesRead, ", ", " and ") +
                 " files"};
  }
  if (mesh)
    for (const Vec3& p : mesh.value().vertices)
      if (!(p.cwiseAbs().maxCoeff() <= kMaxCoordinate))
        return Error{path.string() + ": has coordinates beyond 10^12 mm; scale it down"};
  if (mesh && mesh.value().triangles.empty())
    return Error{path.string() + ": has no triangles; export it with a mesh"};
  return mesh;
}

}  // namespace kibori
