// SPDX-License-Identifier: MIT
#include "apps/cli/studio_command.h"

#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>

#include <spawn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <kibori/session/documents.h>
#include <kibori/session/servo_run.h>
#include <kibori/session/studio.h>

#include "apps/cli/common.h"
#include "apps/studio/bundle.h"
#include "apps/studio/server.h"

extern char** environ;

using namespace kibori;

namespace {

volatile std::sig_atomic_t interrupted = 0;

// Where work goes that was given no name.
Result<std::filesystem::path> unnamed_document() {
  const char* const data = std::getenv("XDG_DATA_HOME");
  const char* const home = std::getenv("HOME");
  if (!(data && *data) && !(home && *home))
    return Error{"there is no home folder; say which FILE.kibori to carve in"};
  const std::filesystem::path folder =
      (data && *data ? std::filesystem::path(data) : std::filesystem::path(home) / ".local/share") / "kibori";
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return Error{folder.string() + ": can't be made; say which FILE.kibori to carve in"};
  char name[64];
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::strftime(name, sizeof name, "%Y-%m-%d %H.%M.%S", &local);
  return folder / (std::string(name) + ".kibori");
}

// By way of a file that only this user can read: what stands in a command line, everyone can. Its name, to be
// removed in the end; empty where there is no display.
std::string open_browser(const std::string& url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return {};
  char name[] = "/tmp/kibori-studio-XXXXXX.html";
  const int made = mkstemps(name, 5);
  if (made < 0) return {};
  ::close(made);
  std::ofstream(name) << "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" << url << "\">";
  std::string program = "xdg-open", file = name;
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = 0;
  static_cast<void>(posix_spawnp(&child, "xdg-open", nullptr, nullptr, arguments, environ));
  return name;
}

}  // namespace

StudioCommand::StudioCommand(CLI::App& app) {
  studio_ = app.add_subcommand("studio", "Carve by hand in the browser, and see and feel the force");
  studio_->add_option(
      "FILE", file_,
      "document: .kibori; made if it is not there yet. Without one, a new one among your own files");
  studio_
      ->add_option("--stock", stock_,
                   "scene whose stock, first tool and materials a new document begins with")
      ->type_name("SCENE.toml");
  studio_->add_option("--port", port_, "of 127.0.0.1; 0: any that is free")->capture_default_str();
  studio_->add_flag("--no-browser", no_browser_, "only print the address");
}

int StudioCommand::run() const {
  if (studio::bundle().empty())
    return bad_input("this kibori was built without its page; './dev build' builds it with it");
  std::filesystem::path file = file_;
  if (file_.empty()) {
    const Result<std::filesystem::path> unnamed = unnamed_document();
    if (!unnamed) return bad_input(unnamed.error());
    file = unnamed.value();
  } else if (!is_document(file)) {
    return bad_input(file_ + ": documents are .kibori files; give a scene by --stock");
  }
  Scene scene = servo_scene();
  if (!stock_.empty()) {
    Result<Scene> read = read_scene(stock_);
    if (!read) return bad_input(read.error());
    scene = std::move(read).value();
  }
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  std::signal(SIGPIPE, SIG_IGN);
  Result<std::unique_ptr<Studio>> opened = Studio::open(file, scene);
  if (!opened) return bad_input(opened.error());
  Studio& session = *opened.value();
  {
    auto server = studio::Server::listen(session, port_);
    if (!server) return bad_input(server.error());
    const std::string url = server.value()->url();
    std::printf("%s is open at\n  %s\nCtrl-C ends it; all is saved as you carve.\n",
                session.document_name().c_str(), url.c_str());
    if (const int status = written(); status != 0) return status;
    const std::string way = no_browser_ ? std::string() : open_browser(url);
    server.value()->run([] { return interrupted != 0; });
    std::error_code ignored;
    if (!way.empty()) std::filesystem::remove(way, ignored);
  }
  const std::string where = session.close();
  return where.empty() ? written() : bad_input(where);
}
