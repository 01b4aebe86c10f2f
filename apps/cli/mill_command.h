// SPDX-License-Identifier: MIT
// The command mill: programs of a milling machine on a stock.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <kibori/run/milling.h>

#include "apps/cli/common.h"

class MillCommand {
 public:
  explicit MillCommand(CLI::App& app);
  // Whether the user gave it.
  bool given() const { return command_->parsed(); }
  // Runs the command. Returns its exit status.
  int run() const;

 private:
  struct Job;
  kibori::Status prepare(Job& job) const;
  kibori::Status read_programs(Job& job) const;
  kibori::Status check_outputs(const Job& job) const;
  kibori::Status make_models(Job& job) const;
  kibori::Status compare(Job& job, const kibori::MillSummary& summary) const;
  kibori::Status draw(const Job& job, const std::string& file,
                      const kibori::Surface& surface) const;
  kibori::Status write_outputs(const Job& job) const;

  CLI::App* command_;
  std::vector<std::string> programs_;
  std::string stock_, tools_, machine_, mesh_, picture_, document_, lines_, target_, map_;
  std::string material_ = "MDF", view_ = "iso";
  std::vector<std::string> fixtures_;
  double pitch_ = 0, tolerance_ = 0;
  int tool_ = 0, threads_ = all_cores();
  bool json_ = false, z_only_ = false, strict_ = false;
};
