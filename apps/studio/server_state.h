// SPDX-License-Identifier: MIT
// What the server, its pages and its connections share. Internal to apps/studio; all of it is of
// the server's thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <nlohmann/json.hpp>

#include "apps/studio/door.h"
#include "apps/studio/imports.h"
#include "apps/studio/job.h"
#include "apps/studio/messages.h"
#include "apps/studio/server.h"
#include "apps/studio/session/experiment_session.h"
#include "apps/studio/session/live_session.h"

namespace kibori::studio {

class WebSocketClient;

// What pages know of materials: name, colour, and how strongly their rings stand out.
nlohmann::json materials_json(const std::vector<Material>& materials);

struct Server::State {
  using Clock = std::chrono::steady_clock;

  State(Library l, SessionOptions h, const Limits& m)
      : library(std::move(l)),
        how(std::move(h)),
        limits(m),
        door(m.connections, m.strangers),
        imports(m.import_bytes),
        acceptor(io),
        timer(io),
        job(io) {}
  ~State();

  void accept();
  void follow();
  void send_ticks();
  void send_state();
  // What holds the tool, if that is a force device; to this page or, null, to every one.
  void send_device(WebSocketClient* page);
  void send_work();
  void hold(WebSocketClient* page);
  void on_message(WebSocketClient& page, const FromPage& message);
  // The sentence to every page.
  void notify(const std::string& text);
  // From now on this document, or none.
  void show(std::unique_ptr<Session> opened);
  // Makes or opens a document, on a thread of its own, and shows it. `fresh`: where it is made, and
  // removed again if it is not to be; else empty. `done`: gets the outcome, which is told to every
  // page otherwise; an empty error if it was cancelled.
  // Error: one is open, or something is under way.
  Status open(const std::string& what, const std::filesystem::path& fresh,
              std::function<Result<std::unique_ptr<Session>>(std::atomic<double>&)> make,
              std::function<void(const Status&)> done = {});
  void begin(WebSocketClient& page, const Begin& begin);
  // One of the library's documents.
  void open_named(WebSocketClient& page, const std::string& name);
  void leave(WebSocketClient& page);
  // Starts a job and tells the pages of it.
  void work(const std::string& what, std::function<Job::Then(std::atomic<double>&)> work,
            bool cancellable = true);
  void carve_example(WebSocketClient& page, const std::string& name);
  void run_experiment(WebSocketClient& page, const RunExperiment& run);
  // The tool from now on, to every page.
  void show_tool(const Tool& tool);
  // What an experiment came to, once.
  void follow_experiment();
  // To every page.
  void send(const std::vector<uint8_t>& message);
  // What there is to begin with, for the page of this key.
  std::string start_json(const std::string& key) const;
  // The page that calls itself so; null: none does any more.
  WebSocketClient* page_of(const std::string& key) const;

  std::unique_ptr<Session> session;  // null: nothing is open
  // The session, where a hand carves in it; else null.
  LiveSession* live() const { return session ? session->live() : nullptr; }
  const HapticDeviceState* haptic_device() const { return live() ? live()->held() : nullptr; }
  const Library library;
  const SessionOptions how;  // documents are opened
  const Limits limits;
  std::string host, local_host;  // as a browser names this server
  Door door;
  Imports imports;
  std::set<WebSocketClient*> pages;  // that said hello
  WebSocketClient* holder = nullptr;
  // Where what was left lies, if not where it belongs. Written by the job that saves.
  const std::shared_ptr<std::string> left_unsaved = std::make_shared<std::string>();
  double ticks_sent = 0;
  std::optional<HandTick> second_tick;  // the newest
  bool second_told = false;             // pages know of a second hand
  std::vector<uint8_t> second_message();
  std::vector<float> tick_rows;          // not sent yet
  std::unique_ptr<Publisher> publisher;  // null: nobody asked for one
  void tell_publisher();                 // which document it is
  bool traced = false;                   // what the experiment came to was sent
  std::vector<uint8_t> trace_sent;       // for pages that come later; empty: not yet
  std::optional<ShowTool> shown;         // the tool; none: no one has said
  std::optional<ShowStamp> stamp;        // its triangles, where it is a stamp
  std::string trouble_told;
  Clock::time_point trouble_at{}, clipped_at{};
  Clock::time_point state_at{}, ticks_at{}, work_at{};
  std::function<bool()> stop;
  // Destroyed first: its pending handlers use the members above.
  boost::asio::io_context io{1};
  boost::asio::ip::tcp::acceptor acceptor;
  boost::asio::steady_timer timer;
  Job job;
};

}  // namespace kibori::studio
