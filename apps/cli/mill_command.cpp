// SPDX-License-Identifier: MIT
#include "apps/cli/mill_command.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <kibori/formats/mesh_format.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/geometry/wood.h>
#include <kibori/mill/tool_table.h>
#include <kibori/picture/picture.h>
#include <kibori/report/convert.h>
#include <kibori/report/export.h>
#include <kibori/report/mill_report.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling.h>
#include <kibori/run/milling_target.h>
#include <kibori/run/workpiece.h>
#include <kibori/surface/surface.h>

#include "apps/cli/outputs.h"

using namespace kibori;

namespace {

// Exit status of --strict if there is a collision or a gouge.
constexpr int kCollided = 3;
// Default pitch: the longest side of the stock divided by this.
constexpr double kDefaultCells = 256;

const char* const kFooter =
    "Examples:\n"
    "  kibori mill part.nc --stock 0,0,-20,80,80,0 --tools tools.toml --mesh part.stl\n"
    "  kibori mill job.camotics --picture part.png\n"
    "The stock is a block from its lower to its upper corner, in the program's coordinates (G54), "
    "a mesh,\n"
    "or a document. docs/milling.md explains G-code, tool tables and machine files.\n"
    "Exit status: 0 done, 2 bad input, 3 a collision or a gouge with --strict.";

std::optional<Box> parse_box(const std::string& text) {
  double n[6];
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &n[0], &n[1], &n[2], &n[3], &n[4],
                  &n[5], &rest) != 6)
    return std::nullopt;
  return Box{Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])};
}

void warn(const std::string& text) {
  std::fprintf(stderr, "kibori: warning: %s\n", sanitize_message(text).c_str());
}

}  // namespace

struct MillCommand::Job {
  std::vector<std::filesystem::path> programs;
  std::optional<MillStock> stock;
  std::optional<double> pitch_mm;
  MillOptions options;
  std::unique_ptr<TriDexel> model, fixtures;
  std::vector<Material> materials;
  std::optional<MillTarget> target;
  std::optional<TargetReport> report;
  Surface map;  // what is left, painted by its deviation from the target
};

