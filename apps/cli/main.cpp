// SPDX-License-Identifier: MIT
// The command line, a thin layer over the library. Data goes to stdout, everything else to stderr.
// Bad input exits with status 2.
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include <kibori/base/file.h>
#include <kibori/run/carving.h>
#include <kibori/body/body_surface.h>
#include <kibori/document/document.h>
#include <kibori/report/convert.h>
#include <kibori/run/documents.h>
#include <kibori/report/export.h>
#include <kibori/report/force_report.h>
#include <kibori/report/import_report.h>
#include <kibori/report/mesh_report.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/measure/distance.h>
#include <kibori/picture/picture.h>
#include <kibori/solid/tool.h>
#include <kibori/surface/surface.h>

#include "apps/cli/common.h"
#include "apps/cli/document_commands.h"
#include "apps/cli/gcode_command.h"
#include "apps/cli/mill_command.h"
#include "apps/cli/outputs.h"
#include "apps/cli/servo_commands.h"
#include "apps/cli/studio_command.h"

namespace {

// Returns the tool shapes as the text of a TOML comment, whose further lines begin in column
// `indent`.
std::string shape_list(size_t indent) {
  std::string text;
  size_t column = indent;
  for (const std::string shape : kibori::kToolShapes) {
    if (column + shape.size() > 90) {
      text += "\n" + std::string(indent, ' ') + "#";
      column = indent;
    }
    text += " " + shape;
    column += shape.size() + 1;
  }
  return text;
}

// Options of `carve --picture` and `picture`.
struct PictureArguments {
  std::string view = "iso", size = "1280x960", look = "wood", up = "auto";
  int samples = 48, threads = all_cores();
};

void add_picture_options(CLI::App* command, PictureArguments& arguments) {
  command
      ->add_option("--view", arguments.view,
                   "iso, front, back, left, right, top, bottom, or a viewing direction X,Y,Z")
      ->capture_default_str();
  command->add_option("--size", arguments.size, "width and height of the picture in pixels")
      ->type_name("WxH")
      ->capture_default_str();
  command
      ->add_option(
          "--up", arguments.up,
          "axis that points up in the picture; auto: the axis that the studio's import proposes")
      ->check(CLI::IsMember({"auto", "x", "y", "z"}))
      ->capture_default_str();
  command
      ->add_option("--look", arguments.look,
                   "wood: rings and grain in the material's colour; plain: its colour alone")
      ->check(CLI::IsMember({"wood", "plain"}))
      ->capture_default_str();
  command
      ->add_option(
          "--samples", arguments.samples,
          "paths per pixel at edges; elsewhere a twelfth of them, and the light is smoothed")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
}

kibori::Result<kibori::PictureOptions> picture_options(const PictureArguments& arguments) {
  using namespace kibori;
  PictureOptions options;
  char rest = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &options.width, &options.height, &rest) != 2)
    return Error{"--size '" + arguments.size + "' must be like 1280x960"};
  Vec3 direction;
  if (const std::optional<Vec3> view = view_named(arguments.view)) {
    options.view = *view;
  } else if (std::sscanf(arguments.view.c_str(), "%lf,%lf,%lf%c", &direction.x(), &direction.y(),
                         &direction.z(), &rest) == 3 &&
             direction.allFinite() && direction.norm() > 1e-9 && direction.norm() < 1e9) {
    options.view = direction;
  } else {
    return Error{
        "--view '" + arguments.view +
        "' must be iso, front, back, left, right, top, bottom or a direction like -1,1,-0.8"};
  }
  options.look = arguments.look == "wood" ? Look::wood : Look::plain;
  options.samples = arguments.samples;
  options.threads = arguments.threads;
  options.progress = [](double share) { show_progress("drawing", share); };
  return options;
}

// Rotates a point so that axis `up` becomes z.
template <class T>
void turn_up(const std::string& up, std::array<T, 3>& p) {
  const auto [x, y, z] = p;
  if (up == "y") p = {x, -z, y};
  if (up == "x") p = {-z, y, x};
}

