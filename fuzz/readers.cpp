// SPDX-License-Identifier: MIT
// Runs libFuzzer on one of Kibori's readers. The macro KIBORI_FUZZ_<READER> selects it. The reader
// must return a valid result or an error of one sentence. Anything else is a finding. Each folder
// of fuzz/corpus has a branch at the end of this file.
#include <algorithm>
#include <cmath>
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
#include <kibori/mill/machine.h>
#include <kibori/mill/program.h>
#include <kibori/mill/refeed.h>
#include <kibori/mill/tool_table.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/run/milling_job.h>
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

// Runs the functions that read a document.
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

// Reads all moves of a program. The targets of rapid moves must be finite.
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

// A valid job has at least one set-up. Each set-up has a program, and its frame is orthonormal.
[[maybe_unused]] void mill_job(const std::string_view text) {
  const Result<MillJob> job = parse_mill_job(std::string(text), "a.toml", "folder");
  one_sentence(job);
  if (!job) return;
  if (job.value().setups.empty()) std::abort();
  for (const MillJobSetup& setup : job.value().setups) {
    const Mat3 turn = setup.frame.frame.transpose() * setup.frame.frame;
    if (setup.programs.empty() || !(turn - Mat3::Identity()).isZero(1e-6)) std::abort();
  }
}

// Parses the input as each of the three kinds of tool tables. Every tool must be valid.
[[maybe_unused]] void mill_tools(const std::string& text) {
  const auto check = [](const ToolTable& table) {
    for (const MillTool& tool : table.tools) {
      if (!check_tool(tool.cutter)) std::abort();
      for (const ToolSection& section : tool.body)
        if (!(section.radius_mm > 0 && section.from_mm < section.to_mm)) std::abort();
    }
  };
  for (const auto parse : {parse_linuxcnc_tools, parse_toml_tools}) {
    const Result<ToolTable> table = parse(text, "a.tbl");
    one_sentence(table);
    if (table) check(table.value());
  }
  const Result<MillProject> project = parse_camotics(text, "a.camotics", ".");
  one_sentence(project);
  if (project) check(project.value().tools);
}

// A valid machine must convert axis positions to finite poses. Its rapid moves must have at most
// six points and a finite duration.
[[maybe_unused]] void mill_machine(const std::string& text) {
  const Result<Machine> machine = parse_machine(text, "a.toml");
  one_sentence(machine);
  if (!machine) return;
  const AxisPosition at{Vec3(1, 2, 3), Vec3(10, 20, 30)};
  for (const bool tcp : {false, true})
    if (!machine.value().pose(at, tcp).tip.allFinite()) std::abort();
  if (machine.value().rapid_points({}, at).size() > 6 ||
      !std::isfinite(machine.value().rapid_seconds({}, at)))
    std::abort();
}

// A program with rewritten feed rates must have the same moves, and no feed rate may be higher.
[[maybe_unused]] void refeed(const std::string_view text) {
  FeedRewriter rewriter({});
  Interpreter before, after;
  int number = 0;
  for (size_t at = 0; at < text.size() && !before.ended(); number++) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    const Result<std::string> written = rewriter.rewrite(line, number, number % 3 == 0 ? 0.37 : 1);
    one_sentence(written);
    if (!written) return;
    const Result<GcodeLine> old_words = parse_gcode(line), words = parse_gcode(written.value());
    if (!old_words || !words) {
      // With the new word, a long line may exceed the limit.
      if (line.size() + 20 > kMaxGcodeLine) return;
      std::abort();
    }
    std::vector<CanonMove> old_moves, moves;
    if (!before.run(old_words.value(), number, old_moves) ||
        !after.run(words.value(), number, moves) || moves.size() != old_moves.size())
      std::abort();
    for (size_t i = 0; i < moves.size(); i++) {
      const auto *const one = std::get_if<FeedMove>(&old_moves[i].action),
                        *const other = std::get_if<FeedMove>(&moves[i].action);
      if (moves[i].action.index() != old_moves[i].action.index() ||
          (one && (!(one->to == other->to) || other->feed.value > one->feed.value * 1.000001)))
        std::abort();
    }
  }
}

// Decodes a tile, carves it, and extracts its surface.
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

// Decodes the content of a cell of a document. The first byte selects the kind. Some kinds are
// compressed. For these, the input is compressed here, because a fuzzer does not find valid
// compressed data.
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
  // The input is also the content of the file that a buffer names.
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
  refeed(text);
#elif defined(KIBORI_FUZZ_MILL_JOB)
  mill_job(text);
#elif defined(KIBORI_FUZZ_MILL_TOOLS)
  mill_tools(std::string(text));
#elif defined(KIBORI_FUZZ_MILL_MACHINE)
  mill_machine(std::string(text));
#elif defined(KIBORI_FUZZ_DOCUMENT)
  document(bytes);
#elif defined(KIBORI_FUZZ_CELL)
  cell(data, size);
#else
#error "a folder of fuzz/corpus has no reader here"
#endif
  return 0;
}
