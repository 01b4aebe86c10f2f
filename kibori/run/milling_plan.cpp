// SPDX-License-Identifier: MIT
#include <kibori/run/milling_plan.h>

#include <algorithm>
#include <utility>

#include <kibori/base/file.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling_job.h>

namespace kibori {
namespace {

// Default pitch of a block: its longest side divided by this.
constexpr double kDefaultCells = 256;

void warn(const MillPlan& plan, const std::string& text) {
  if (plan.warning) plan.warning(text);
}

// Reads the names of the programs. A CAMotics job also gives stock, tools and pitch.
Status read_programs(const MillRequest& request, MillPlan& plan, MillSetup& setup) {
  for (const std::filesystem::path& name : request.programs) {
    if (ending_of(name) == ".toml")
      return Error{name.string() + ": a job file names its programs; give it alone"};
    if (ending_of(name) != ".camotics") {
      setup.programs.push_back(name);
      continue;
    }
    Result<MillProject> project = read_camotics(name);
    if (!project) return Error{project.error()};
    MillProject& read = project.value();
    if (read.programs.empty()) return Error{name.string() + ": 'files' has no program; add one"};
    setup.programs.insert(setup.programs.end(), read.programs.begin(), read.programs.end());
    if (!setup.options.tools.tools.empty())
      return Error{name.string() +
                   ": is a second job; give one .camotics file, and name further programs"};
    setup.options.tools = std::move(read.tools);
    if (read.workpiece_mm) plan.stock = *read.workpiece_mm;
    plan.pitch_mm = read.pitch_mm;
  }
  return Ok{};
}

// Makes the only set-up of a request without a job file.
Status read_single(const MillRequest& request, MillPlan& plan) {
  MillSetup setup;
  if (Status ok = read_programs(request, plan, setup); !ok) return ok;
  if (Status ok = read_mill_tables(request.tools, request.machine, setup.options); !ok) return ok;
  if (request.stock) plan.stock = request.stock;
  if (plan.model) plan.stock.reset();
  if (!plan.stock && !plan.model)
    return Error{"there is no stock; give its corners, as in --stock 0,0,-20,80,80,0, or a file"};
  if (plan.stock)
    if (const Box* const box = std::get_if<Box>(&*plan.stock);
        box && !(box->size().array() > 0).all())
      return Error{"the stock must be two corners, the lower one first: X0,Y0,Z0,X1,Y1,Z1"};
  setup.options.tool = request.tool;
  setup.fixture_files = request.fixtures;
  setup.target_file = request.target;
  plan.setups.push_back(std::move(setup));
  return Ok{};
}

Status read_job(const MillRequest& request, MillPlan& plan, std::string& material) {
  const std::filesystem::path& file = request.programs.front();
  for (const auto& [option, given] : {std::pair{"--stock", request.stock.has_value() || plan.model},
                                      {"--tools", !request.tools.empty()},
                                      {"--tool", request.tool.has_value()},
                                      {"--machine", !request.machine.empty()},
                                      {"--fixture", !request.fixtures.empty()},
                                      {"--target", !request.target.empty()}})
    if (given)
      return Error{file.string() + ": is a job file, which " + option +
                   " cannot change; change the stock in the job file"};
  Result<MillJob> read = read_mill_job(file);
  if (!read) return Error{read.error()};
  plan.stock = std::move(read.value().stock);
  plan.pitch_mm = read.value().pitch_mm;
  plan.tolerance_mm = read.value().tolerance_mm;
  if (read.value().material && !request.material) material = *read.value().material;
  for (MillJobSetup& from : read.value().setups) {
    MillSetup setup;
    setup.name = setup.options.name = sanitize_message(from.name);
    setup.programs = std::move(from.programs);
    setup.options.setup = from.frame;
    setup.options.tool = from.tool;
    if (Status ok = read_mill_tables(from.tools, from.machine, setup.options); !ok) return ok;
    setup.fixture_files = std::move(from.fixtures);
    setup.target_file = std::move(from.target);
    plan.setups.push_back(std::move(setup));
  }
  return Ok{};
}

Status unknown_material(const std::string& where, const std::string& name) {
  std::string known;
  for (const std::string& one : machining_materials()) known += (known.empty() ? "" : ", ") + one;
  return Error{where + "there is no material '" + sanitize_message(name) + "'; there are " + known};
}

// Reads a mesh in the coordinates of a set-up's programs, and adds its bounds to `holds`.
Result<MillMesh> read_mesh_of(const MillPlan& plan, const MillSetup& setup,
                              const std::filesystem::path& file, std::optional<Box>& holds) {
  Result<MillMesh> mesh = read_mill_mesh(file, [&](const std::string& text) { warn(plan, text); });
  if (!mesh) return mesh;
  MillMesh placed = in_model(std::move(mesh.value()), setup.options.setup);
  if (!holds) holds.emplace();
  const Box bounds = placed.mesh.bounds();
  holds->include(bounds.min);
  holds->include(bounds.max);
  return placed;
}

// Checks that the lattice of the caller's model contains fixtures and targets.
Status check_room(const TriDexel& model, const std::optional<Box>& holds) {
  if (!holds) return Ok{};
  const Box at = model.lattice().to_lattice(*holds).units;
  if ((at.min.array() >= 0).all() && (at.max.array() <= model.lattice().nodes.cast<double>()).all())
    return Ok{};
  return Error{
      "the fixtures or the target reach beyond the lattice of the stock; make the model "
      "with more room"};
}

Status run_setup(MillPlan& plan, MillSetup& setup, const MillPlanOptions& options) {
  const Result<MillSetupModels> models = make_setup_models(plan, setup);
  if (!models) return Error{models.error()};
  Result<MillSummary> summary = run_milling(*plan.model, setup.programs, setup.options);
  if (!summary) return Error{summary.error()};
  setup.summary = std::move(summary.value());
  if (!models.value().target) return Ok{};
  Result<Surface> left = compare_setup(plan, setup, *models.value().target);
  if (!left) return Error{left.error()};
  return options.compared ? options.compared(setup, left.value()) : Status(Ok{});
}

}  // namespace

bool MillPlan::has_target() const {
  return std::any_of(setups.begin(), setups.end(),
                     [](const MillSetup& setup) { return !setup.target_file.empty(); });
}

Status read_mill_tables(const std::filesystem::path& tools, const std::filesystem::path& machine,
                        MillOptions& options) {
  if (!tools.empty()) {
    Result<ToolTable> table = read_tools(tools);
    if (!table) return Error{table.error()};
    options.tools = std::move(table.value());
  }
  if (machine.empty()) return Ok{};
  Result<Machine> read = read_machine(machine);
  if (!read) return Error{read.error()};
  options.machine = std::move(read.value());
  return Ok{};
}

Result<MillPlan> plan_milling(const MillRequest& request, std::unique_ptr<TriDexel> model) {
  MillPlan plan;
  plan.model = std::move(model);
  plan.threads = request.threads;
  plan.warning = request.warning;
  std::string name = request.material.value_or(kMillMaterial);
  const bool is_job =
      request.programs.size() == 1 && ending_of(request.programs.front()) == ".toml";
  Status ok = is_job ? read_job(request, plan, name) : read_single(request, plan);
  if (!ok) return Error{ok.error()};
  if (request.pitch_mm) plan.pitch_mm = request.pitch_mm;
  if (request.tolerance_mm) plan.tolerance_mm = request.tolerance_mm;
  const Material* const material = machining_material(name);
  if (!material) {
    const bool of_job = is_job && !request.material;
    return Error{
        unknown_material(of_job ? request.programs.front().string() + ": " : "", name).error()};
  }
  plan.materials = {*material};
  for (MillSetup& setup : plan.setups) {
    MillOptions& options = setup.options;
    for (const std::string& warning : options.tools.warnings) warn(plan, warning);
    options.material = *material;
    options.threads = request.threads;
    options.z_only = request.z_only;
    options.forces = request.forces || request.feed_limits;
    options.feed_limits = request.feed_limits;
    for (const MillTool& tool : options.tools.tools) options.forces |= tool.teeth > 0;
  }
  return plan;
}

Status make_models(MillPlan& plan) {
  std::optional<Box> holds;
  for (MillSetup& setup : plan.setups) {
    for (const auto& file : setup.fixture_files) {
      Result<MillMesh> mesh = read_mesh_of(plan, setup, file, holds);
      if (!mesh) return Error{mesh.error()};
      setup.fixtures.push_back(std::move(mesh.value()));
    }
    if (setup.target_file.empty()) continue;
    Result<MillMesh> mesh = read_mesh_of(plan, setup, setup.target_file, holds);
    if (!mesh) return Error{mesh.error()};
    setup.target = std::move(mesh.value());
  }
  if (plan.model) return check_room(*plan.model, holds);
  MillStockOptions options;
  if (const Box* const box = std::get_if<Box>(&*plan.stock))
    options.pitch_mm = box->size().maxCoeff() / kDefaultCells;
  if (plan.pitch_mm) options.pitch_mm = *plan.pitch_mm;
  options.threads = plan.threads;
  options.holds = holds;
  options.warning = plan.warning;
  Result<std::unique_ptr<TriDexel>> model = make_mill_stock(*plan.stock, options);
  if (!model) return Error{model.error()};
  plan.model = std::move(model.value());
  if (const auto* path = std::get_if<std::filesystem::path>(&*plan.stock);
      path && is_document(*path))
    if (const auto document = Document::open(*path, Document::Access::read))
      if (auto materials = document_materials(*document.value()); !materials.empty())
        plan.materials = std::move(materials);
  return Ok{};
}

Result<MillSetupModels> make_setup_models(const MillPlan& plan, MillSetup& setup) {
  MillSetupModels models;
  if (!setup.fixtures.empty()) {
    auto made = make_fixtures(setup.fixtures, plan.model->lattice(), plan.threads);
    if (!made) return Error{made.error()};
    models.fixtures = std::move(made.value());
    setup.options.fixtures = models.fixtures.get();
  }
  if (setup.target) {
    Result<MillTarget> made = make_target(*setup.target, *plan.model, plan.threads);
    if (!made) return Error{made.error()};
    models.target = std::move(made.value());
    setup.options.target = models.target->model.get();
  }
  return models;
}

Result<Surface> compare_setup(const MillPlan& plan, MillSetup& setup, const MillTarget& target) {
  Surface left = extract_surface(plan.model->snapshot(), plan.threads);
  if (left.triangles.empty())
    return Error{"nothing is left to compare with " + target.name + "; check where the stock is"};
  Result<TargetReport> report =
      compare_with_target(setup.summary, target, left,
                          plan.tolerance_mm.value_or(plan.model->lattice().pitch_mm), plan.threads);
  if (!report) return Error{report.error()};
  setup.report = std::move(report.value());
  return left;
}

Status run_plan(MillPlan& plan, const MillPlanOptions& options) {
  std::optional<MillDocument> document;
  if (!options.document.empty())
    document.emplace(
        MillDocumentOptions{options.document, plan.materials, plan.threads, plan.warning});
  size_t earlier_programs = 0;
  Status done = Ok{};
  for (MillSetup& setup : plan.setups) {
    if (options.line)
      setup.options.line = [&](MillLine line) {
        line.program += earlier_programs;
        options.line(line);
      };
    setup.options.document = document ? &*document : nullptr;
    setup.options.tape = options.tape;
    setup.options.stop = options.stop;
    done = run_setup(plan, setup, options);
    // These pointers and the callback are valid only during this pass of the loop.
    setup.options.document = nullptr;
    setup.options.tape = nullptr;
    setup.options.stop = nullptr;
    setup.options.fixtures = setup.options.target = nullptr;
    setup.options.line = nullptr;
    if (!done) break;
    earlier_programs += setup.programs.size();
  }
  if (!document || (!done && !document->exists())) return done;
  Status kept = document->finish(*plan.model);
  if (done) return kept;
  warn(plan, kept ? options.document.string() + " holds the moves before the error" : kept.error());
  return done;
}

}  // namespace kibori
