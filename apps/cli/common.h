// SPDX-License-Identifier: MIT
// What the commands share.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>

#include <kibori/base/file.h>
#include <kibori/base/result.h>

inline constexpr int kBadInput = 2;

// CLI11's own takes nan for positive.
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

// --publish, of what is carved in real time.
inline void add_publish(CLI::App& command, std::vector<std::string>& where) {
  command
      .add_option("--publish", where,
                  "give every tick to whoever reads while it is made: over WebSocket at HOST:PORT "
                  "(127.0.0.1:7070: this machine alone may), and as ROS 2's topics by dds or "
                  "dds:DOMAIN")
      ->type_name("HOST:PORT|dds")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

inline int written() {
  return std::fflush(stdout) == 0 ? 0 : bad_input("standard output can't be written");
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
