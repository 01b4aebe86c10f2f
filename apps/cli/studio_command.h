// SPDX-License-Identifier: MIT
// The command `studio`, for carving in the browser.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <kibori/base/result.h>

namespace kibori {
class Library;
class Session;
struct SessionOptions;
namespace studio {
class Server;
struct LanPlace;
}  // namespace studio
}  // namespace kibori

class StudioCommand {
 public:
  explicit StudioCommand(CLI::App& app);
  bool given() const { return studio_->parsed(); }
  // Runs the command. Returns its exit status.
  int run() const;

 private:
  // Checks the options. Errors: two options exclude each other; a file or a device is not valid.
  kibori::Status check() const;
  kibori::Result<std::unique_ptr<kibori::Session>> first_session(
      const kibori::Library& library, const kibori::SessionOptions& how) const;

  kibori::Result<kibori::studio::LanPlace> serve_lan(kibori::studio::Server& server,
                                                     const kibori::Library& library) const;

  CLI::App* studio_;
  std::vector<std::string> publish_, lan_addresses_;
  std::string file_, stock_, device_, second_;
  uint16_t port_ = 0, lan_port_ = 8443;
  bool lan_ = false, no_browser_ = false, read_only_ = false, follow_ = false;
};