kibori::Status save_picture(const std::string& path, kibori::Surface surface,
                            const std::vector<kibori::Rgb>& colors, kibori::PictureOptions options,
                            const std::string& up) {
  using namespace kibori;
  for (SurfaceVertex& v : surface.vertices) {
    turn_up(up, v.position);
    turn_up(up, v.normal);
  }
  if (options.plank) {
    Box turned;
    for (const Vec3& corner : {options.plank->min, options.plank->max}) {
      std::array<double, 3> p{corner.x(), corner.y(), corner.z()};
      turn_up(up, p);
      turned.include(Vec3(p[0], p[1], p[2]));
    }
    options.plank = turned;
  }
  const Result<Image> image = draw_picture(surface, colors, options);
  if (!image) return Error{path + ": " + image.error()};
  return write_png_rgb(path, image.value().width, image.value().height, image.value().pixels);
}

kibori::Status check_picture(const std::string& path) {
  if (kibori::ending_of(path) != ".png")
    return kibori::Error{path + ": is not a picture's name; name a file that ends in .png"};
  return kibori::Ok{};
}

// Outputs of a model in addition to a mesh, or instead of one. `carve` and `convert` use them.
struct ExportArguments {
  std::string height_map, layers, layer_format = "svg";
  double layer = 0.2, tolerance = 0;
};

void add_export_options(CLI::App* command, ExportArguments& arguments) {
  command
      ->add_option("--tolerance", arguments.tolerance,
                   "use fewer triangles; the surface stays within this distance")
      ->type_name("MM")
      ->check(kPositive);
  command
      ->add_option("--height-map", arguments.height_map,
                   "write heights seen from above as 16-bit grey")
      ->type_name("FILE.png");
  command->add_option("--layers", arguments.layers, "write cross-sections from below into a folder")
      ->type_name("FOLDER");
  command->add_option("--layer", arguments.layer, "distance between layers")
      ->type_name("MM")
      ->check(kPositive)
      ->capture_default_str();
  command
      ->add_option("--layer-format", arguments.layer_format,
                   "svg: outlines; png: black and white, one pixel per node")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
}

kibori::Status check_exports(const ExportArguments& arguments) {
  using namespace kibori;
  if (!arguments.height_map.empty()) {
    if (ending_of(arguments.height_map) != ".png")
      return Error{arguments.height_map +
                   ": is not a picture's name; name a file that ends in .png"};
  }
  if (arguments.layers.empty()) return Ok{};
  std::error_code error;
  std::filesystem::path there = std::filesystem::absolute(arguments.layers, error);
  if (std::filesystem::exists(there, error) && !std::filesystem::is_directory(there, error))
    return Error{arguments.layers + ": is a file; name a folder for the layers"};
  while (!std::filesystem::exists(there, error) && there.has_relative_path())
    there = there.parent_path();
  if (access(there.c_str(), W_OK) != 0)
    return Error{arguments.layers + ": the folder is not writable; name another one"};
  return Ok{};
}

// Writes the requested exports. Reports each on stderr.
kibori::Status write_exports(const ExportArguments& arguments, const kibori::Snapshot& model,
                             int threads) {
  using namespace kibori;
  if (!arguments.height_map.empty()) {
    const Result<HeightMapSummary> map = write_height_map(arguments.height_map, model);
    if (!map) return Error{map.error()};
    std::fprintf(
        stderr,
        "%s: %d x %d pixels, %g mm each; grey 1 is z = %g mm, 65535 is %g mm, 0 is no material\n",
        arguments.height_map.c_str(), map.value().width, map.value().height, model.lattice.pitch_mm,
        map.value().low_mm, map.value().high_mm);
  }
  if (!arguments.layers.empty()) {
    LayerOptions options;
    options.layer_mm = arguments.layer;
    options.format = arguments.layer_format == "svg" ? LayerFormat::svg : LayerFormat::png;
    options.threads = threads;
    options.progress = [](double share) { show_progress("slicing", share); };
    const Result<int> layers = write_layers(arguments.layers, model, options);
    if (!layers) return Error{layers.error()};
    std::fprintf(stderr, "%s: %d layers\n", arguments.layers.c_str(), layers.value());
  }
  return Ok{};
}

std::string mesh_or_document() {
  return "mesh: " + kibori::list_of(kibori::kMeshesRead) + "; or a document: .kibori";
}

struct CarveArguments {
  std::string scene, forces, plot, mesh, picture, document;
  bool json = false, force = false, keep_forces = false;
  int threads = all_cores();
  PictureArguments drawing;
  ExportArguments exports;
};

