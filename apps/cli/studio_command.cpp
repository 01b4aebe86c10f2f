// SPDX-License-Identifier: MIT
#include "apps/cli/studio_command.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
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
#include "apps/cli/lan_text.h"
#include "apps/publish/publisher.h"
#include "apps/studio/addresses.h"
#include "apps/studio/bundle.h"
#include "apps/studio/server.h"

extern char** environ;

using namespace kibori;

namespace {

volatile std::sig_atomic_t studio_interrupted = 0;

// Opens the URL through a file in `folder`, which only this user can read. The URL must not be in
// the browser's command line, because every user of the machine can read that.
void open_browser(const std::string& url, const std::filesystem::path& folder) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  std::string program = "xdg-open", file = (folder / "kibori-studio.html").string();
  std::ofstream(file) << "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" << url
                      << "\">";
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = 0;
  static_cast<void>(posix_spawnp(&child, "xdg-open", nullptr, nullptr, arguments, environ));
}

// Notices changes of a file since it was shown: a write to it, or a replacement. It checks twice a
// second, and less often if showing the file takes long.
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
  // The state that seen() found is now shown.
  void shown() {
    last_ = found_;
    took_ = Clock::now() - looked_;
    looked_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;
  // The state of the file and of its log (-wal). A process that has the document open writes into
  // the log.
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

// SIGINT, SIGTERM and SIGHUP set `studio_interrupted`.
void catch_interrupts() {
  // A second signal ends the process at once. The file contains everything carved so far.
  const auto end = [](int) {
    studio_interrupted = 1;
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    std::signal(SIGHUP, SIG_DFL);
  };
  std::signal(SIGINT, end);
  std::signal(SIGTERM, end);
  std::signal(SIGHUP, end);  // the terminal was closed
  std::signal(SIGPIPE, SIG_IGN);
}

void print_lan(const studio::LanPlace& lan) {
  std::printf("Devices in this network open\n");
  for (const std::string& url : lan.urls) std::printf("  %s\n", url.c_str());
  std::printf("%s", qr_text(lan.urls.front(), isatty(STDOUT_FILENO) != 0).c_str());
  if (!lan.certificate_made.empty())
    std::printf("The certificate is new, because %s.\n", lan.certificate_made.c_str());
  std::printf("A browser warns about it once. Continue only if its SHA-256 fingerprint is\n  %s\n",
              lan.fingerprint.c_str());
}

}  // namespace

StudioCommand::StudioCommand(CLI::App& app) {
  studio_ =
      app.add_subcommand("studio", "Carve by hand in the browser and see the force on the tool");
  studio_->add_option(
      "FILE", file_,
      "document: .kibori; created if it does not exist. Without it, the start page opens");
  studio_->add_option("--stock", stock_, "scene that gives a new document its stock and materials")
      ->type_name("SCENE.toml");
  studio_->add_option("--port", port_, "port on 127.0.0.1; 0: any free port")
      ->capture_default_str();
  studio_->add_option("--device", device_,
                      "device that holds the tool: a name that 'kibori devices' lists; default: "
                      "mouse, pen or touch");
  studio_->add_option("--second", second_,
                      "with --device: device that holds the second tool; default: the pointer");
  studio_->add_flag("--read-only", read_only_,
                    "show the document and its history without changing them; if another process "
                    "writes it, show its state at the start");
  studio_
      ->add_flag(
          "--follow", follow_,
          "with --read-only: update the view after each change of the document by another process")
      ->needs("--read-only");
  CLI::Option* const lan = studio_->add_flag("--lan", lan_,
                                             "also serve devices of the same network, such as a "
                                             "tablet, by TLS; each one pairs with a code "
                                             "that the terminal shows");
  studio_->add_option("--lan-port", lan_port_, "port for --lan; 0: any free port")
      ->needs(lan)
      ->capture_default_str();
  studio_
      ->add_option("--lan-address", lan_addresses_,
                   "addresses of this machine for --lan; default: those in private networks")
      ->needs(lan);
  add_publish(*studio_, publish_);
  studio_->add_flag("--no-browser", no_browser_, "only print the address");
}

