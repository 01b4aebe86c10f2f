// SPDX-License-Identifier: MIT
// The command `gcode`. It writes strokes of a document as a program for a milling machine.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include <kibori/run/stroke_program.h>

#include "apps/cli/common.h"

class GcodeCommand {
 public:
  explicit GcodeCommand(CLI::App& app);
  // Returns true if the user gave this command.
  bool given() const { return command_->parsed(); }
  // Runs the command. Returns its exit status.
  int run() const;

 private:
  kibori::Status read_steps(kibori::StrokeProgramOptions& options) const;
  kibori::Status write(const kibori::Document& document,
                       const kibori::StrokeProgram& program) const;
  kibori::Status write_refed(const kibori::Document& document,
                             const kibori::StrokeProgram& program) const;
  void report(const kibori::StrokeProgram& program) const;

  CLI::App* command_;
  std::string document_, output_, tools_, stock_, steps_;
  kibori::StrokeProgramOptions options_;
  double force_n_ = 0;
  bool json_ = false, strict_ = false;
};
