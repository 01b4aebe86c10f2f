// SPDX-License-Identifier: MIT
#include "apps/cli/mill_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <kibori/formats/mesh_format.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/surface_file.h>
#include <kibori/geometry/wood.h>
#include <kibori/mill/machining.h>
#include <kibori/picture/picture.h>
#include <kibori/report/convert.h>
#include <kibori/report/export.h>
#include <kibori/report/mill_report.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling_plan.h>
#include <kibori/run/milling_target.h>
#include <kibori/surface/surface.h>

#include "apps/cli/outputs.h"

using namespace kibori;

namespace {

// Exit status of --strict if there is a collision or a gouge.
constexpr int kCollided = 3;

const char* const kFooter =
    "Examples:\n"
    "  kibori mill part.nc --stock 0,0,-20,80,80,0 --tools tools.toml --mesh part.stl\n"
    "  kibori mill job.camotics --picture part.png\n"
    "  kibori mill job.toml -o part.kibori\n"
    "The stock is a block from its lower to its upper corner, in the program's coordinates (G54), "
    "a mesh,\n"
    "or a document. docs/milling.md explains G-code, tool tables, machine files and job files.\n"
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

MillCommand::MillCommand(CLI::App& app) {
  command_ = app.add_subcommand(
      "mill", "Run programs of a milling machine: G-code to a solid, collisions and forces");
  command_
      ->add_option(
          "PROGRAM", programs_,
          "G-code, a listing of LinuxCNC's rs274 -g, a job of CAMotics (.camotics), or a job "
          "file (.toml) with several set-ups")
      ->required();
  command_
      ->add_option("--stock", stock_,
                   "a block X0,Y0,Z0,X1,Y1,Z1 in mm, a mesh, or a document, whose current state "
                   "becomes the stock")
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
                   "of the target: smaller gouges are not listed; by default the pitch")
      ->type_name("MM")
      ->check(kPositive);
  command_
      ->add_option(
          "--map", map_,
          "write the result, coloured by its deviation from the target: blue where material is "
          "missing, red where too much is left")
      ->type_name("FILE.ply|.obj|.3mf|.glb|.png");
  command_
      ->add_option("--fixture", fixtures_,
                   "a clamp or another part that the tool may not touch; may be repeated")
      ->type_name("MESH");
  command_
      ->add_option("--lines", lines_, "write removed volume, engagement and force of every line")
      ->type_name("FILE.csv");
  command_
      ->add_option(
          "--feed-for", feed_for_,
          "limits for --feed-to: the maximum force (force=N) and power (power=W) of each line, and "
          "the lowest and highest feed rate (min=, max= in mm/min)")
      ->type_name("force=N,...")
      ->delimiter(',');
  command_
      ->add_option(
          "--feed-to", feed_to_,
          "write the program with feed rates that stay within the limits of --feed-for; nothing "
          "else changes")
      ->type_name("FILE");
  command_
      ->add_option("-o,--output", document_,
                   "write a document: a step for each tool, with the line of every move")
      ->type_name("FILE.kibori");
  command_->add_flag(
      "--z-only", z_only_,
      "edit the z field only: faster. Reports volumes and collisions of a machine with "
      "three axes; no mesh can be written");
  command_->add_flag("--strict", strict_,
                     "exit with status 3 if anything collides or the target is gouged");
  command_->add_flag("--json", json_, "summary as JSON on standard output");
  command_
      ->add_option("--threads", threads_, "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command_->footer(kFooter);
}

Result<MillPlan> MillCommand::make_plan() const {
  MillRequest request;
  request.programs.assign(programs_.begin(), programs_.end());
  if (const auto box = parse_box(stock_))
    request.stock = *box;
  else if (!stock_.empty())
    request.stock = std::filesystem::path(stock_);
  request.tools = tools_;
  request.machine = machine_;
  request.fixtures.assign(fixtures_.begin(), fixtures_.end());
  request.target = target_;
  if (tool_ > 0) request.tool = tool_;
  if (pitch_ > 0) request.pitch_mm = pitch_;
  if (tolerance_ > 0) request.tolerance_mm = tolerance_;
  if (command_->count("--material") > 0) request.material = material_;
  request.threads = threads_;
  request.z_only = z_only_;
  request.forces = !lines_.empty();
  if (!feed_for_.empty()) {
    request.feed_limits.emplace();
    for (const std::string& one : feed_for_)
      if (const Status ok = set_feed_limit(*request.feed_limits, one); !ok)
        return Error{ok.error()};
  }
  request.warning = warn;
  return plan_milling(request);
}

Status MillCommand::check_outputs(const MillPlan& plan) const {
  Outputs outputs;
  for (const std::string& name : programs_) outputs.reads(name);
  outputs.reads(tools_);
  outputs.reads(machine_);
  if (const auto* path = std::get_if<std::filesystem::path>(&*plan.stock)) outputs.reads(*path);
  for (const MillSetup& setup : plan.setups) {
    for (const auto& program : setup.programs) outputs.reads(program);
    for (const auto& fixture : setup.fixture_files) outputs.reads(fixture);
    outputs.reads(setup.target_file);
  }
  outputs.makes_document("-o", document_);
  outputs.writes("--mesh", mesh_);
  outputs.writes("--picture", picture_);
  outputs.writes("--lines", lines_);
  outputs.writes("--map", map_);
  outputs.writes("--feed-to", feed_to_);
  if (const Status can = outputs.check(); !can) return can;
  if (z_only_ && !(mesh_.empty() && picture_.empty() && document_.empty() && !plan.has_target()))
    return Error{
        "--z-only computes no surface; omit it to write a mesh, picture or document, or to compare "
        "with a target"};
  if (!plan.has_target() && (!map_.empty() || tolerance_ > 0))
    return Error{"--map and --tolerance need the part to compare with; give it with --target"};
  if (const Status ok = check_feeds(plan); !ok) return ok;
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

Status MillCommand::check_feeds(const MillPlan& plan) const {
  if (feed_for_.empty() != feed_to_.empty())
    return Error{
        "--feed-for and --feed-to need each other, as in --feed-for force=50 --feed-to new.nc"};
  if (feed_for_.empty()) return Ok{};
  const FeedLimits& limits = *plan.setups.front().options.feed_limits;
  if (!std::isfinite(limits.force_n) && !std::isfinite(limits.power_w))
    return Error{"--feed-for needs a limit, force=N or power=W"};
  if (limits.max_mm_min && *limits.max_mm_min < limits.min_mm_min)
    return Error{"--feed-for has a max below min; exchange them"};
  if (plan.setups.size() != 1 || plan.setups.front().programs.size() != 1)
    return Error{
        "--feed-for changes one program; mill the earlier ones with -o and use that document as "
        "--stock"};
  return Ok{};
}

// Writes what is left, coloured by its deviation from the target.
Status MillCommand::write_map(const MillPlan& plan, const MillSetup& setup, Surface& left) const {
  paint_deviation(left, *setup.report);
  if (ending_of(map_) == ".png") return draw(plan, map_, left);
  return write_surface(map_, [&](const SurfaceSink& sink) { send_surface(left, sink); }, {});
}

Status MillCommand::draw(const MillPlan& plan, const std::string& file,
                         const Surface& surface) const {
  PictureOptions options;
  options.view = *view_named(view_);
  options.threads = threads_;
  const Lattice& lattice = plan.model->lattice();
  options.plank = lattice.to_mm(lattice.base());
  options.progress = [](double share) { show_progress("drawing", share); };
  std::vector<Rgb> colors;
  for (const Material& material : plan.materials) {
    colors.push_back(material.color);
    options.contrasts.push_back(ring_contrast(material.name));
  }
  const Result<Image> image = draw_picture(surface, colors, options);
  if (!image) return Error{file + ": " + image.error()};
  const Image& drawn = image.value();
  return write_png_rgb(file, drawn.width, drawn.height, drawn.pixels);
}

Status MillCommand::write_outputs(const MillPlan& plan) const {
  std::vector<Rgb> colors;
  for (const Material& material : plan.materials) colors.push_back(material.color);
  const Snapshot model = plan.model->snapshot();
  if (!mesh_.empty()) {
    const Result<size_t> written = write_model(mesh_, model, colors, 0, threads_);
    if (!written) return Error{written.error()};
  }
  if (!picture_.empty()) return draw(plan, picture_, extract_surface(model, threads_));
  return Ok{};
}

Status MillCommand::run_programs(MillPlan& plan, std::optional<FeedPlan>& feeds) const {
  std::optional<NewFile> lines;
  MillPlanOptions options;
  options.document = document_;
  if (!lines_.empty()) {
    lines.emplace(lines_);
    lines->write(mill_lines_header());
  }
  if (!feed_to_.empty()) feeds.emplace(*plan.setups.front().options.feed_limits);
  if (lines || feeds)
    options.line = [&](const MillLine& line) {
      if (lines) lines->write(mill_line_csv(line));
      if (feeds) feeds->add(line);
    };
  if (!map_.empty())
    options.compared = [&](const MillSetup& setup, Surface& left) {
      return write_map(plan, setup, left);
    };
  Status done = run_plan(plan, options);
  if (done && lines) done = lines->commit();
  if (done && feeds) {
    const MillSetup& setup = plan.setups.front();
    done = feeds->write(setup.programs.front(), feed_to_, setup.options.machine.controller);
  }
  return done;
}

int MillCommand::run() const {
  Result<MillPlan> made = make_plan();
  if (!made) return bad_input(made.error());
  MillPlan& plan = made.value();
  if (const Status ok = check_outputs(plan); !ok) return bad_input(ok.error());
  if (const Status ok = make_models(plan); !ok) return bad_input(ok.error());
  std::optional<FeedPlan> feeds;
  if (const Status ok = run_programs(plan, feeds); !ok) return bad_input(ok.error());
  if (const Status ok = write_outputs(plan); !ok) return bad_input(ok.error());
  bool bad = false;
  for (const MillSetup& setup : plan.setups)
    bad |= !setup.summary.collisions.empty() || (setup.report && setup.report->gouged());
  std::vector<MillResult> results = results_of(plan);
  if (feeds) results.front().feeds = &feeds->report();
  std::fputs((json_ ? mill_json(results) : mill_text(results)).c_str(), stdout);
  const int status = written();
  return status == 0 && strict_ && bad ? kCollided : status;
}