Status StudioCommand::check() const {
  if (studio::bundle().empty())
    return Error{
        "this kibori was built without the studio's page; build it again with './dev build'"};
  if (!file_.empty() && !is_document(file_))
    return Error{file_ +
                 ": is not a document's name; name a .kibori file, or give a scene with --stock"};
  if (read_only_ && (!stock_.empty() || !device_.empty() || !second_.empty() || !publish_.empty()))
    return Error{"--read-only changes nothing; omit --stock, --device, --second and --publish"};
  if (!device_.empty() && device_ != "virtual")
    if (const auto device = open_device(device_); !device) return Error{device.error()};
  if (!second_.empty() && device_.empty())
    return Error{"--second needs a first device; name it with --device"};
  if (!second_.empty() && second_ != "virtual")
    if (const auto device = open_device(second_); !device) return Error{device.error()};
  return Ok{};
}

// Opens the session to begin with. Null: the page shows the start page.
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

Result<studio::LanPlace> StudioCommand::serve_lan(studio::Server& server,
                                                  const Library& library) const {
  if (library.folder().empty())
    return Error{"--lan stores its certificate in your home folder, but there is none; set HOME"};
  studio::LanOptions how{{}, lan_port_, library.folder() / "lan.pem"};
  for (const std::string& address : lan_addresses_) {
    const Result<std::string> canonical = studio::canonical_address(address);
    if (!canonical) return Error{"--lan-address: " + canonical.error()};
    how.addresses.push_back(canonical.value());
  }
  if (how.addresses.empty()) how.addresses = studio::private_addresses();
  if (how.addresses.empty())
    return Error{
        "--lan found no address in a private network; connect this machine to one, or "
        "name its address with --lan-address"};
  const auto place = server.serve_lan(how, [](const std::string& code) {
    std::printf("Code to pair one device within 5 minutes: %s %s\n", code.substr(0, 3).c_str(),
                code.substr(3).c_str());
    std::fflush(stdout);
  });
  if (!place) return Error{place.error() + "; see --lan-address and --lan-port"};
  return place;
}

int StudioCommand::run() const {
  if (const Status fine = check(); !fine) return bad_input(fine.error());
  Result<Library> library = Library::of_user();
  if (!library) {
    if (file_.empty())
      return bad_input(library.error() + "; name a document, as in 'kibori studio FILE.kibori'");
    library = Library({});
  }
  catch_interrupts();
  SessionOptions how{read_only_, device_};
  how.second = second_;
  Changes changes(file_);  // notes the file's state before it is read
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
  studio::LanPlace lan;
  if (lan_) {
    auto place = serve_lan(*server.value(), library.value());
    if (!place) return bad_input(place.error());
    lan = std::move(place).value();
  }
  const std::string url = server.value()->url();
  server.value()->on_new_address([](const std::string& another) {
    std::printf("An address opens the studio once. Another browser can open\n  %s\n",
                another.c_str());
    std::fflush(stdout);
  });
  std::printf("%s at\n  %s\n%sCtrl-C ends the studio. Every stroke is saved while you carve.\n",
              session ? (session->name() + " is open").c_str() : "The studio is open", url.c_str(),
              published.c_str());
  if (lan_) {
    print_lan(lan);
    server.value()->offer_code();
  }
  if (const int status = written(); status != 0) return status;
  if (session) server.value()->show(std::move(session));
  const auto folder = TemporaryFolder::make();
  if (!no_browser_ && folder) open_browser(url, folder.value()->path());
  std::string last_error;
  server.value()->run([&] {
    // --follow needs --read-only, so this never replaces a document that is being carved.
    if (follow_ && server.value()->shows(file_) && changes.seen()) {
      auto again = open_session(file_, how);
      const std::string wrong = again ? std::string() : again.error();
      if (again) {
        server.value()->show(std::move(again).value());
        changes.shown();
      }
      if (std::exchange(last_error, wrong) != wrong && !wrong.empty())
        server.value()->notify(wrong);
    }
    return studio_interrupted != 0;
  });
  const std::string where = server.value()->close();
  const int status = where.empty() ? written() : bad_input(where);
  if (server.value()->idle()) return status;
  // Everything is saved. Do not wait for a job that still runs, because its result is not needed.
  std::fflush(nullptr);
  TemporaryFolder::remove_all();
  std::_Exit(status);
}