std::string scene_in_short() {
  return "A scene in short:\n"
         "  [stock]\n"
         "  block = [80, 50, 30]     # mm; or mesh = \"part.stl\", sphere = r, cylinder = [r, "
         "height]\n"
         "  pitch = 0.25\n"
         "  [tool]\n"
         "  shape = \"finger\"         #" +
         shape_list(27) +
         "\n"
         "  ks = 0.1                 # 1/mm\n"
         "  length = 40\n"
         "  [force]\n"
         "  model = \"energy\"         # or \"series\", \"paper\"\n"
         "  [[move]]                 # the first move places the tool\n"
         "  to = [-10, 25, 28]\n"
         "  [[move]]\n"
         "  to = [90, 25, 22]\n"
         "  speed = 40               # mm/s\n"
         "Exit status: 0 done, 2 bad input (standard error says what, where and what to do).";
}

void add_carve(CLI::App& app, CarveArguments& arguments) {
  CLI::App* const command =
      app.add_subcommand("carve", "Run a scripted carving session and report forces");
  command->add_option("SCENE", arguments.scene, "scene file (TOML)")->required();
  command
      ->add_option("-o,--output", arguments.document,
                   "write a document while carving: stock, strokes and history; see 'kibori replay "
                   "--help'")
      ->type_name("FILE.kibori");
  command
      ->add_flag("--keep-forces", arguments.keep_forces,
                 "store force and moment of every tick in the document")
      ->needs("-o");
  command->add_option("--forces", arguments.forces, "write force and moment of every tick as CSV")
      ->type_name("FILE.csv");
  command->add_option("--plot", arguments.plot, "draw force and moment over time")
      ->type_name("FILE.svg");
  command
      ->add_option("--mesh", arguments.mesh,
                   "write the surface of the remaining material, closed and manifold, in mm")
      ->type_name("FILE" + kibori::list_of(kibori::kMeshesWritten, "|"));
  command->add_option("--picture", arguments.picture, "draw the remaining material, ray traced")
      ->type_name("FILE.png");
  add_picture_options(command, arguments.drawing);
  add_export_options(command, arguments.exports);
  command->add_flag("--json", arguments.json, "summary as JSON on standard output");
  command
      ->add_option("--threads", arguments.threads,
                   "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--force", arguments.force,
                    "accept a mesh as stock even if it is open along most rays");
  command->footer(scene_in_short());
}

// Reports outputs that cannot be written before the work begins.
kibori::Status check_outputs(const CarveArguments& arguments, const kibori::Scene& scene) {
  using namespace kibori;
  Outputs outputs;
  outputs.reads(arguments.scene);
  for (const std::filesystem::path& read : scene.files) outputs.reads(read);
  outputs.makes_document("-o", arguments.document);
  outputs.writes("--forces", arguments.forces);
  outputs.writes("--plot", arguments.plot);
  outputs.writes("--mesh", arguments.mesh);
  outputs.writes("--picture", arguments.picture);
  outputs.writes("--height-map", arguments.exports.height_map);
  outputs.writes_folder("--layers", arguments.exports.layers, "." + arguments.exports.layer_format);
  if (Status can = outputs.check(); !can) return can;
  if (Status can = check_exports(arguments.exports); !can) return can;
  if (!arguments.mesh.empty())
    if (Status known = check_surface_ending(arguments.mesh); !known) return known;
  if (!arguments.document.empty() && !is_document(arguments.document))
    return Error{arguments.document + ": documents are written as .kibori"};
  return arguments.picture.empty() ? Status(Ok{}) : check_picture(arguments.picture);
}

kibori::CarveOptions carve_options(const CarveArguments& arguments) {
  kibori::CarveOptions options;
  options.threads = arguments.threads;
  options.force = arguments.force;
  options.document = arguments.document;
  options.keep_forces = arguments.keep_forces;
  options.progress = [](double share) { show_progress("carving", share); };
  options.warning = [](const std::string& text) {
    std::fprintf(stderr, "\rkibori: warning: %s\n", text.c_str());
  };
  return options;
}

// Sets the colours and rings of the materials, and what the rings depend on.
void set_materials(kibori::PictureOptions& picture, std::vector<kibori::Rgb>& colors,
                   const std::vector<kibori::Material>& materials, const kibori::Lattice& lattice) {
  for (const kibori::Material& material : materials) {
    colors.push_back(material.color);
    picture.contrasts.push_back(kibori::ring_contrast(material.name));
  }
  picture.log = kibori::log_cut_of(materials);
  picture.plank = lattice.to_mm(lattice.base());
}

