// SPDX-License-Identifier: MIT
// The commands that work on a document: replay, verify, history, bodies and export.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include <kibori/base/result.h>

#include "apps/cli/common.h"

class DocumentCommands {
 public:
  explicit DocumentCommands(CLI::App& app);
  // Returns true if the user gave one of these commands.
  bool given() const { return *replay_ || *verify_ || *history_ || *bodies_ || *export_; }
  // Runs the command. Returns its exit status.
  int run() const;

 private:
  // Add options that several commands share.
  void add_file(CLI::App& command);
  void add_to(CLI::App& command);
  void add_threads(CLI::App& command);
  void add_replay(CLI::App& app);
  void add_verify(CLI::App& app);
  void add_history(CLI::App& app);
  void add_bodies(CLI::App& app);
  void add_export(CLI::App& app);

  int run_replay() const;
  int run_bodies() const;
  kibori::Status act_on_bodies() const;
  int run_verify() const;
  int run_history() const;
  int run_export() const;

  CLI::App *replay_, *verify_, *history_, *bodies_, *export_;
  std::string file_, to_, model_, forces_, plot_, mesh_, name_, at_, copy_, salvage_, body_, act_,
      revise_, csv_, mcap_, hdf5_;
  double pitch_ = 0;
  int dof_ = 5, threads_ = all_cores();
  bool json_ = false;
};
