// SPDX-License-Identifier: MIT
// The command `mill`. It runs programs of a milling machine on a stock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <kibori/run/milling_feeds.h>
#include <kibori/run/milling_plan.h>

#include "apps/cli/common.h"

class MillCommand {
 public:
  explicit MillCommand(CLI::App& app);
  // Returns true if the user gave this command.
  bool given() const { return command_->parsed(); }
  // Runs the command. Returns its exit status.
  int run() const;

 private:
  kibori::Result<kibori::MillPlan> make_plan() const;
  kibori::Status check_outputs(const kibori::MillPlan& plan) const;
  kibori::Status check_feeds(const kibori::MillPlan& plan) const;
  kibori::Status run_programs(kibori::MillPlan& plan, std::optional<kibori::FeedPlan>& feeds) const;
  kibori::Status write_map(const kibori::MillPlan& plan, const kibori::MillSetup& setup,
                           kibori::Surface& left) const;
  kibori::Status draw(const kibori::MillPlan& plan, const std::string& file,
                      const kibori::Surface& surface) const;
  kibori::Status write_outputs(const kibori::MillPlan& plan) const;

  CLI::App* command_;
  std::vector<std::string> programs_;
  std::string stock_, tools_, machine_, mesh_, picture_, document_, lines_, target_, map_, feed_to_;
  std::string material_ = kibori::kMillMaterial, view_ = "iso";
  std::vector<std::string> fixtures_, feed_for_;
  double pitch_ = 0, tolerance_ = 0;
  int tool_ = 0, threads_ = all_cores();
  bool json_ = false, z_only_ = false, strict_ = false;
};