// Writes all requested outputs except the document. `picture` holds the options of --picture.
kibori::Status write_outputs(const CarveArguments& arguments, const kibori::Scene& scene,
                             const kibori::Carving& carving, kibori::PictureOptions picture) {
  using namespace kibori;
  if (!arguments.forces.empty())
    if (Status ok = write_text(arguments.forces, forces_csv(carving)); !ok) return ok;
  if (!arguments.plot.empty()) {
    const ForceLaw& law = scene.force.law;
    const std::string title = std::filesystem::path(arguments.scene).stem().string() +
                              ": force and moment, model " + model_title(law);
    if (Status ok = write_text(arguments.plot, forces_svg(carving, title, model_note(law.model)));
        !ok)
      return ok;
  }
  std::vector<Rgb> colors;
  const Snapshot model = carving.model->snapshot();
  set_materials(picture, colors, scene.materials, model.lattice);
  if (!arguments.picture.empty())
    if (Status ok =
            save_picture(arguments.picture, surface_of(carving.bodies.all, arguments.threads),
                         colors, picture, arguments.drawing.up);
        !ok)
      return ok;
  if (!arguments.mesh.empty()) {
    const Result<size_t> written = write_bodies(arguments.mesh, carving.bodies.all, colors,
                                                arguments.exports.tolerance, arguments.threads);
    if (!written) return Error{written.error()};
  }
  return write_exports(arguments.exports, model, arguments.threads);
}

int run_carve(const CarveArguments& arguments) {
  using namespace kibori;
  Result<Scene> scene = read_scene(arguments.scene);
  if (!scene) return bad_input(scene.error());
  if (const Status can = check_outputs(arguments, scene.value()); !can)
    return bad_input(can.error());
  Result<PictureOptions> picture = PictureOptions{};
  if (!arguments.picture.empty()) {
    picture = picture_options(arguments.drawing);
    if (!picture) return bad_input(picture.error());
    picture.value().threads = arguments.threads;
  }
  const Result<Carving> carving = carve(scene.value(), carve_options(arguments));
  if (!carving) return bad_input(carving.error());
  if (const Status ok = write_outputs(arguments, scene.value(), carving.value(), picture.value());
      !ok)
    return bad_input(ok.error());
  const std::string summary = arguments.json ? summary_json(carving.value().summary)
                                             : summary_text(carving.value().summary);
  std::fputs(summary.c_str(), stdout);
  if (!carving.value().unsaved.empty()) return bad_input(carving.value().unsaved);
  return written();
}

struct ConvertArguments {
  std::string in, out, relief;
  double pitch = 0;
  bool force = false;
  int threads = all_cores();
  ExportArguments exports;
};

CLI::App* add_convert(CLI::App& app, ConvertArguments& arguments) {
  CLI::App* const command = app.add_subcommand(
      "convert", "Repair and remesh: convert a mesh into dexels and back, closed and manifold");
  command->add_option("IN", arguments.in, "file to read: " + mesh_or_document())->required();
  command->add_option("OUT", arguments.out,
                      "mesh to write: " + kibori::list_of(kibori::kMeshesWritten));
  command
      ->add_option(
          "--relief", arguments.relief,
          "IN is a grey PNG: width, height of white above black, and base below black, in mm")
      ->type_name("W,H,B");
  add_export_options(command, arguments.exports);
  command
      ->add_option("--pitch", arguments.pitch,
                   "distance between rays; default: a 256th of the longest side")
      ->type_name("MM")
      ->check(kPositive);
  command
      ->add_option("--threads", arguments.threads,
                   "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--force", arguments.force, "accept a mesh even if it is open along most rays");
  return command;
}

