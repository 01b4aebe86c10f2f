// SPDX-License-Identifier: MIT
// kibori-import FILE: reads a mesh by parsers that are not to be trusted with a session, and hands
// it to the program that started it (formats/import_helper.h). Exit 2 and one sentence for a bad
// file; nobody calls it by hand.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <kibori/base/file.h>
#include <kibori/base/tolerances.h>
#include <kibori/formats/import_helper.h>
#include <kibori/formats/ply.h>
#include <kibori/formats/threemf.h>

namespace {

using namespace kibori;

// The one file that parsers may open, in memory: whatever else it names, is not there.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::vector<char>& bytes)
      : name_(std::move(name)), bytes_(bytes) {}
  bool Exists(const char* name) const override { return name_ == name; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (name_ != name || mode[0] != 'r') return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const uint8_t*>(bytes_.data()),
                                      bytes_.size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string name_;
  const std::vector<char>& bytes_;
};

// What a header can take at most.
std::istringstream head_of(const std::vector<char>& bytes) {
  return std::istringstream(std::string(bytes.data(), std::min(bytes.size(), size_t{1} << 20)));
}

// Whether a PLY file has triangle strips, of which Assimp reads one triangle each. Errors: a header
// without its end, which Assimp looks for forever, or whose counts can't fit the file: every
// element takes a byte at least.
Result<bool> has_strips(const std::vector<char>& bytes, const std::string& name) {
  std::istringstream head = head_of(bytes);
  std::string line;
  bool strips = false;
  for (int number = 1; number < 1000 && std::getline(head, line); number++) {
    if (line.starts_with("end_header")) return strips;
    char element[64];
    double count = 0;
    if (std::sscanf(line.c_str(), "element %63s %lf", element, &count) != 2) continue;
    strips |= std::string_view(element) == "tristrips";
    if (!(count <= static_cast<double>(bytes.size())))
      return Error{name + ":" + std::to_string(number) + ": promises more of element '" + element +
                   "' than the file has bytes; export it again"};
  }
  return Error{name + ": has no end of its header (end_header); export it again"};
}

// An OFF file without comments and empty lines, as Assimp's own parser takes those for vertices and
// faces. Errors: counts that the file can't hold, and faces of vertices that are not there, which
// Assimp takes for others.
Result<std::vector<char>> checked_off(const std::vector<char>& bytes, const std::string& name) {
  // Lines may end by any of the three customs.
  std::string text;
  text.reserve(bytes.size());
  for (size_t i = 0; i < bytes.size(); i++)
    if (bytes[i] != '\r')
      text += bytes[i];
    else if (i + 1 == bytes.size() || bytes[i + 1] != '\n')
      text += '\n';
  std::istringstream file(text);
  std::vector<char> clean;
  clean.reserve(bytes.size());
  std::string line;
  int number = 0;
  // The next line that holds something.
  const auto next = [&] {
    while (std::getline(file, line)) {
      number++;
      line.resize(std::min(line.find('#'), line.size()));
      if (line.find_first_not_of(" \t") == std::string::npos) continue;
      clean.insert(clean.end(), line.begin(), line.end());
      clean.push_back('\n');
      return true;
    }
    return false;
  };
  const auto wrong = [&](const std::string& what) {
    return Error{name + ":" + std::to_string(number) + ": " + what + "; export it again"};
  };
  double vertices = -1, faces = -1;
  bool plain = false;  // no normals, colours or binary numbers
  while (vertices < 0) {
    if (!next() || number >= 1000) return Error{name + ": has no counts of vertices and faces"};
    const size_t digits = line.find_first_of("0123456789-");
    if (line.starts_with("OFF") &&
        (line.size() == 3 || std::isspace(static_cast<unsigned char>(line[3]))))
      plain = line.find("BINARY") == std::string::npos;
    if (digits == std::string::npos) continue;
    if (std::sscanf(line.c_str() + digits, "%lf %lf", &vertices, &faces) != 2 ||
        !(vertices >= 0 && faces >= 0) || !(vertices + faces <= static_cast<double>(bytes.size())))
      return wrong("promises more vertices or faces than the file has bytes");
  }
  if (!plain) return bytes;
  for (double i = 0; i < vertices; i++)
    if (!next()) return Error{name + ": ends in the middle of its vertices; export it again"};
  for (double i = 0; i < faces; i++) {
    if (!next()) return Error{name + ": ends in the middle of its faces; export it again"};
    const char* at = line.c_str();
    char* end = nullptr;
    const long corners = std::strtol(at, &end, 10);
    for (long k = 0; k < corners; k++) {
      at = end;
      const double vertex = std::strtod(at, &end);
      if (end == at) return wrong("a face of " + std::to_string(corners) + " corners names fewer");
      if (!(vertex >= 0 && vertex < vertices))
        return wrong("a face names a vertex that is not there");
    }
  }
  return clean;
}

// glb: metres and Y up.
Result<TriangleMesh> read_with_assimp(const std::vector<char>& bytes,
                                      const std::filesystem::path& path, bool glb) {
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(path.string(), bytes));  // which owns it
  // Points and lines are of no use here; positions alone matter.
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode) {
    std::string reason = importer.GetErrorString();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    return Error{path.string() + ": can't be read as a mesh: " + reason};
  }
  TriangleMesh mesh;
  const auto put = [&](const aiMesh& part, const aiMatrix4x4& to_world) -> Status {
    const auto base = static_cast<uint32_t>(mesh.vertices.size());
    const bool mirrored = to_world.Determinant() < 0;
    for (unsigned i = 0; i < part.mNumVertices; i++) {
      const aiVector3D p = to_world * part.mVertices[i];
      const Vec3 at(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
      mesh.vertices.push_back(glb ? Vec3(1000 * Vec3(at.x(), -at.z(), at.y())) : at);
      if (!mesh.vertices.back().allFinite())
        return Error{path.string() + ": vertex " + std::to_string(i + 1) +
                     " has a coordinate that is not a finite number"};
    }
    for (unsigned i = 0; i < part.mNumFaces; i++) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      for (unsigned k = 0; k < 3; k++)
        if (face.mIndices[k] >= part.mNumVertices)
          return Error{path.string() + ": face " + std::to_string(i + 1) +
                       " names a vertex that is not there"};
      mesh.triangles.push_back(
          {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
      if (mirrored) std::swap(mesh.triangles.back()[1], mesh.triangles.back()[2]);
    }
    if (mesh.triangles.size() > kMaxImportTriangles ||
        mesh.vertices.size() > 3 * kMaxImportTriangles)
      return Error{path.string() + ": holds more triangles than can be taken"};
    return Ok{};
  };
  // Assimp's own step for this (PreTransformVertices) takes minutes for a million nodes.
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> nodes{{scene->mRootNode, aiMatrix4x4()}};
  while (!nodes.empty()) {
    const auto [node, before] = nodes.back();
    nodes.pop_back();
    const aiMatrix4x4 to_world = before * node->mTransformation;
    for (unsigned i = 0; i < node->mNumMeshes; i++)
      if (Status s = put(*scene->mMeshes[node->mMeshes[i]], to_world); !s) return Error{s.error()};
    for (unsigned i = node->mNumChildren; i > 0; i--)
      nodes.emplace_back(node->mChildren[i - 1], to_world);
  }
  return mesh;
}

Result<TriangleMesh> parse_foreign(const std::vector<char>& bytes,
                                   const std::filesystem::path& path) {
  const std::string ending = ending_of(path), name = path.string();
  if (ending == ".3mf") return parse_3mf(bytes, name);
  if (ending == ".ply") {
    const Result<bool> strips = has_strips(bytes, name);
    if (!strips) return Error{strips.error()};
    if (strips.value()) return parse_ply(bytes, name);
  }
  if (ending == ".off") {
    const Result<std::vector<char>> clean = checked_off(bytes, name);
    if (!clean) return Error{clean.error()};
    return read_with_assimp(clean.value(), path, false);
  }
  return read_with_assimp(bytes, path, ending == ".glb");
}

int fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return fail("kibori-import: is called by kibori, with one file");
  const std::filesystem::path path = argv[1];
  try {
    if (!limit_helper(path)) return fail(path.string() + ": the importer can't limit itself");
    const Result<std::vector<char>> bytes = read_file(path);
    if (!bytes) return fail(bytes.error());
    confine_helper();
    const Result<TriangleMesh> mesh = parse_foreign(bytes.value(), path);
    if (!mesh) return fail(mesh.error());
    if (mesh.value().triangles.size() > kMaxImportTriangles)
      return fail(path.string() + ": holds more triangles than can be taken");
    return send_mesh(mesh.value()) ? 0 : fail(path.string() + ": no memory for its triangles");
  } catch (const std::bad_alloc&) {
    return fail(
        path.string() +
        ": takes more memory to read than a file of its size can need; it is damaged or hostile");
  } catch (const std::exception& error) {
    return fail(path.string() + ": can't be read: " + error.what());
  }
}
