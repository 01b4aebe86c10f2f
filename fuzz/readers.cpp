// SPDX-License-Identifier: MIT
// libFuzzer on a reader of our own, chosen when compiling by KIBORI_FUZZ_<READER>. A finding
// is anything except a result or an error of one sentence. Each folder of
// fuzz/corpus has a branch at the end of this file.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include <unistd.h>
#include <zstd.h>

#include <kibori/scene/scene.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/formats/glb.h>
#include <kibori/formats/nrrd.h>
#include <kibori/formats/obj.h>
#include <kibori/formats/off.h>
#include <kibori/formats/ply.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/stl.h>
#include <kibori/formats/threemf.h>
#include <kibori/mill/program.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/surface/surface.h>

using namespace kibori;

namespace {

template <class T>
void one_sentence(const Result<T>& result) {
  if (!result && (result.error().empty() || result.error().find('\n') != std::string::npos))
    std::abort();
}

[[maybe_unused]] void sound(const Result<TriangleMesh>& mesh) {
  one_sentence(mesh);
  if (!mesh) return;
  for (const Vec3& p : mesh.value().vertices)
    if (!p.allFinite()) std::abort();
  for (const auto& t : mesh.value().triangles)
    for (const uint32_t v : t)
      if (v >= mesh.value().vertices.size()) std::abort();
}

[[maybe_unused]] void one_sentence(const Status& status) {
  if (!status && (status.error().empty() || status.error().find('\n') != std::string::npos))
    std::abort();
}

// Runs every reading function of a document.
[[maybe_unused]] void document(const std::span<const char> bytes) {
  static const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                            ("kibori-fuzz-" + std::to_string(getpid()) + ".kibori");
  for (const char* rest : {"-wal", "-shm", "-journal"})
    std::filesystem::remove(file.string() + rest);
  std::ofstream(file, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto opened = Document::open(file, Document::Access::read);
  one_sentence(opened);
  if (opened) {
    Document& d = *opened.value();
    one_sentence(d.load());
    one_sentence(d.stock());
    for (const auto& [id, step] : d.steps()) one_sentence(d.thumbnail(id));
    one_sentence(d.verify([](const std::string&) {}));
  }
}

// All moves of a program, one line at a time.
[[maybe_unused]] void program(const std::string_view text) {
  const auto reader = Program::of_text("a.nc", text);
  std::vector<CanonMove> moves;
  while (true) {
    moves.clear();
    const Result<bool> more = reader->next(moves);
    one_sentence(more);
    if (!more || !more.value()) break;
    for (const CanonMove& move : moves)
      if (const auto* rapid = std::get_if<RapidMove>(&move.action);
          rapid && !rapid->to.xyz_mm.allFinite())
        std::abort();
  }
}

// Carves the tile that was read, and extracts its surface.
[[maybe_unused]] void tile(const Bytes& packed) {
  Lattice lattice;
  lattice.nodes = Index3(16, 16, 16);
  TriDexel model(lattice);
  for (const Axis axis : kAxes) {
    const Status read = decode_tile(packed, model.field(axis), 0, 0);
    one_sentence(read);
    if (!read) return;
  }
  model.include_material({Vec3::Zero(), Vec3::Constant(16)});
  model.touch();
  DirectTool stroke(model, Pose{Vec3(-4, 8, 6), Mat3::Identity()});
  const std::vector<Material> materials(2);
  for (const Mode mode : {Mode::touch, Mode::cut, Mode::deposit})
    one_sentence(stroke.advance(BallTool{3}, Vec3(mode == Mode::cut ? 20 : 4, 8, 7),
                                Vec3(0, 0.1, 0), mode, {}, materials));
  extract_surface(model.snapshot(), 1);
}

// The contents of a document's cells. The first byte selects the kind. They are compressed here,
// because a fuzzer does not find valid compressed data.
[[maybe_unused]] void cell(const uint8_t* data, size_t size) {
  if (size == 0) return;
  Bytes packed(ZSTD_compressBound(size));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), data + 1, size - 1, 1));
  switch (data[0] % 5) {
    case 0:
      return one_sentence(decode_ticks(packed));
    case 1:
      return one_sentence(decode_forces(packed));
    case 2:
      return tile(packed);
    case 3:
      return one_sentence(decode_pose(Bytes(data + 1, data + size)));
    default:
      return one_sentence(settings_from_json(std::string(data + 1, data + size)));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const char> bytes(reinterpret_cast<const char*>(data), size);
  [[maybe_unused]] const std::string_view text(bytes.data(), bytes.size());
#if defined(KIBORI_FUZZ_STL)
  sound(parse_stl(text, "a.stl"));
#elif defined(KIBORI_FUZZ_OBJ)
  sound(parse_obj(text, "a.obj"));
#elif defined(KIBORI_FUZZ_OFF)
  sound(parse_off(text, "a.off"));
#elif defined(KIBORI_FUZZ_GLB)
  sound(parse_glb(text, "a.glb"));
#elif defined(KIBORI_FUZZ_GLTF)
  // The input itself as the file that a buffer names.
  GltfFiles files;
  files.emplace("part.bin", std::vector<char>(bytes.begin(), bytes.end()));
  sound(parse_glb(text, "a.gltf", nullptr, &files));
#elif defined(KIBORI_FUZZ_PLY)
  sound(parse_ply(bytes, "a.ply"));
#elif defined(KIBORI_FUZZ_3MF)
  sound(parse_3mf(bytes, "a.3mf"));
#elif defined(KIBORI_FUZZ_PNG)
  one_sentence(parse_png_grey(bytes, "a.png"));
#elif defined(KIBORI_FUZZ_NRRD)
  one_sentence(nrrd_data_file(bytes, "a.nrrd"));
  one_sentence(parse_nrrd(bytes, bytes, "a.nrrd"));
#elif defined(KIBORI_FUZZ_SCENE)
  one_sentence(parse_scene({bytes.data(), bytes.size()}, "a.toml", "."));
#elif defined(KIBORI_FUZZ_GCODE)
  program(text);
#elif defined(KIBORI_FUZZ_DOCUMENT)
  document(bytes);
#elif defined(KIBORI_FUZZ_CELL)
  cell(data, size);
#else
#error "a folder of fuzz/corpus has no reader here"
#endif
  return 0;
}
