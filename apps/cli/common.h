// SPDX-License-Identifier: MIT
// Functions that all commands use: exit status, checks of options, progress, --publish, writing of
// text.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include <kibori/base/file.h>
#include <kibori/base/result.h>

inline constexpr int kBadInput = 2;

// Accepts finite numbers above 0. (The check of CLI11 accepts nan as positive.)
inline const CLI::Validator kPositive(
    [](std::string& text) {
      char* end = nullptr;
      const double value = std::strtod(text.c_str(), &end);
      return end != text.c_str() && *end == 0 && value > 0 && std::isfinite(value)
                 ? std::string()
                 : "'" + text + "' is not a positive number";
    },
    "POSITIVE");

inline int bad_input(const std::string& what) {
  std::fprintf(stderr, "kibori: %s\n", kibori::sanitize_message(what).c_str());
  return kBadInput;
}

// Adds the option --publish to a command that carves in real time.
inline void add_publish(CLI::App& command, std::vector<std::string>& where) {
  command
      .add_option(
          "--publish", where,
          "publish every tick while carving: HOST:PORT over WebSocket (127.0.0.1:7070: only "
          "this machine may read), dds or dds:DOMAIN as ROS 2 topics")
      ->type_name("HOST:PORT|dds")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

// Returns the default of --threads: the number of cores that this process may use. Results do not
// depend on this number.
inline int all_cores() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (sched_getaffinity(0, sizeof cores, &cores) != 0) return 1;
  return std::clamp(CPU_COUNT(&cores), 1, 256);
}

inline int written() {
  return std::fflush(stdout) == 0 ? 0 : bad_input("standard output cannot be written");
}

inline void show_progress(const char* what, double share) {
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  static int shown = -1;
  const int percent = static_cast<int>(100 * share);
  if (!terminal || percent == shown) return;
  shown = percent;
  std::fprintf(stderr, "\r%s %3d %%%s", what, percent, share >= 1 ? "\n" : "");
}

inline kibori::Status write_text(const std::string& path, const std::string& text) {
  kibori::NewFile file(path);
  file.write(text);
  return file.commit();
}
