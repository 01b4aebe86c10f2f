// SPDX-License-Identifier: MIT
// The command line: a thin face on the library. Data on stdout, everything else on stderr; exit 2 for bad
// input.
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>

#include <kibori/base/file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/session/carving.h>
#include <kibori/session/convert.h>
#include <kibori/session/force_report.h>
#include <kibori/surface/surface.h>

namespace {

constexpr int kBadInput = 2;

int bad_input(const std::string& what) {
  std::fprintf(stderr, "kibori: %s\n", what.c_str());
  return kBadInput;
}

struct CarveArguments {
  std::string scene, forces, plot, mesh;
  bool json = false, force = false;
  int threads = 1;
};

kibori::Status write_text(const std::string& path, const std::string& text) {
  kibori::NewFile file(path);
  file.write(text);
  return file.commit();
}

int run_carve(const CarveArguments& arguments) {
  using namespace kibori;
  Result<Scene> scene = read_scene(arguments.scene);
  if (!scene) return bad_input(scene.error());

  // Outputs that can't be written are better known before the work than after.
  for (const std::string& out : {arguments.forces, arguments.plot, arguments.mesh}) {
    if (out.empty()) continue;
    const std::filesystem::path folder = std::filesystem::path(out).parent_path();
    std::error_code error;
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
      return bad_input(out + ": the folder " + folder.string() + " does not exist");
    if (access(folder.empty() ? "." : folder.c_str(), W_OK) != 0)
      return bad_input(out + ": the folder can't be written to");
    if (std::filesystem::is_directory(out, error)) return bad_input(out + ": is a folder; name a file");
  }

  if (!arguments.mesh.empty())
    if (const Status known = check_surface_ending(arguments.mesh); !known) return bad_input(known.error());

  CarveOptions options;
  options.threads = arguments.threads;
  options.force = arguments.force;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  int shown = -1;
  options.progress = [&](double share) {
    const int percent = static_cast<int>(100 * share);
    if (terminal && percent != shown)
      std::fprintf(stderr, "\rcarving %3d %%%s", shown = percent, share >= 1 ? "\n" : "");
  };
  options.warning = [&](const std::string& text) {
    std::fprintf(stderr, "%skibori: warning: %s\n", shown >= 0 && shown < 100 ? "\n" : "", text.c_str());
  };
  const Result<Carving> carving = carve(scene.value(), options);
  if (!carving) return bad_input(carving.error());

  if (!arguments.forces.empty())
    if (const Status ok = write_text(arguments.forces, forces_csv(carving.value())); !ok)
      return bad_input(ok.error());
  if (!arguments.plot.empty()) {
    const ForceLaw& law = scene.value().force;
    const std::string title =
        std::filesystem::path(arguments.scene).stem().string() + ": force and moment, model " +
        (law.model == ForceModel::paper ? "paper" : "energy") + ", " + std::to_string(law.dof) + " DOF";
    if (const Status ok = write_text(arguments.plot, forces_svg(carving.value(), title)); !ok)
      return bad_input(ok.error());
  }
  if (!arguments.mesh.empty()) {
    std::vector<std::array<uint8_t, 3>> colors;
    for (const Material& material : scene.value().materials) colors.push_back(material.color);
    const Surface surface = extract_surface(carving.value().model->snapshot(), arguments.threads);
    if (const Status ok = write_surface(arguments.mesh, surface, colors); !ok) return bad_input(ok.error());
  }
  const std::string summary =
      arguments.json ? summary_json(carving.value().summary) : summary_text(carving.value().summary);
  std::fputs(summary.c_str(), stdout);
  return std::fflush(stdout) == 0 ? 0 : bad_input("standard output can't be written");
}

struct ConvertArguments {
  std::string in, out;
  double pitch = 0;
  bool force = false;
  int threads = 1;
};

int run_convert(const ConvertArguments& arguments) {
  using namespace kibori;
  ConvertOptions options;
  if (arguments.pitch != 0) options.pitch_mm = arguments.pitch;
  options.threads = arguments.threads;
  options.force = arguments.force;
  options.warning = [](const std::string& text) {
    std::fprintf(stderr, "kibori: warning: %s\n", text.c_str());
  };
  const Result<ConvertSummary> done = convert(arguments.in, arguments.out, options);
  if (!done) return bad_input(done.error());
  const ConvertSummary& s = done.value();
  std::printf("pitch        %.6g mm\ntriangles    %zu in, %zu out\nvolume       %.6g mm3\n", s.pitch_mm,
              s.triangles_in, s.triangles_out, s.volume_mm3);
  return std::fflush(stdout) == 0 ? 0 : bad_input("standard output can't be written");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Kibori carves virtual solids with a virtual finger or cutter and feels every removal as force."};
  app.name("kibori");
  app.set_version_flag("--version", std::string("kibori ") + KIBORI_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Try:\n"
      "  kibori carve examples/fig8-upright.toml --plot forces.svg\n"
      "Scenes are explained in docs/scenes.md; 'kibori COMMAND --help' explains a command.");

  CarveArguments carve_arguments;
  CLI::App* carve = app.add_subcommand("carve", "Run a scripted carving session and report forces");
  carve->add_option("SCENE", carve_arguments.scene, "scene file (TOML)")->required();
  carve->add_option("--forces", carve_arguments.forces, "write force and moment of every tick as CSV")
      ->type_name("FILE.csv");
  carve->add_option("--plot", carve_arguments.plot, "draw force and moment over time")->type_name("FILE.svg");
  carve
      ->add_option("--mesh", carve_arguments.mesh,
                   "write the surface of what is left, closed and manifold, in mm")
      ->type_name("FILE.stl|ply|obj");
  carve->add_flag("--json", carve_arguments.json, "summary as JSON on standard output");
  carve
      ->add_option("--threads", carve_arguments.threads,
                   "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  carve->add_flag("--force", carve_arguments.force,
                  "take a mesh as stock even if most of its rays find it open");
  carve->footer(
      "A scene in short:\n"
      "  [stock]\n"
      "  block = [80, 50, 30]     # mm; or mesh = \"part.stl\", sphere = r, cylinder = [r, height]\n"
      "  pitch = 0.25\n"
      "  [tool]\n"
      "  shape = \"finger\"         # finger ball flat bull cone capsule halfspace box ellipsoid mesh\n"
      "  ks = 0.1                 # 1/mm\n"
      "  length = 40\n"
      "  [force]\n"
      "  model = \"energy\"         # or \"paper\"\n"
      "  [[move]]                 # the first gives the start\n"
      "  to = [-10, 25, 28]\n"
      "  [[move]]\n"
      "  to = [90, 25, 22]\n"
      "  speed = 40               # mm/s\n"
      "Exit status: 0 done, 2 bad input (one sentence on standard error says what and where).");

  ConvertArguments convert_arguments;
  CLI::App* convert =
      app.add_subcommand("convert", "Repair and remesh: a mesh into dexels and back, closed and manifold");
  convert->add_option("IN", convert_arguments.in, "mesh to read: .stl, .ply, .obj")->required();
  convert->add_option("OUT", convert_arguments.out, "mesh to write: .stl, .ply, .obj")->required();
  convert
      ->add_option("--pitch", convert_arguments.pitch, "size of a cell; by default the longest side by 256")
      ->type_name("MM")
      ->check(CLI::PositiveNumber);
  convert
      ->add_option("--threads", convert_arguments.threads,
                   "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  convert->add_flag("--force", convert_arguments.force, "take a mesh even if most of its rays find it open");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, std::cout, std::cerr);  // --help, --version
    return bad_input(std::string(error.what()) + "; see 'kibori --help'");
  }
  try {
    return *convert ? run_convert(convert_arguments) : run_carve(carve_arguments);
  } catch (const std::bad_alloc&) {
    return bad_input("out of memory; use a coarser pitch or a smaller stock");
  }
}
