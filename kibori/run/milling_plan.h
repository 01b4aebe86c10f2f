// SPDX-License-Identifier: MIT
// Reads everything that milling needs from files: programs, stock, tools, machine, fixtures,
// targets. The command `kibori mill` and kibori.mill of the Python module run the same plan.
//
//   MillRequest ─► plan_milling ─► MillPlan ─► make_models ─► run_plan
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/material.h>
#include <kibori/run/milling.h>
#include <kibori/run/milling_document.h>
#include <kibori/run/milling_target.h>
#include <kibori/surface/surface.h>

namespace kibori {

// What the user asks for.
struct MillRequest {
  // Programs and at most one job of CAMotics, or a single job file (.toml). A job file states
  // stock, tools, machine, fixtures and target itself.
  std::vector<std::filesystem::path> programs;
  std::optional<MillStock> stock;
  std::filesystem::path tools, machine, target;  // empty: none
  std::vector<std::filesystem::path> fixtures;
  std::optional<int> tool;  // in the spindle at the start
  std::optional<double> pitch_mm, tolerance_mm;
  std::optional<std::string> material;
  int threads = 1;
  bool z_only = false;
  bool forces = false;  // true: compute forces even if no tool has a number of teeth
  std::optional<FeedLimits> feed_limits;
  std::function<void(const std::string&)> warning;  // one sentence per call
};

// Programs that run while the part stays in one position. Without a job file, there is one set-up.
struct MillSetup {
  std::string name;  // empty without a job file
  std::vector<std::filesystem::path> programs;
  MillOptions options;
  std::vector<std::filesystem::path> fixture_files;
  std::filesystem::path target_file;
  std::vector<MillMesh> fixtures;  // in the coordinates of the model
  std::optional<MillMesh> target;
  // Results.
  MillSummary summary;
  std::optional<TargetReport> report;
};

struct MillPlan {
  std::optional<MillStock> stock;  // nullopt: `model` is the stock
  std::optional<double> pitch_mm, tolerance_mm;
  std::vector<MillSetup> setups;  // at least one
  std::unique_ptr<TriDexel> model;
  std::vector<Material> materials;  // of the model
  int threads = 1;
  std::function<void(const std::string&)> warning;

  bool has_target() const;
};

// Default material.
inline constexpr const char* kMillMaterial = "MDF";

// Reads a tool table and a machine file into the options. Empty path: none.
Status read_mill_tables(const std::filesystem::path& tools, const std::filesystem::path& machine,
                        MillOptions& options);
// Reads everything except meshes. `model`: the stock; null: the request or the job file names it.
// Errors, each one sentence: no stock; an option that the job file states itself; an unknown
// material; those of the readers.
Result<MillPlan> plan_milling(const MillRequest& request,
                              std::unique_ptr<TriDexel> model = nullptr);
// Reads fixtures and targets, and makes the model of the stock on a lattice that contains them. A
// model that the plan already has must contain them.
Status make_models(MillPlan& plan);
// The models that a set-up refers to while it runs.
struct MillSetupModels {
  std::unique_ptr<TriDexel> fixtures;
  std::optional<MillTarget> target;
};
// Makes these models, and sets the pointers in setup.options to them. Call make_models before.
Result<MillSetupModels> make_setup_models(const MillPlan& plan, MillSetup& setup);
// Compares the model with the target and sets setup.report. Needs setup.summary, the result of the
// run. Returns the surface of the model. Errors: nothing is left; those of compare_with_target.
Result<Surface> compare_setup(const MillPlan& plan, MillSetup& setup, const MillTarget& target);

struct MillPlanOptions {
  // Path of a new document that stores all moves. After an error, it holds the moves before it.
  // Empty: none.
  std::filesystem::path document;
  // See MillOptions. The tape counts programs over all set-ups.
  MillTape* tape = nullptr;
  const std::atomic<bool>* stop = nullptr;
  // See MillOptions::line. MillLine::program counts the programs of all set-ups. Null: no call.
  std::function<void(const MillLine&)> line;
  // Called after each comparison with a target, with the surface of the model. An error ends the
  // run. Null: no call.
  std::function<Status(const MillSetup&, Surface& left)> compared;
};
// Runs the programs of all set-ups, and compares the results with the targets. Errors: those of
// run_milling, of the targets and of the document.
Status run_plan(MillPlan& plan, const MillPlanOptions& options = {});

}  // namespace kibori