int run_convert(const ConvertArguments& arguments) {
  using namespace kibori;
  if (arguments.out.empty() && arguments.exports.height_map.empty() &&
      arguments.exports.layers.empty())
    return bad_input("convert: nothing to write; name a mesh, or use --height-map or --layers");
  if (!arguments.out.empty())
    if (const Status known = check_surface_ending(arguments.out); !known)
      return bad_input(known.error());
  Outputs outputs;
  outputs.reads(arguments.in);
  outputs.writes("OUT", arguments.out);
  outputs.writes("--height-map", arguments.exports.height_map);
  outputs.writes_folder("--layers", arguments.exports.layers, "." + arguments.exports.layer_format);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  if (const Status can = check_exports(arguments.exports); !can) return bad_input(can.error());
  ConvertOptions options;
  if (arguments.pitch != 0) options.pitch_mm = arguments.pitch;
  options.threads = arguments.threads;
  options.force = arguments.force;
  options.warning = [](const std::string& text) {
    std::fprintf(stderr, "kibori: warning: %s\n", text.c_str());
  };
  if (!arguments.relief.empty() || ending_of(arguments.in) == ".png") {
    ReliefSize size;
    char rest = 0;
    if (std::sscanf(arguments.relief.c_str(), "%lf,%lf,%lf%c", &size.width_mm, &size.height_mm,
                    &size.base_mm, &rest) != 3 ||
        !(size.width_mm > 0 && size.height_mm > 0 && size.base_mm > 0) ||
        !std::isfinite(size.width_mm + size.height_mm + size.base_mm))
      return bad_input(
          "--relief must be three positive numbers of mm, width,height,base, like 80,5,3");
    options.relief = size;
  }
  const Result<Converted> converted = into_dexels(arguments.in, options);
  if (!converted) return bad_input(converted.error());
  const Snapshot model = converted.value().model->snapshot();
  std::printf("pitch        %.6g mm\nvolume       %.6g mm3\n", converted.value().pitch_mm,
              model.volume_mm3());
  if (!arguments.out.empty()) {
    const Result<size_t> triangles =
        write_model(arguments.out, model, {}, arguments.exports.tolerance, arguments.threads);
    if (!triangles) return bad_input(triangles.error());
    std::printf("triangles    %zu in, %zu out\n", converted.value().triangles_in,
                triangles.value());
  }
  if (const Status ok = write_exports(arguments.exports, model, arguments.threads); !ok)
    return bad_input(ok.error());
  return written();
}

struct InfoArguments {
  std::string file;
  double wall = 1, overhang = 45, pitch = 0;
  int threads = all_cores();
  bool json = false;
};

CLI::App* add_info(CLI::App& app, InfoArguments& arguments) {
  CLI::App* const command = app.add_subcommand(
      "info", "Measure a mesh: size, volume, area, closed, manifold, thin walls, overhangs");
  command->add_option("FILE", arguments.file, mesh_or_document())->required();
  command->add_flag("--json", arguments.json, "as JSON");
  command->add_option("--wall", arguments.wall, "report walls thinner than this")
      ->type_name("MM")
      ->check(kPositive)
      ->capture_default_str();
  command
      ->add_option("--overhang", arguments.overhang,
                   "report downward faces that lean from the vertical by more than this")
      ->type_name("DEG")
      ->check(CLI::Range(0.0, 90.0))
      ->capture_default_str();
  command
      ->add_option("--pitch", arguments.pitch,
                   "pitch of the dexels that find thin walls; default: a 256th of the longest side")
      ->type_name("MM")
      ->check(kPositive);
  command->add_option("--threads", arguments.threads, "threads to work with")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  return command;
}

int run_info(const InfoArguments& arguments) {
  using namespace kibori;
  MeshReportOptions options;
  options.wall_mm = arguments.wall;
  options.overhang_deg = arguments.overhang;
  options.threads = arguments.threads;
  if (arguments.pitch != 0) options.pitch_mm = arguments.pitch;
  const Result<MeshReport> report = report_mesh(arguments.file, options);
  if (!report) return bad_input(report.error());
  std::fputs((arguments.json ? mesh_report_json(report.value()) : mesh_report_text(report.value()))
                 .c_str(),
             stdout);
  return written();
}

// Reads a mesh or a document to draw or compare. Warns about content that was not read or may be
// missing in the file.
kibori::Result<kibori::TriangleMesh> read_for_looking(const std::string& file, int threads) {
  using namespace kibori;
  std::vector<std::string> notes;
  Result<TriangleMesh> mesh = read_mesh_or_document(file, threads, &notes);
  for (const std::string& note : notes) std::fprintf(stderr, "kibori: warning: %s\n", note.c_str());
  return mesh;
}

struct CompareArguments {
  std::string a, b;
  int64_t samples = 1000000;
  int threads = all_cores();
  bool json = false;
};

