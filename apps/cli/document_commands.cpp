// SPDX-License-Identifier: MIT
#include "apps/cli/document_commands.h"

#include <filesystem>

#include <kibori/report/body_report.h>
#include <kibori/report/convert.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/run/salvage.h>
#include <kibori/report/force_report.h>
#include <kibori/report/history.h>
#include <kibori/report/tick_records.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/rescue.h>
#include <kibori/formats/mesh_format.h>

#include "apps/cli/common.h"
#include "apps/cli/outputs.h"

using namespace kibori;

namespace {

void print_notes(const Document& document) {
  for (const std::string& note : document_notes(document))
    std::fprintf(stderr, "kibori: warning: %s\n", note.c_str());
}

}  // namespace

DocumentCommands::DocumentCommands(CLI::App& app) {
  add_replay(app);
  add_verify(app);
  add_history(app);
  add_bodies(app);
  add_export(app);
}

void DocumentCommands::add_file(CLI::App& command) {
  command.add_option("FILE", file_, "document: .kibori")->required();
}

void DocumentCommands::add_to(CLI::App& command) {
  command.add_option("--to", to_, "a version's name or a step's number; default: the current step")
      ->type_name("VERSION|STEP");
}

void DocumentCommands::add_threads(CLI::App& command) {
  command
      .add_option("--threads", threads_, "threads to work with; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
}

void DocumentCommands::add_replay(CLI::App& app) {
  replay_ = app.add_subcommand("replay",
                               "Carve a document's strokes again: with identical results, at "
                               "another pitch, or with another force model");
  add_file(*replay_);
  add_to(*replay_);
  replay_->add_option("--pitch", pitch_, "carve the same strokes at another pitch")
      ->type_name("MM")
      ->check(kPositive);
  replay_
      ->add_option("--model", model_,
                   "compute the forces of the same motion by another force model")
      ->check(CLI::IsMember({"paper", "energy"}));
  replay_->add_option("--dof", dof_, "degrees of freedom of --model")
      ->check(CLI::IsMember({5, 6}))
      ->capture_default_str();
  replay_->add_option("--forces", forces_, "write force and moment of every tick as CSV")
      ->type_name("FILE.csv");
  replay_->add_option("--plot", plot_, "draw force and moment over time")->type_name("FILE.svg");
  replay_->add_option("--mesh", mesh_, "write the surface of the remaining material")
      ->type_name("FILE" + list_of(kMeshesWritten, "|"));
  replay_->add_flag("--json", json_, "summary as JSON on standard output");
  add_threads(*replay_);
  replay_->footer("Exit status: 0 the model is the recorded one, 1 it differs, 2 bad input.");
}

void DocumentCommands::add_verify(CLI::App& app) {
  verify_ = app.add_subcommand(
      "verify",
      "Check everything in a document: its structure, tiles, and every stroke carved again");
  add_file(*verify_);
  verify_->footer(
      "Exit status: 0 no differences, 1 differences (one line each says what and where), 2 bad "
      "input.");
}

void DocumentCommands::add_history(CLI::App& app) {
  history_ = app.add_subcommand("history", "List the steps and named versions of a document");
  add_file(*history_);
  history_->add_option("--name", name_, "name a version: the head, or the step of --at");
  history_->add_option("--at", at_, "with --name: a version's name or a step's number")
      ->type_name("VERSION|STEP")
      ->needs("--name");
  history_->add_option("--copy", copy_, "write the whole history into a new, compacted document")
      ->type_name("FILE.kibori");
  history_
      ->add_option("--salvage", salvage_,
                   "carve the undamaged steps of a damaged document again, into a new document")
      ->type_name("FILE.kibori");
  history_->add_flag("--json", json_, "as JSON");
}

void DocumentCommands::add_bodies(CLI::App& app) {
  bodies_ = app.add_subcommand(
      "bodies", "List the bodies of a document: volume, bounds, and whether the surface is closed");
  add_file(*bodies_);
  add_to(*bodies_);
  bodies_
      ->add_option("--export", mesh_,
                   "write the bodies to one file; 3MF, GLB and OBJ keep each as an object")
      ->type_name("FILE" + list_of(kMeshesWritten, "|"));
  bodies_->add_option("--body", body_, "only the body with this name or number")
      ->type_name("NAME|NUMBER");
  add_threads(*bodies_);
  bodies_->add_flag("--json", json_, "as JSON: a list, an object for each body");
  bodies_
      ->add_option("--act", act_,
                   "first apply this action as a new step: JSON as in 'kibori history --json', "
                   "such as '{\"verb\":\"mirror\",\"bodies\":[1],\"cutter\":{\"point_mm\":[0,0,0],"
                   "\"normal\":[1,0,0]}}'")
      ->type_name("JSON")
      ->excludes("--to");
  bodies_
      ->add_option(
          "--revise", revise_,
          "with --act: replace the action of this step; the later steps are repeated after it")
      ->type_name("VERSION|STEP")
      ->needs("--act");
}

void DocumentCommands::add_export(CLI::App& app) {
  export_ = app.add_subcommand("export",
                               "Write every tick of a document for research: poses of hand and "
                               "tool, forces, removed volume");
  add_file(*export_);
  export_->add_option("--csv", csv_, "text; its first line describes the source as JSON")
      ->type_name("FILE.csv");
  export_->add_option("--mcap", mcap_, "JSON messages for Foxglove and @mcap/core")
      ->type_name("FILE.mcap");
  export_->add_option("--hdf5", hdf5_, "tables for h5py and other readers")->type_name("FILE.h5");
  add_to(*export_);
  export_->footer("docs/recordings.md has the columns. Exit status: 0 written, 2 bad input.");
}

int DocumentCommands::run() const {
  if (*replay_) return run_replay();
  if (*bodies_) return run_bodies();
  if (*export_) return run_export();
  return *verify_ ? run_verify() : run_history();
}

int DocumentCommands::run_export() const {
  Outputs outputs;
  outputs.reads(file_);
  outputs.writes("--csv", csv_);
  outputs.writes("--mcap", mcap_);
  outputs.writes("--hdf5", hdf5_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  if (csv_.empty() && mcap_.empty() && hdf5_.empty())
    return bad_input("export: nothing to write; give --csv, --mcap or --hdf5");
  Result<std::unique_ptr<Document>> document = Document::open(file_, Document::Access::read);
  if (!document) return bad_input(document.error());
  print_notes(*document.value());
  StepId to = document.value()->head();
  if (!to_.empty()) {
    const Result<StepId> found = document.value()->find(to_);
    if (!found) return bad_input(found.error());
    to = found.value();
  }
  using Write = Status (*)(const std::filesystem::path&, const Document&, StepId);
  for (const auto& [path, write] : {std::pair<std::string, Write>{csv_, write_ticks_csv},
                                    {mcap_, write_ticks_mcap},
                                    {hdf5_, write_ticks_hdf5}})
    if (!path.empty())
      if (const Status done = write(path, *document.value(), to); !done)
        return bad_input(done.error());
  return 0;
}

int DocumentCommands::run_replay() const {
  Outputs outputs;
  outputs.reads(file_);
  outputs.writes("--forces", forces_);
  outputs.writes("--plot", plot_);
  outputs.writes("--mesh", mesh_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  if (!mesh_.empty())
    if (const Status known = check_surface_ending(mesh_); !known) return bad_input(known.error());
  Result<std::unique_ptr<Document>> document = Document::open(file_, Document::Access::read);
  if (!document) return bad_input(document.error());
  print_notes(*document.value());
  ReplayOptions options;
  options.to = to_;
  if (pitch_ > 0) options.pitch_mm = pitch_;
  if (!model_.empty())
    options.law = ForceLaw{value_of<ForceModel>(model_).value_or(ForceModel::energy), dof_};
  options.carve.threads = threads_;
  options.carve.progress = [](double share) { show_progress("carving", share); };
  options.carve.warning = [](const std::string& text) {
    std::fprintf(stderr, "\rkibori: warning: %s\n", text.c_str());
  };
  Result<Replay> replayed = replay_document(*document.value(), options);
  if (!replayed) return bad_input(replayed.error());
  const Replay& replay = replayed.value();
  if (!forces_.empty())
    if (const Status ok = write_text(forces_, forces_csv(replay.carving)); !ok)
      return bad_input(ok.error());
  if (!plot_.empty()) {
    const std::string title = std::filesystem::path(file_).stem().string() +
                              ": force and moment, model " + model_title(replay.law);
    if (const Status ok =
            write_text(plot_, forces_svg(replay.carving, title, model_note(replay.law.model)));
        !ok)
      return bad_input(ok.error());
  }
  if (!mesh_.empty()) {
    const Result<size_t> out = write_bodies(mesh_, replay.carving.bodies.all,
                                            document_colors(*document.value()), 0, threads_);
    if (!out) return bad_input(out.error());
  }
  const CarveSummary& summary = replay.carving.summary;
  std::fputs((json_ ? summary_json(summary) : summary_text(summary)).c_str(), stdout);
  if (replay.differs != 0) {
    std::fprintf(stderr,
                 "kibori: %s: step %lld differs from the recorded model when it is carved again; "
                 "run 'kibori verify' for details\n",
                 file_.c_str(), static_cast<long long>(replay.differs));
    return 1;
  }
  return written();
}

int DocumentCommands::run_bodies() const {
  Outputs outputs;
  outputs.reads(file_);
  outputs.writes("--export", mesh_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  if (!mesh_.empty())
    if (const Status known = check_surface_ending(mesh_); !known) return bad_input(known.error());
  if (!act_.empty())
    if (const Status acted = act_on_bodies(); !acted) return bad_input(acted.error());
  Result<std::unique_ptr<Document>> opened = Document::open(file_, Document::Access::read);
  if (!opened) return bad_input(opened.error());
  const Document& document = *opened.value();
  print_notes(document);
  StepId at = document.head();
  if (!to_.empty()) {
    const Result<StepId> found = document.find(to_);
    if (!found) return bad_input(found.error());
    at = found.value();
  }
  Result<BodyList> bodies = document.load_bodies(at);
  if (!bodies) return bad_input(bodies.error());
  std::vector<Body> some = bodies.value().all;
  if (!body_.empty()) {
    std::erase_if(some, [&](const Body& body) {
      return body.name != body_ && std::to_string(body.id) != body_;
    });
    if (some.empty())
      return bad_input(file_ + ": has no body '" + sanitize_message(body_) + "'; 'kibori bodies " +
                       file_ + "' lists them");
  }
  if (!mesh_.empty()) {
    const Result<size_t> out = write_bodies(mesh_, some, document_colors(document), 0, threads_);
    if (!out) return bad_input(out.error());
  }
  const Result<std::vector<BodyReport>> reports =
      report_bodies(some, bodies.value(), document_materials(document), threads_);
  if (!reports) return bad_input(reports.error());
  std::fputs((json_ ? bodies_json_text : bodies_text)(reports.value()).c_str(), stdout);
  return written();
}

Status DocumentCommands::act_on_bodies() const {
  const Result<BodyAction> action = action_from_json(act_);
  if (!action) return Error{"--act: " + action.error()};
  Result<std::unique_ptr<Document>> opened = Document::open(file_, Document::Access::write);
  if (!opened) return Error{opened.error()};
  Document& document = *opened.value();
  print_notes(document);
  if (const auto model = document.load(); !model) return Error{model.error()};
  if (revise_.empty()) {
    const Result<BodyChange> done = document.act(action.value(), threads_);
    if (!done) return Error{file_ + ": " + done.error()};
  } else {
    const Result<StepId> step = document.find(revise_);
    if (!step) return Error{step.error()};
    if (Status done = document.revise(step.value(), action.value(), threads_); !done) return done;
  }
  const std::string elsewhere = settle(document);
  return elsewhere.empty() ? Status(Ok{}) : Status(Error{elsewhere});
}

int DocumentCommands::run_verify() const {
  Result<std::unique_ptr<Document>> document = Document::open(file_, Document::Access::read);
  if (!document) return bad_input(document.error());
  int wrongs = 0;
  const Status done = document.value()->verify(
      [&](const std::string& wrong) {
        std::printf("%s\n", sanitize_message(wrong).c_str());
        wrongs++;
      },
      [](double share) { show_progress("verifying", share); },
      [](const std::string& note) { std::printf("note: %s\n", sanitize_message(note).c_str()); });
  if (!done) return bad_input(done.error());
  if (wrongs == 0)
    std::printf("verified: %zu steps, %zu versions, no differences\n",
                document.value()->steps().size(), document.value()->versions().size());
  const int status = written();
  return status != 0 ? status : wrongs != 0;
}

int DocumentCommands::run_history() const {
  Outputs outputs;
  outputs.reads(file_);
  outputs.makes_document("--copy", copy_);
  outputs.makes_document("--salvage", salvage_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  Result<std::unique_ptr<Document>> opened =
      Document::open(file_, name_.empty() ? Document::Access::read : Document::Access::write);
  if (!opened) return bad_input(opened.error());
  Document& document = *opened.value();
  print_notes(document);
  if (const Status rows = document.check_rows(document.head()); !rows)
    std::fprintf(stderr, "kibori: warning: %s\n", rows.error().c_str());
  if (!name_.empty()) {
    StepId at = document.head();
    if (!at_.empty()) {
      const Result<StepId> found = document.find(at_);
      if (!found) return bad_input(found.error());
      at = found.value();
    }
    if (const Status named = document.name_version(name_, at); !named)
      return bad_input(named.error());
    if (const std::string where = settle(document); !where.empty()) return bad_input(where);
  }
  if (!copy_.empty()) {
    if (!is_document(copy_))
      return bad_input(copy_ + ": is not a document's name; name a file that ends in .kibori");
    if (const Status copied = document.save_copy(copy_); !copied) return bad_input(copied.error());
  }
  if (!salvage_.empty()) {
    if (!is_document(salvage_))
      return bad_input(salvage_ + ": is not a document's name; name a file that ends in .kibori");
    const Result<StepId> saved = salvage(document, salvage_);
    if (!saved) return bad_input(saved.error());
    std::fprintf(stderr, "%s: saved up to step %lld of %lld\n", sanitize_message(salvage_).c_str(),
                 static_cast<long long>(saved.value()),
                 static_cast<long long>(document.head_in_file()));
  }
  std::fputs((json_ ? history_json(document) : history_text(document)).c_str(), stdout);
  return written();
}