MillCommand::MillCommand(CLI::App& app) {
  command_ = app.add_subcommand(
      "mill", "Run programs of a milling machine: G-code to a solid, collisions and forces");
  command_
      ->add_option("PROGRAM", programs_,
                   "G-code, a listing of LinuxCNC's rs274 -g, or a job of CAMotics (.camotics)")
      ->required();
  command_
      ->add_option("--stock", stock_,
                   "a block X0,Y0,Z0,X1,Y1,Z1 in mm, a mesh, or a document with its result")
      ->type_name("BLOCK|FILE");
  command_->add_option("--tools", tools_, "tool table: .tbl of LinuxCNC, .camotics or .toml")
      ->type_name("FILE");
  command_->add_option("--tool", tool_, "number of the tool that is in the spindle at the start")
      ->check(CLI::Range(1, 99999));
  command_->add_option("--machine", machine_, "machine file: rotary axes, rapid speeds, offsets")
      ->type_name("FILE.toml");
  command_
      ->add_option("--pitch", pitch_,
                   "size of a cell; default: the job's resolution, or the stock's longest side "
                   "divided by 256")
      ->type_name("MM")
      ->check(kPositive);
  command_->add_option("--material", material_, "material of the stock, for forces and pictures")
      ->check(CLI::IsMember(machining_materials()))
      ->capture_default_str();
  command_
      ->add_option("--mesh", mesh_,
                   "write the surface of the remaining material, closed and manifold, in mm")
      ->type_name("FILE" + list_of(kMeshesWritten, "|"));
  command_->add_option("--picture", picture_, "draw the remaining material, ray traced")
      ->type_name("FILE.png");
  command_
      ->add_option("--view", view_,
                   "view of the picture: iso, front, back, left, right, top, bottom")
      ->check(CLI::IsMember({"iso", "front", "back", "left", "right", "top", "bottom"}))
      ->capture_default_str();
  command_
      ->add_option("--target", target_, "the part to make: reports gouges and what is left over")
      ->type_name("MESH");
  command_
      ->add_option("--tolerance", tolerance_,
                   "of the target: smaller deviations are not reported; by default the pitch")
      ->type_name("MM")
      ->check(kPositive);
  command_
      ->add_option("--map", map_,
                   "write what is left, coloured: blue where the target misses material, red where "
                   "too much is left")
      ->type_name("FILE.ply|.obj|.3mf|.glb|.png");
  command_
      ->add_option("--fixture", fixtures_,
                   "a clamp or another part that the tool may not touch; may be repeated")
      ->type_name("MESH");
  command_
      ->add_option("--lines", lines_, "write removed volume, engagement and force of every line")
      ->type_name("FILE.csv");
  command_->add_option("-o,--output", document_, "write a document with the result")
      ->type_name("FILE.kibori");
  command_->add_flag("--z-only", z_only_,
                     "edit the z field only: faster, for volumes and collisions with three axes; "
                     "no mesh can be written");
  command_->add_flag("--strict", strict_,
                     "exit with status 3 if anything collides or the target is gouged");
  command_->add_flag("--json", json_, "summary as JSON on standard output");
  command_
      ->add_option("--threads", threads_, "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command_->footer(kFooter);
}

// Reads the programs, and the stock, tools and resolution of a CAMotics job.
Status MillCommand::read_programs(Job& job) const {
  for (const std::string& name : programs_) {
    if (ending_of(name) != ".camotics") {
      job.programs.emplace_back(name);
      continue;
    }
    Result<MillProject> project = read_camotics(name);
    if (!project) return Error{project.error()};
    MillProject& read = project.value();
    if (read.programs.empty()) return Error{name + ": 'files' has no program; add one"};
    job.programs.insert(job.programs.end(), read.programs.begin(), read.programs.end());
    if (!job.options.tools.tools.empty())
      return Error{name + ": is a second job; give one .camotics file, and name further programs"};
    job.options.tools = std::move(read.tools);
    if (read.workpiece_mm) job.stock = *read.workpiece_mm;
    job.pitch_mm = read.pitch_mm;
  }
  return Ok{};
}

Status MillCommand::prepare(Job& job) const {
  if (const Status ok = read_programs(job); !ok) return ok;
  if (!tools_.empty()) {
    Result<ToolTable> table = read_tools(tools_);
    if (!table) return Error{table.error()};
    job.options.tools = std::move(table.value());
  }
  for (const std::string& warning : job.options.tools.warnings) warn(warning);
  if (!machine_.empty()) {
    Result<Machine> machine = read_machine(machine_);
    if (!machine) return Error{machine.error()};
    job.options.machine = std::move(machine.value());
  }
  if (!stock_.empty()) {
    if (const auto box = parse_box(stock_))
      job.stock = *box;
    else
      job.stock = std::filesystem::path(stock_);
  }
  if (!job.stock)
    return Error{"there is no stock; give its corners, as in --stock 0,0,-20,80,80,0, or a file"};
  if (const Box* const box = std::get_if<Box>(&*job.stock); box && !(box->size().array() > 0).all())
    return Error{"--stock must be its lower corner and then its upper one: X0,Y0,Z0,X1,Y1,Z1"};
  job.options.material = *machining_material(material_);
  job.materials = {job.options.material};
  job.options.threads = threads_;
  job.options.z_only = z_only_;
  if (tool_ > 0) job.options.tool = tool_;
  job.options.forces = !lines_.empty();
  for (const MillTool& tool : job.options.tools.tools) job.options.forces |= tool.teeth > 0;
  return Ok{};
}

Status MillCommand::check_outputs(const Job& job) const {
  Outputs outputs;
  for (const auto& program : job.programs) outputs.reads(program);
  for (const std::string& name : programs_) outputs.reads(name);
  outputs.reads(tools_);
  outputs.reads(machine_);
  if (const auto* path = std::get_if<std::filesystem::path>(&*job.stock)) outputs.reads(*path);
  outputs.makes_document("-o", document_);
  outputs.writes("--mesh", mesh_);
  outputs.writes("--picture", picture_);
  outputs.writes("--lines", lines_);
  outputs.writes("--map", map_);
  outputs.reads(target_);
  for (const std::string& fixture : fixtures_) outputs.reads(fixture);
  if (const Status can = outputs.check(); !can) return can;
  if (z_only_ && !(mesh_.empty() && picture_.empty() && document_.empty() && target_.empty()))
    return Error{
        "--z-only computes no surface; omit it to write a mesh, picture or document, or to compare "
        "with a target"};
  if (target_.empty() && (!map_.empty() || tolerance_ > 0))
    return Error{"--map and --tolerance need the part to compare with; give it with --target"};
  if (!map_.empty() && ending_of(map_) != ".png") {
    if (const Status known = check_surface_ending(map_); !known) return known;
    if (ending_of(map_) == ".stl")
      return Error{map_ +
                   ": STL holds no colours; write the map as .ply, .obj, .3mf, .glb or .png"};
  }
  if (!mesh_.empty())
    if (const Status known = check_surface_ending(mesh_); !known) return known;
  if (!document_.empty() && !is_document(document_))
    return Error{document_ + ": documents are written as .kibori"};
  if (!picture_.empty() && ending_of(picture_) != ".png")
    return Error{picture_ + ": pictures are written as .png"};
  return Ok{};
}

// Makes the models of stock, fixtures and target, all on one lattice.
Status MillCommand::make_models(Job& job) const {
  MillStockOptions options;
  if (const Box* const box = std::get_if<Box>(&*job.stock))
    options.pitch_mm = box->size().maxCoeff() / kDefaultCells;
  if (job.pitch_mm) options.pitch_mm = *job.pitch_mm;
  if (pitch_ > 0) options.pitch_mm = pitch_;
  options.threads = threads_;
  options.warning = warn;
  std::vector<MillMesh> fixtures;
  std::optional<MillMesh> target;
  const auto read = [&](const std::string& file) -> Result<MillMesh> {
    Result<MillMesh> mesh = read_mill_mesh(file, warn);
    if (!mesh) return mesh;
    if (!options.holds) options.holds.emplace();
    const Box bounds = mesh.value().mesh.bounds();
    options.holds->include(bounds.min);
    options.holds->include(bounds.max);
    return mesh;
  };
  for (const std::string& file : fixtures_) {
    Result<MillMesh> mesh = read(file);
    if (!mesh) return Error{mesh.error()};
    fixtures.push_back(std::move(mesh.value()));
  }
  if (!target_.empty()) {
    Result<MillMesh> mesh = read(target_);
    if (!mesh) return Error{mesh.error()};
    target = std::move(mesh.value());
  }
  Result<std::unique_ptr<TriDexel>> model = make_mill_stock(*job.stock, options);
  if (!model) return Error{model.error()};
  job.model = std::move(model.value());
  if (!fixtures.empty()) {
    auto made = make_fixtures(fixtures, job.model->lattice(), threads_);
    if (!made) return Error{made.error()};
    job.fixtures = std::move(made.value());
    job.options.fixtures = job.fixtures.get();
  }
  if (target) {
    Result<MillTarget> made = make_target(*target, *job.model, threads_);
    if (!made) return Error{made.error()};
    job.target = std::move(made.value());
    job.options.target = job.target->model.get();
  }
  return Ok{};
}

Status MillCommand::compare(Job& job, const MillSummary& summary) const {
  if (!job.target) return Ok{};
  job.map = extract_surface(job.model->snapshot(), threads_);
  if (job.map.triangles.empty())
    return Error{"nothing is left to compare with " + target_ + "; check where the stock is"};
  Result<TargetReport> report =
      compare_with_target(summary, *job.target, job.map,
                          tolerance_ > 0 ? tolerance_ : job.model->lattice().pitch_mm, threads_);
  if (!report) return Error{report.error()};
  job.report = std::move(report.value());
  if (map_.empty()) return Ok{};
  paint_deviation(job.map, *job.report);
  if (ending_of(map_) == ".png") return draw(job, map_, job.map);
  return write_surface(map_, [&](const SurfaceSink& sink) { send_surface(job.map, sink); }, {});
}

Status MillCommand::draw(const Job& job, const std::string& file, const Surface& surface) const {
  PictureOptions options;
  options.view = *view_named(view_);
  options.threads = threads_;
  const Lattice& lattice = job.model->lattice();
  options.plank = lattice.to_mm(lattice.whole());
  options.progress = [](double share) { show_progress("drawing", share); };
  std::vector<Rgb> colors;
  for (const Material& material : job.materials) {
    colors.push_back(material.color);
    options.contrasts.push_back(ring_contrast(material.name));
  }
  const Result<Image> image = draw_picture(surface, colors, options);
  if (!image) return Error{file + ": " + image.error()};
  const Image& drawn = image.value();
  return write_png_rgb(file, drawn.width, drawn.height, drawn.pixels);
}

Status MillCommand::write_outputs(const Job& job) const {
  std::vector<Rgb> colors;
  for (const Material& material : job.materials) colors.push_back(material.color);
  const Snapshot model = job.model->snapshot();
  if (!mesh_.empty()) {
    const Result<size_t> written = write_model(mesh_, model, colors, 0, threads_);
    if (!written) return Error{written.error()};
  }
  if (!picture_.empty()) return draw(job, picture_, extract_surface(model, threads_));
  return Ok{};
}

int MillCommand::run() const {
  Job job;
  if (const Status ok = prepare(job); !ok) return bad_input(ok.error());
  if (const Status ok = check_outputs(job); !ok) return bad_input(ok.error());
  if (const Status ok = make_models(job); !ok) return bad_input(ok.error());

  std::optional<NewFile> lines;
  if (!lines_.empty()) {
    lines.emplace(lines_);
    lines->write(mill_lines_header());
    job.options.line = [&](const MillLine& line) { lines->write(mill_line_csv(line)); };
  }
  const Result<MillSummary> summary = run_milling(*job.model, job.programs, job.options);
  if (!summary) return bad_input(summary.error());
  if (lines)
    if (const Status ok = lines->commit(); !ok) return bad_input(ok.error());
  if (const Status ok = write_outputs(job); !ok) return bad_input(ok.error());
  if (const Status ok = compare(job, summary.value()); !ok) return bad_input(ok.error());
  const TargetReport* const report = job.report ? &*job.report : nullptr;
  std::fputs(
      (json_ ? mill_json(summary.value(), report) : mill_text(summary.value(), report)).c_str(),
      stdout);
  if (!document_.empty()) {
    auto piece = Workpiece::of(std::move(job.model), job.materials);
    if (!piece) return bad_input(piece.error());
    if (const Status ok = piece.value()->save(document_, false); !ok) return bad_input(ok.error());
  }
  const int status = written();
  const bool bad = !summary.value().collisions.empty() || (report && report->gouged());
  return status == 0 && strict_ && bad ? kCollided : status;
}