CLI::App* add_compare(CLI::App& app, CompareArguments& arguments) {
  CLI::App* const command = app.add_subcommand(
      "compare", "Distance between two meshes in both directions: maximum and root mean square");
  command->add_option("A", arguments.a, mesh_or_document())->required();
  command->add_option("B", arguments.b, mesh_or_document())->required();
  command
      ->add_option("--samples", arguments.samples,
                   "number of points on each surface, in addition to its vertices")
      ->check(CLI::Range(int64_t{1}, int64_t{1000000000}))
      ->capture_default_str();
  command->add_option("--threads", arguments.threads, "threads to work with")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_flag("--json", arguments.json, "as JSON");
  return command;
}

int run_compare(const CompareArguments& arguments) {
  using namespace kibori;
  Surface surfaces[2];
  for (int i = 0; i < 2; i++) {
    const Result<TriangleMesh> mesh =
        read_for_looking(i == 0 ? arguments.a : arguments.b, arguments.threads);
    if (!mesh) return bad_input(mesh.error());
    surfaces[i] = surface_of_mesh(mesh.value());
  }
  const Result<TwoSided> distance =
      two_sided_distance(surfaces[0], surfaces[1], arguments.samples, arguments.threads);
  if (!distance) return bad_input(distance.error());
  const TwoSided& d = distance.value();
  if (arguments.json)
    std::printf(
        "{\"max_mm\":%.9g,\"rms_mm\":%.9g,\"a_to_b\":{\"max_mm\":%.9g,\"rms_mm\":%.9g},"
        "\"b_to_a\":{\"max_mm\":%.9g,\"rms_mm\":%.9g}}\n",
        d.max(), d.rms(), d.there.max, d.there.rms, d.back.max, d.back.rms);
  else
    std::printf(
        "distance     max %.4g mm, rms %.4g mm\nA to B       max %.4g mm at %.6g, %.6g, %.6g; rms "
        "%.4g mm\n"
        "B to A       max %.4g mm at %.6g, %.6g, %.6g; rms %.4g mm\n",
        d.max(), d.rms(), d.there.max, d.there.at.x(), d.there.at.y(), d.there.at.z(), d.there.rms,
        d.back.max, d.back.at.x(), d.back.at.y(), d.back.at.z(), d.back.rms);
  return written();
}

struct PictureCommandArguments {
  std::string file, out;
  PictureArguments drawing;
};

CLI::App* add_picture(CLI::App& app, PictureCommandArguments& arguments) {
  CLI::App* const command = app.add_subcommand(
      "picture", "Draw a mesh or document: ray traced, soft shadows, wood or plain");
  command->add_option("FILE", arguments.file, mesh_or_document())->required();
  command->add_option("OUT", arguments.out, "picture to write: .png")->required();
  add_picture_options(command, arguments.drawing);
  command->add_option("--threads", arguments.drawing.threads, "threads to work with")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  return command;
}

// Of a mesh, and of a document that states no material.
constexpr kibori::Rgb kPlainColor{196, 150, 100};

// Draws all bodies of a document with their materials and paint.
kibori::Status draw_document(const PictureCommandArguments& arguments,
                             kibori::PictureOptions options) {
  using namespace kibori;
  const Result<std::unique_ptr<Document>> opened =
      Document::open(arguments.file, Document::Access::read);
  if (!opened) return Error{opened.error()};
  const Document& document = *opened.value();
  for (const std::string& note : document_notes(document))
    std::fprintf(stderr, "kibori: warning: %s\n", note.c_str());
  // Its error says which steps of a damaged document are whole.
  if (const auto model = model_at_head(document); !model) return Error{model.error()};
  const Result<BodyList> bodies = document.load_bodies(document.head());
  if (!bodies) return Error{bodies.error()};
  Surface surface = surface_of(bodies.value().all, arguments.drawing.threads);
  if (surface.triangles.empty())
    return Error{document.name() +
                 ": there is no material left; undo the last step or choose an earlier one"};
  std::vector<Rgb> colors;
  set_materials(options, colors, document_materials(document), document.lattice());
  if (colors.empty()) colors.push_back(kPlainColor);
  return save_picture(arguments.out, std::move(surface), colors, options, arguments.drawing.up);
}

