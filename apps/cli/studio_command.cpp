// SPDX-License-Identifier: MIT
#include "apps/cli/studio_command.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

#include <spawn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <kibori/base/file.h>
#include <kibori/run/documents.h>
#include <kibori/devices/registry.h>
#include "apps/studio/session/library.h"
#include "apps/studio/session/stock_scene.h"
#include "apps/studio/session/session.h"

#include "apps/cli/common.h"
#include "apps/publish/publisher.h"
#include "apps/studio/bundle.h"
#include "apps/studio/server.h"

extern char** environ;

using namespace kibori;

namespace {

volatile std::sig_atomic_t interrupted = 0;

// By way of a file in `folder`, which only this user can read: what stands in a command line,
// everyone can.
void open_browser(const std::string& url, const std::filesystem::path& folder) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  std::string program = "xdg-open", file = (folder / "kibori-studio.html").string();
  std::ofstream(file) << "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" << url
                      << "\">";
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = 0;
  static_cast<void>(posix_spawnp(&child, "xdg-open", nullptr, nullptr, arguments, environ));
}

// Whether a file has changed since it was shown: it was written, or another took its name. It is
// looked at twice a second, and more rarely where showing it takes long.
class Changes {
 public:
  explicit Changes(std::string file) : file_(std::move(file)), last_(state()) {}
  bool seen() {
    const auto now = Clock::now();
    if (now - looked_ < std::max<Clock::duration>(std::chrono::milliseconds(500), 4 * took_))
      return false;
    looked_ = now;
    found_ = state();
    return found_ && found_ != last_;
  }
  // As it was when it was seen.
  void shown() {
    last_ = found_;
    took_ = Clock::now() - looked_;
    looked_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;
  // Of the file, and of the log beside it, into which a process writes that has it open.
  using State = std::optional<std::array<int64_t, 6>>;
  State state() const {
    struct stat file {
    }, log{};
    if (stat(file_.c_str(), &file) != 0) return std::nullopt;
    if (stat((file_ + "-wal").c_str(), &log) != 0) log = {};
    return std::array<int64_t, 6>{static_cast<int64_t>(file.st_ino),
                                  file.st_mtim.tv_sec,
                                  file.st_mtim.tv_nsec,
                                  log.st_size,
                                  log.st_mtim.tv_sec,
                                  log.st_mtim.tv_nsec};
  }
  const std::string file_;
  Clock::time_point looked_ = Clock::now();
  Clock::duration took_{0};
  State last_, found_;
};

// SIGINT, SIGTERM and SIGHUP set `interrupted`.
void catch_interrupts() {
  // A second time it ends at once; what was carved is in the file.
  const auto end = [](int) {
    interrupted = 1;
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    std::signal(SIGHUP, SIG_DFL);
  };
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  std::signal(SIGHUP, end);  // its terminal is gone
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace

StudioCommand::StudioCommand(CLI::App& app) {
  studio_ =
      app.add_subcommand("studio", "Carve by hand in the browser, and see and feel the force");
  studio_->add_option("FILE", file_,
                      "document: .kibori; made if it is not there yet. Without one, the page asks "
                      "what to begin with");
  studio_
      ->add_option("--stock", stock_, "scene whose stock and materials a new document begins with")
      ->type_name("SCENE.toml");
  studio_->add_option("--port", port_, "of 127.0.0.1; 0: any that is free")->capture_default_str();
  studio_->add_option(
      "--device", device_,
      "what holds the tool: a name that 'kibori devices' lists; by default mouse, pen or touch");
  studio_->add_option("--second", second_,
                      "with --device: what holds the second hand's tool; by default the pointer");
  studio_->add_flag(
      "--read-only", read_only_,
      "only look at the document and its history; while another process writes it, as it was "
      "when this began");
  studio_
      ->add_flag(
          "--follow", follow_,
          "with --read-only: shows the document anew whenever it has changed, as a script or "
          "another process carves it")
      ->needs("--read-only");
  add_publish(*studio_, publish_);
  studio_->add_flag("--no-browser", no_browser_, "only print the address");
}

Status StudioCommand::check() const {
  if (studio::bundle().empty())
    return Error{"this kibori was built without its page; './dev build' builds it with it"};
  if (!file_.empty() && !is_document(file_))
    return Error{file_ + ": documents are .kibori files; give a scene by --stock"};
  if (read_only_ && (!stock_.empty() || !device_.empty() || !second_.empty() || !publish_.empty()))
    return Error{"--read-only only looks: leave off --stock, --device, --second and --publish"};
  if (!device_.empty() && device_ != "virtual")
    if (const auto device = open_device(device_); !device) return Error{device.error()};
  if (!second_.empty() && device_.empty())
    return Error{"--second is for a second device: say what holds the first tool by --device"};
  if (!second_.empty() && second_ != "virtual")
    if (const auto device = open_device(second_); !device) return Error{device.error()};
  return Ok{};
}

// Null: the page asks what to begin with.
Result<std::unique_ptr<Session>> StudioCommand::first_session(const Library& library,
                                                              const SessionOptions& how) const {
  if (file_.empty() && stock_.empty()) return std::unique_ptr<Session>();
  Result<Scene> scene =
      stock_.empty() ? stock_scene(StockBlock{Vec3(80, 50, 30)}, 0.25, 0) : read_scene(stock_);
  if (!scene) return Error{scene.error()};
  const Result<std::filesystem::path> place =
      file_.empty() ? library.place_for(std::filesystem::path(stock_).stem().string())
                    : Result<std::filesystem::path>(file_);
  if (!place) return Error{place.error()};
  std::error_code failed;
  return std::filesystem::exists(place.value(), failed)
             ? open_session(place.value(), how)
             : create_session(place.value(), scene.value(), how);
}

int StudioCommand::run() const {
  if (const Status fine = check(); !fine) return bad_input(fine.error());
  Result<Library> library = Library::of_user();
  if (!library) {
    if (file_.empty()) return bad_input(library.error() + "; say which FILE.kibori to carve in");
    library = Library({});
  }
  catch_interrupts();
  SessionOptions how{read_only_, device_};
  how.second = second_;
  Changes changes(file_);  // since it is read
  Result<std::unique_ptr<Session>> opened = first_session(library.value(), how);
  if (!opened) return bad_input(opened.error());
  std::unique_ptr<Session> session = std::move(opened).value();
  auto server = studio::Server::listen(library.value(), port_, how);
  if (!server) return bad_input(server.error());
  std::string published;
  if (!publish_.empty()) {
    auto publisher = Publisher::open(publish_);
    if (!publisher) return bad_input(publisher.error());
    published = publisher.value()->where() + ".\n";
    server.value()->publish_by(std::move(publisher).value());
  }
  const std::string url = server.value()->url();
  server.value()->on_new_address([](const std::string& another) {
    std::printf("An address opens the studio once. For another browser there is\n  %s\n",
                another.c_str());
    std::fflush(stdout);
  });
  std::printf("%s at\n  %s\n%sCtrl-C ends it; all is saved as you carve.\n",
              session ? (session->name() + " is open").c_str() : "The studio is open", url.c_str(),
              published.c_str());
  if (const int status = written(); status != 0) return status;
  if (session) server.value()->show(std::move(session));
  const auto way = TemporaryFolder::make();
  if (!no_browser_ && way) open_browser(url, way.value()->path());
  std::string told;
  server.value()->run([&] {
    // Only what is still looked at.
    if (follow_ && server.value()->shows(file_) && changes.seen()) {
      auto again = open_session(file_, how);
      const std::string wrong = again ? std::string() : again.error();
      if (again) {
        server.value()->show(std::move(again).value());
        changes.shown();
      }
      if (std::exchange(told, wrong) != wrong && !wrong.empty()) server.value()->notify(wrong);
    }
    return interrupted != 0;
  });
  const std::string where = server.value()->close();
  return where.empty() ? written() : bad_input(where);
}
