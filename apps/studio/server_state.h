// SPDX-License-Identifier: MIT
// The state that the server, its pages and its connections share. It belongs to the server's
// thread. Internal to apps/studio.
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

// An entrance: a way to connect, from this machine or from the network.
struct Entrance {
  std::string scheme;  // `http` or `https`
  // The values that the header Host may have.
  std::vector<std::string> hosts;
  GuestList guests;
  // Not null for the entrance of the network. There, devices show a session in the cookie `cookie`.
  // Null for the entrance of this machine, where browsers show the key of the door.
  Pairing* pairing = nullptr;
  std::string cookie;
};

// Returns the materials as JSON for pages: name, colour, growth rings, grain and force law.
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
  // Sends a description of the force device that holds the tool to `page`. If `page` is null, sends
  // it to every page.
  void send_device(WebSocketClient* page);
  void send_work();
  void hold(WebSocketClient* page);
  void on_message(WebSocketClient& page, const FromPage& message);
  // Sends a sentence to every page.
  void notify(const std::string& text);
  // Replaces the document that is shown. Null: the start page is shown.
  void show(std::unique_ptr<Session> opened);
  // Makes or opens a document on another thread, and shows it. `fresh` is the path if the document
  // is new; otherwise empty. If the result is not wanted, a new document is removed. `done`
  // receives the result. If the job was cancelled, the result is an error without text. Without
  // `done`, every page gets the error. Errors: a document is open; a job is running.
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
  // Makes a document of the milling job, and shows it.
  void keep_program(WebSocketClient& page, const std::string& name);
  // Sends a message to every page.
  void send(const std::vector<uint8_t>& message);
  // Returns the content of the start page as JSON, for the page with this key.
  std::string start_json(const std::string& key) const;
  // Returns the page with this key, or null.
  WebSocketClient* page_of(const std::string& key) const;

  std::unique_ptr<Session> session;  // null: no document is open
  // Returns the session if a hand carves in it, or null.
  LiveSession* live() const { return session ? session->live() : nullptr; }
  const HapticDeviceState* haptic_device() const { return live() ? live()->held() : nullptr; }
  const Library library;
  const SessionOptions how;  // for documents that are opened
  const Limits limits;
  Door door;
  Pairing pairing;
  Entrance local, network;  // their guests leave when `loop` is destroyed
  Imports imports;
  std::set<WebSocketClient*> pages;  // pages that have sent Hello
  WebSocketClient* holder = nullptr;
  // Sentences about documents that could not be saved in their own files: the place where each one
  // is now. The job that saves a document adds its sentence.
  const std::shared_ptr<std::string> left_unsaved = std::make_shared<std::string>();
  double ticks_sent = 0;
  std::optional<HandTick> second_tick;  // the latest one
  bool second_hand_sent = false;        // true if the last message had a second hand
  std::vector<uint8_t> second_message();
  std::vector<float> tick_rows;          // rows that are not sent yet
  std::unique_ptr<Publisher> publisher;  // null if not requested
  void update_publisher();               // sends the description of the current document
  bool traced = false;                   // true if the result of the experiment was sent
  std::vector<uint8_t> trace_sent;       // for pages that connect later; empty: nothing sent yet
  // The last messages about a milling job, and their content. Pages that connect later get the
  // messages.
  std::vector<uint8_t> playback_sent, played_sent;
  std::tuple<size_t, bool, size_t> problems_sent;
  PlaybackStatus last_status;
  Clock::time_point played_at{};
  std::optional<ShowTool> shown;   // the tool; none: it is unknown
  std::optional<ShowStamp> stamp;  // triangles of the tool if it is a stamp
  std::string sent_error;
  Clock::time_point error_sent_at{}, clipped_at{};
  Clock::time_point state_at{}, ticks_at{}, work_at{};
  std::function<bool()> stop;
  // Destroyed before the members above, because pending handlers of the loop use these members.
  net::Loop loop;
  net::Listener listener{loop};
  std::unique_ptr<TlsListener> tls_listener;  // null: the network is not served
  net::Timer timer{loop};
  Job job{loop};
  bool all_ended = true;  // false: close() found a job that still runs
};

}  // namespace kibori::studio
