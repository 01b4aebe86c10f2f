// SPDX-License-Identifier: MIT
// kibori-import FILE: parses a mesh or a labelled volume in a separate process. Therefore, a
// malicious file can only cause an error message. The result goes to the program that started this
// one (formats/import_helper.h). A bad file gives one sentence and exit status 2. Users do not call
// this program.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/tolerances.h>
#include <kibori/formats/glb.h>
#include <kibori/formats/import_helper.h>
#include <kibori/formats/nrrd.h>
#include <kibori/formats/obj.h>
#include <kibori/formats/off.h>
#include <kibori/formats/ply.h>
#include <kibori/formats/stl.h>
#include <kibori/formats/threemf.h>
#include <kibori/formats/volume_file.h>

namespace {

using namespace kibori;

Result<TriangleMesh> parse(const std::vector<char>& bytes, const std::filesystem::path& path,
                           const GltfFiles& files, std::vector<std::string>& notes) {
  const std::string ending = ending_of(path), name = path.string();
  const std::string_view text(bytes.data(), bytes.size());
  if (ending == ".3mf") return parse_3mf(bytes, name, &notes);
  if (ending == ".glb") return parse_glb(text, name, &notes);
  if (ending == ".gltf") return parse_glb(text, name, &notes, &files);
  if (ending == ".obj") return parse_obj(text, name, &notes);
  if (ending == ".off") return parse_off(text, name, &notes);
  if (ending == ".ply") return parse_ply(bytes, name, &notes);
  if (ending == ".stl") return parse_stl(text, name, &notes);
  return Error{name + ": kibori-import does not read this format"};
}

int fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  return 2;
}

int import_mesh(const std::vector<char>& bytes, const std::filesystem::path& path) {
  GltfFiles files;
  if (ending_of(path) == ".gltf") {
    // read_gltf_files parses the text to find the names of other files. So limit this process to
    // their folder first.
    confine_helper_to(path.parent_path().empty() ? "." : path.parent_path());
    files = read_gltf_files({bytes.data(), bytes.size()}, path);
  }
  confine_helper();
  std::vector<std::string> notes;
  const Result<TriangleMesh> mesh = parse(bytes, path, files, notes);
  if (!mesh) return fail(mesh.error());
  if (mesh.value().triangles.size() > kMaxImportTriangles)
    return fail(path.string() + ": has more than 100 million triangles; export fewer");
  return send_mesh(mesh.value(), notes) ? 0 : fail(path.string() + ": no memory for its triangles");
}

int import_volume(const std::vector<char>& bytes, const std::filesystem::path& path) {
  // Before this process loses the right to open files, it parses only the header.
  const Result<std::filesystem::path> detached = nrrd_data_file(bytes, path);
  if (!detached) return fail(detached.error());
  std::vector<char> data;
  if (!detached.value().empty()) {
    Result<std::vector<char>> read = read_file(detached.value());
    if (!read) return fail(read.error());
    data = std::move(read).value();
  }
  confine_helper();
  const Result<LabelVolume> volume = parse_nrrd(bytes, data, path);
  if (!volume) return fail(volume.error());
  const std::vector<uint16_t>& values = volume.value().values;
  if (std::all_of(values.begin(), values.end(), [](uint16_t label) { return label == 0; }))
    return fail(path.string() + ": contains only air");
  return send_volume(volume.value()) ? 0 : fail(path.string() + ": no memory for its voxels");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return fail("kibori-import: is called by kibori, with one file");
  const std::filesystem::path path = argv[1];
  try {
    if (!limit_helper(path))
      return fail(path.string() + ": the importer cannot limit its own memory and time");
    const Result<std::vector<char>> bytes = read_file(path);
    if (!bytes) return fail(bytes.error());
    return is_volume(path) ? import_volume(bytes.value(), path) : import_mesh(bytes.value(), path);
  } catch (const std::bad_alloc&) {
    return fail(path.string() +
                ": needs more memory than allowed for a file of its size; export fewer triangles, "
                "copies or voxels");
  } catch (const std::exception& error) {
    return fail(path.string() + ": can't be read: " + error.what() + "; please report this bug");
  }
}
