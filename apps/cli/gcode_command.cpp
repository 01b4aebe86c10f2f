// SPDX-License-Identifier: MIT
#include "apps/cli/gcode_command.h"

#include <cstdio>
#include <memory>
#include <utility>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/document/document.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/surface_file.h>
#include <kibori/report/convert.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling.h>
#include <kibori/run/milling_feeds.h>

#include "apps/cli/outputs.h"

using namespace kibori;

namespace {

// Exit status of --strict if a stroke is missing.
constexpr int kUnreached = 3;

}  // namespace

GcodeCommand::GcodeCommand(CLI::App& app) {
  command_ = app.add_subcommand(
      "gcode", "Write strokes of a document as G-code for a milling machine with three axes");
  command_->add_option("DOCUMENT", document_, "a .kibori document")->required();
  command_->add_option("-o,--output", output_, "the program")->type_name("FILE")->required();
  command_->add_option("--tools", tools_, "write the tools of the program, for kibori mill")
      ->type_name("FILE.toml")
      ->required();
  command_->add_option("--stock", stock_, "write the material before the program, for kibori mill")
      ->type_name("FILE" + list_of(kMeshesWritten, "|"));
  command_->add_option("--steps", steps_, "only these steps: one number, or the first and the last")
      ->type_name("A[-B]");
  command_
      ->add_option("--clearance", options_.clearance_mm, "height of rapid moves above the stock")
      ->type_name("MM")
      ->check(kPositive)
      ->capture_default_str();
  command_->add_option("--feed", options_.feed_mm_min, "feed rate")
      ->type_name("MM/MIN")
      ->check(kPositive)
      ->capture_default_str();
  command_
      ->add_option("--force", force_n_,
                   "lower the feed rate of a line until its estimated force is below this")
      ->type_name("N")
      ->check(kPositive);
  command_->add_option("--rpm", options_.rpm, "spindle speed")
      ->type_name("1/MIN")
      ->check(kPositive)
      ->capture_default_str();
  command_->add_option("--teeth", options_.teeth, "teeth of every tool, for --force")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command_->add_flag("--strict", strict_, "exit with status 3 if a stroke is missing");
  command_->add_flag("--json", json_, "report as JSON on standard output");
  command_
      ->add_option("--threads", options_.threads,
                   "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256));
  options_.threads = all_cores();
  command_->footer(
      "Example: kibori gcode bowl.kibori -o bowl.ngc --tools bowl.toml --stock bowl.stl --force "
      "30\n"
      "Strokes that such a machine cannot make are listed with the reason: tilted tools, tools "
      "that "
      "are not round,\nbrushes, overhangs. docs/milling.md has more.\n"
      "Exit status: 0 done, 2 bad input, 3 a stroke is missing with --strict.");
}

Status GcodeCommand::read_steps(StrokeProgramOptions& options) const {
  if (steps_.empty()) return Ok{};
  long long first = 0, last = 0;
  char rest = 0;
  const int read = std::sscanf(steps_.c_str(), "%lld-%lld%c", &first, &last, &rest);
  const bool one = read == 1 && steps_.find('-') == std::string::npos;
  if (!(one || read == 2) || first < 1 || (!one && last < first))
    return Error{"--steps '" + steps_ + "' must be a step, or the first and the last, as in 2-5"};
  options.first = first;
  options.last = one ? first : last;
  return Ok{};
}

// Writes the program with feed rates that keep each line below --force where possible.
Status GcodeCommand::write_refed(const Document& document, const StrokeProgram& program) const {
  const auto folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const auto plain = folder.value()->path() / "program.ngc";
  NewFile file(plain);
  file.write(program.text);
  if (Status ok = file.commit(); !ok) return ok;
  FeedLimits limits;
  limits.force_n = force_n_;
  FeedPlan feeds(limits);
  MillOptions how;
  how.tools = program.tools;
  how.threads = options_.threads;
  how.forces = true;
  how.feed_limits = limits;
  const std::vector<Material> materials = document_materials(document);
  if (!materials.empty()) how.material = materials.front();
  if (!(mean_cutting_energy(how.material) > 0))
    return Error{document_ + ": its material has no cutting force; omit --force"};
  how.line = [&](const MillLine& line) { feeds.add(line); };
  TriDexel model(program.stock->snapshot(), program.stock->material_bounds());
  const Result<MillSummary> run = run_milling(model, {plain}, how);
  if (!run) return Error{run.error()};
  for (const int line : feeds.report().over)
    std::fprintf(stderr, "kibori: warning: %s:%d: exceeds %g N even at %g mm/min\n",
                 output_.c_str(), line, force_n_, limits.min_mm_min);
  return feeds.write(plain, output_, {});
}

Status GcodeCommand::write(const Document& document, const StrokeProgram& program) const {
  NewFile tools(tools_);
  tools.write(tools_toml(program.tools));
  if (force_n_ > 0) {
    if (Status ok = write_refed(document, program); !ok) return ok;
  } else {
    NewFile file(output_);
    file.write(program.text);
    if (Status ok = file.commit(); !ok) return ok;
  }
  if (!stock_.empty()) {
    const Result<size_t> stock = write_model(stock_, program.stock->snapshot(),
                                             document_colors(document), 0, options_.threads);
    if (!stock) return Error{stock.error()};
  }
  return tools.commit();
}

void GcodeCommand::report(const StrokeProgram& program) const {
  if (json_) {
    Json missing = Json::array();
    for (const UnreachedStroke& one : program.unreached)
      missing.push_back({{"step", one.step}, {"label", one.label}, {"reason", one.reason}});
    const Json all{{"strokes", program.strokes},
                   {"tools", program.tools.tools.size()},
                   {"missing", missing},
                   {"left_over_mm3", program.left_over_mm3}};
    std::fputs((all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n").c_str(), stdout);
    return;
  }
  std::printf("strokes      %lld written, %zu missing\ntools        %zu\nleft over    %.6g mm3\n",
              static_cast<long long>(program.strokes), program.unreached.size(),
              program.tools.tools.size(), program.left_over_mm3);
  for (const UnreachedStroke& one : program.unreached)
    std::printf("  step %lld%s%s: %s\n", static_cast<long long>(one.step),
                one.label.empty() ? "" : " ", sanitize_message(one.label).c_str(),
                one.reason.c_str());
}

int GcodeCommand::run() const {
  StrokeProgramOptions options = options_;
  if (Status ok = read_steps(options); !ok) return bad_input(ok.error());
  if (!is_document(document_))
    return bad_input(document_ + ": is not a document; name a .kibori file");
  Outputs outputs;
  outputs.reads(document_);
  outputs.writes("-o", output_);
  outputs.writes("--tools", tools_);
  outputs.writes("--stock", stock_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  if (!stock_.empty())
    if (const Status known = check_surface_ending(stock_); !known) return bad_input(known.error());
  if (ending_of(tools_) != ".toml") return bad_input(tools_ + ": tools are written as .toml");
  const auto document = Document::open(document_, Document::Access::read);
  if (!document) return bad_input(document.error());
  const Result<StrokeProgram> program = program_of_strokes(*document.value(), options);
  if (!program) return bad_input(program.error());
  if (Status ok = write(*document.value(), program.value()); !ok) return bad_input(ok.error());
  report(program.value());
  const int status = written();
  return status == 0 && strict_ && !program.value().unreached.empty() ? kUnreached : status;
}
