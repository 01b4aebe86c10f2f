// SPDX-License-Identifier: MIT
// The state that the server, its pages and its connections share. Internal to apps/studio. The
// server's thread owns it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>

#include <kibori/net/web.h>

#include "apps/studio/door.h"
#include "apps/studio/imports.h"
#include "apps/studio/job.h"
#include "apps/studio/messages.h"
#include "apps/studio/pairing.h"
#include "apps/studio/server.h"
#include "apps/studio/session/experiment_session.h"
#include "apps/studio/session/live_session.h"
#include "apps/studio/session/playback_session.h"
#include "apps/studio/tls_listener.h"

namespace kibori::studio {

class WebSocketClient;

// An entrance for connections: from this machine, or from the network.
struct Entrance {
  std::string scheme;  // http or https
  // This server's names in a browser, as the header Host has them.
  std::vector<std::string> hosts;
  GuestList guests;
  // The entrance of the network: devices show a session in the cookie named `cookie`. Null: the
  // entrance of this machine, where browsers show the door's key.
  Pairing* pairing = nullptr;
  std::string cookie;
};

// The materials as JSON for pages: name, colour, growth rings, grain and force law.
nlohmann::json materials_json(const std::vector<Material>& materials);

struct Server::State {
  using Clock = std::chrono::steady_clock;

  State(Library l, SessionOptions h, const Limits& m)
      : library(std::move(l)),
        how(std::move(h)),
        limits(m),
        local{"http", {}, {m.connections, m.strangers}, nullptr, {}},
        network{"https", {}, {m.connections, m.strangers}, &pairing, {}},
        imports(m.import_bytes) {}
  ~State();

  void follow();
  void send_ticks();
  void send_state();
  // Sends a description of the force device that holds the tool to this page, or to every page if
  // null.
  void send_device(WebSocketClient* page);
  void send_work();
  void hold(WebSocketClient* page);
  void on_message(WebSocketClient& page, const FromPage& message);
  // Sends a sentence to every page.
  void notify(const std::string& text);
  // Replaces the shown document. Null: shows the start page.
  void show(std::unique_ptr<Session> opened);
  // Makes or opens a document on another thread and shows it. `fresh` is the path of a new
  // document, which is removed if it is not wanted; else empty. `done` receives the result; its
  // error is empty if the job was cancelled. Without `done`, every page gets the error. Error: a
  // document is open, or a job is running.
  Status open(const std::string& what, const std::filesystem::path& fresh,
              std::function<Result<std::unique_ptr<Session>>(std::atomic<double>&)> make,
              std::function<void(const Status&)> done = {});
  void begin(WebSocketClient& page, const Begin& begin);
  // Opens a document of the library.
  void open_named(WebSocketClient& page, const std::string& name);
  void leave(WebSocketClient& page);
  // Starts a job and reports it to the pages.
  void work(const std::string& what, std::function<Job::Then(std::atomic<double>&)> work,
            bool cancellable = true);
  void carve_example(WebSocketClient& page, const std::string& name);
  // Carves a document of the library again at another pitch.
  void change_detail(WebSocketClient& page, const ChangeDetail& change);
  void run_experiment(WebSocketClient& page, const RunExperiment& run);
  // Sends the current tool to every page.
  void show_tool(const Tool& tool);
  // Sends the result of an experiment, once.
  void follow_experiment();
  // Sends the state of a milling job.
  void follow_playback();
  // Makes a document of the milling job and shows it.
  void keep_program(WebSocketClient& page, const std::string& name);
  // Sends a message to every page.
  void send(const std::vector<uint8_t>& message);
  // The content of the start page, for the page with this key.
  std::string start_json(const std::string& key) const;
  // The page with this key. Null: none.
  WebSocketClient* page_of(const std::string& key) const;

  std::unique_ptr<Session> session;  // null: nothing is open
  // The session if a hand carves in it, else null.
  LiveSession* live() const { return session ? session->live() : nullptr; }
  const HapticDeviceState* haptic_device() const { return live() ? live()->held() : nullptr; }
  const Library library;
  const SessionOptions how;  // applies to documents that are opened
  const Limits limits;
  Door door;
  Pairing pairing;
  Entrance local, network;  // guests leave them when `loop` is destroyed
  Imports imports;
  std::set<WebSocketClient*> pages;  // pages that have sent Hello
  WebSocketClient* holder = nullptr;
  // Sentences about documents that could not be saved in their own files: where each one is now.
  // The job that saves a document adds its sentence.
  const std::shared_ptr<std::string> left_unsaved = std::make_shared<std::string>();
  double ticks_sent = 0;
  std::optional<HandTick> second_tick;  // the latest
  bool second_hand_sent = false;        // the last message had a second hand
  std::vector<uint8_t> second_message();
  std::vector<float> tick_rows;          // not sent yet
  std::unique_ptr<Publisher> publisher;  // null: not requested
  void update_publisher();               // sends the description of the current document
  bool traced = false;                   // the experiment's result was sent
  std::vector<uint8_t> trace_sent;       // for pages that connect later; empty: none yet
  // The last messages about a milling job, for pages that connect later, and their content.
  std::vector<uint8_t> playback_sent, played_sent;
  std::tuple<size_t, bool, size_t> problems_sent;
  PlaybackStatus last_status;
  Clock::time_point played_at{};
  std::optional<ShowTool> shown;   // the tool; none: unknown
  std::optional<ShowStamp> stamp;  // its triangles if it is a stamp
  std::string sent_error;
  Clock::time_point error_sent_at{}, clipped_at{};
  Clock::time_point state_at{}, ticks_at{}, work_at{};
  std::function<bool()> stop;
  // Destroyed before the members above, because its pending handlers use them.
  net::Loop loop;
  net::Listener listener{loop};
  std::unique_ptr<TlsListener> tls_listener;  // null: no network
  net::Timer timer{loop};
  Job job{loop};
  bool all_ended = true;  // false: close() found work that still runs
};

}  // namespace kibori::studio
