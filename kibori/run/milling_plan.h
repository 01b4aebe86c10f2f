// SPDX-License-Identifier: MIT
// Reads all files that milling needs: programs, stock, tools, machine, fixtures and targets. Then
// runs the programs. The command `kibori mill` and kibori.mill of the Python module use these
// functions.
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

// The request of the user.
struct MillRequest {
  // Programs and at most one project of CAMotics, or a single job file (.toml). A job file names
  // stock, tools, machine, fixtures and target. Then the request must not name them.
  std::vector<std::filesystem::path> programs;
  std::optional<MillStock> stock;
  std::filesystem::path tools, machine, target;  // empty: none
  std::vector<std::filesystem::path> fixtures;
  std::optional<int> tool;  // tool in the spindle at the start
  std::optional<double> pitch_mm, tolerance_mm;
  std::optional<std::string> material;
  int threads = 1;
  bool z_only = false;
  bool forces = false;  // compute forces even if no tool has a number of teeth
  std::optional<FeedLimits> feed_limits;
  std::function<void(const std::string&)> warning;  // called with one sentence for each warning
};

// A set-up: programs that run while the part stays in one position. Without a job file, there is
// one.
struct MillSetup {
  std::string name;  // empty if there is no job file
  std::vector<std::filesystem::path> programs;
  MillOptions options;
  std::vector<std::filesystem::path> fixture_files;
  std::filesystem::path target_file;
  std::vector<MillMesh> fixtures;  // in the coordinates of the model
  std::optional<MillMesh> target;
  // The results.
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

// The default material.
inline constexpr const char* kMillMaterial = "MDF";

// Reads a tool table and a machine file into the options. A path may be empty: then nothing is
// read.
Status read_mill_tables(const std::filesystem::path& tools, const std::filesystem::path& machine,
                        MillOptions& options);
// Reads everything except meshes. `model` is the stock. If it is null, the request or the job file
// must name the stock. Errors: there is no stock; the request has an option that the job file
// states; the material is unknown; those of the readers.
Result<MillPlan> plan_milling(const MillRequest& request,
                              std::unique_ptr<TriDexel> model = nullptr);
// Reads fixtures and targets, and makes the model of the stock. Its lattice contains all of them.
// If the plan already has a model, its lattice must contain them. Errors: it does not; those of the
// readers.
Status make_models(MillPlan& plan);
// The models to which the options of a set-up point while it runs.
struct MillSetupModels {
  std::unique_ptr<TriDexel> fixtures;
  std::optional<MillTarget> target;
};
// Makes these models, and makes setup.options point to them. Call make_models() before.
Result<MillSetupModels> make_setup_models(const MillPlan& plan, MillSetup& setup);
// Compares the model with the target, and sets setup.report. setup.summary must have the result of
// the run. Returns the surface of the model. Errors: there is no material left; those of
// compare_with_target.
Result<Surface> compare_setup(const MillPlan& plan, MillSetup& setup, const MillTarget& target);

struct MillPlanOptions {
  // Path of a new document that stores all moves; empty: none. After an error, the document has the
  // moves before the error.
  std::filesystem::path document;
  // As in MillOptions. The programs on the tape are counted over all set-ups.
  MillTape* tape = nullptr;
  const std::atomic<bool>* stop = nullptr;
  // As MillOptions::line, but MillLine::program counts the programs of all set-ups. It may be null.
  std::function<void(const MillLine&)> line;
  // Called after each comparison with a target. `left` is the surface of the model. If it returns
  // an error, the run ends. It may be null.
  std::function<Status(const MillSetup&, Surface& left)> compared;
};
// Runs the programs of all set-ups, and compares the results with the targets. Errors: those of
// run_milling, of the targets, of `compared` and of the document.
Status run_plan(MillPlan& plan, const MillPlanOptions& options = {});

}  // namespace kibori