int run_picture(const PictureCommandArguments& arguments) {
  using namespace kibori;
  if (const Status can = check_picture(arguments.out); !can) return bad_input(can.error());
  Outputs outputs;
  outputs.reads(arguments.file);
  outputs.writes("OUT", arguments.out);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  const Result<PictureOptions> options = picture_options(arguments.drawing);
  if (!options) return bad_input(options.error());
  if (is_document(arguments.file)) {
    const Status saved = draw_document(arguments, options.value());
    return saved ? 0 : bad_input(saved.error());
  }
  const Result<TriangleMesh> mesh = read_for_looking(arguments.file, arguments.drawing.threads);
  if (!mesh) return bad_input(mesh.error());
  std::string up = arguments.drawing.up;
  if (up == "auto") {
    const Orientation own = guess_up(ending_of(arguments.file), mesh.value()).orientation;
    up = signed_axis_text(own.up);
    up = up.substr(up.find_first_of("xyz"), 1);
  }
  const Status saved = save_picture(arguments.out, surface_of_mesh(mesh.value()), {kPlainColor},
                                    options.value(), up);
  return saved ? 0 : bad_input(saved.error());
}

// Minimum limit of the stack size. Every new thread gets a stack of the limit, and carving and
// parsing need a part of it.
constexpr rlim_t kMinStackBytes = rlim_t{1} << 20;

// The terminate handler. It runs, for example, if a thread has no memory or cannot start. A
// document contains everything up to the last flush, as after a kill.
[[noreturn]] void end_with_a_sentence() {
  const char* reason = "unknown error; please report it with the command that you ran";
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    reason =
        "out of memory; an open document contains everything so far. Use a coarser pitch or a "
        "smaller stock";
  } catch (const std::system_error&) {
    reason =
        "the system allows no more threads; an open document contains everything so far. Raise the "
        "limit with 'ulimit -u'";
  } catch (...) {
    // Keep the general message.
  }
  std::fprintf(stderr, "kibori: stopped: %s\n", reason);
  std::_Exit(2);
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the file size limit then fails like one on a
                                  // full disk
  std::set_terminate(end_with_a_sentence);
  rlimit stack{};
  if (getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur < kMinStackBytes)
    return bad_input("the stack is limited to " + std::to_string(stack.rlim_cur / 1024) +
                     " kB, and at least 1024 kB are needed; raise the limit with 'ulimit -s'");
  CLI::App app{
      "Kibori carves virtual solids with a virtual finger or cutter and computes the force of "
      "every removal."};
  app.name("kibori");
  app.set_version_flag("--version", std::string("kibori ") + KIBORI_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Try:\n"
      "  kibori carve examples/fig8-upright.toml --plot forces.svg\n"
      "docs/scenes.md explains scenes. 'kibori COMMAND --help' explains a command.");

  CarveArguments carve_arguments;
  add_carve(app, carve_arguments);
  ConvertArguments convert_arguments;
  const CLI::App* const convert = add_convert(app, convert_arguments);
  InfoArguments info_arguments;
  const CLI::App* const info = add_info(app, info_arguments);
  CompareArguments compare_arguments;
  const CLI::App* const compare = add_compare(app, compare_arguments);
  PictureCommandArguments picture_arguments;
  const CLI::App* const picture = add_picture(app, picture_arguments);
  const MillCommand mill(app);
  const GcodeCommand gcode(app);
  ServoCommands by_hand(app);
  DocumentCommands documents(app);
  StudioCommand in_the_browser(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // --help and --version also end here.
    if (error.get_exit_code() == 0) return app.exit(error, std::cout, std::cerr);
    return bad_input(std::string(error.what()) + "; see 'kibori --help'");
  }
  try {
    if (documents.given()) return documents.run();
    if (by_hand.given()) return by_hand.run();
    if (mill.given()) return mill.run();
    if (gcode.given()) return gcode.run();
    if (in_the_browser.given()) return in_the_browser.run();
    if (*convert) return run_convert(convert_arguments);
    if (*info) return run_info(info_arguments);
    if (*compare) return run_compare(compare_arguments);
    if (*picture) return run_picture(picture_arguments);
    return run_carve(carve_arguments);
  } catch (const std::bad_alloc&) {
    return bad_input("out of memory; use a coarser pitch or a smaller stock");
  } catch (const std::exception& error) {
    return bad_input(error.what());
  }
}
