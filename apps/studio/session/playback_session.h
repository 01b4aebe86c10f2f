// SPDX-License-Identifier: MIT
// A milling job that pages watch: at any time of the run, at any speed.
//
//   run thread     run_plan ─► MillTape       computes ahead: moves, forces, collisions, snapshots
//   play thread    MillPlayer ─► states_      goes to the wanted time within what is computed
//   server thread  follow(), status()         shows the newest state
//
// Only short critical sections are shared, so no thread waits for the work of another one.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/mill/program_text.h>
#include <kibori/run/milling_plan.h>
#include <kibori/run/milling_player.h>
#include "apps/studio/session/playback_request.h"
#include "apps/studio/session/session.h"

namespace kibori {

// What pages show of a playback.
struct PlaybackStatus {
  double time_s = 0;      // shown
  double computed_s = 0;  // the run is computed up to here
  double share = 0;       // progress of computing, 0..1
  bool done = false;      // all is computed
  bool playing = false;
  double speed = 1;                     // 0: as fast as possible
  bool stops = true;                    // at collisions
  int program = 0, line = 0, tool = 0;  // line 0: before the first move
  bool rapid = false;
  double force_n = 0, power_w = 0;
  size_t problems = 0;  // number of collisions so far
  int stopped_at = -1;  // index of the collision at which it stopped; -1: none
  bool operator==(const PlaybackStatus&) const = default;
};

class PlaybackSession final : public Session {
 public:
  // Reads everything and begins to compute. Errors: those of playback_request, plan_milling and
  // make_models; a stock that is too fine for a page.
  static Result<std::unique_ptr<Session>> start(PlaybackFiles files, const PlaybackChoice& choice);
  ~PlaybackSession() override;

  PlaybackSession* playback() override { return this; }

  // ---- The user's wishes.
  void play(bool playing, double speed, bool stops);
  void seek(double time_s);
  // To the end of the next line that moves, or to the begin of this one.
  void step_line(bool forward);
  // To the end of a line, from 1, at its first execution. Waits until it is computed.
  void go_to_line(int program, int line);

  // ---- What to show.
  PlaybackStatus status() const;
  const std::vector<std::string>& programs() const { return program_names_; }
  const std::vector<ProgramText>& texts() const { return texts_; }
  std::vector<MillTape::Collision> collisions() const { return tape_.collisions(); }
  // The end of the move that collides [s].
  double time_of(const MillTape::Collision& collision) const;
  MillTape::Curve curve(size_t parts) const { return tape_.curve(parts); }
  // Sentences about the job; complete when the run is done.
  std::vector<std::string> warnings() const;
  std::string error() const;  // why the run ended early; empty: it did not
  // The current tool, if it has changed since the last call. Call on one thread.
  bool next_tool(Tool& tool) { return tools_.take(tool); }
  // The job, to run it again into a document.
  const PlaybackFiles& files() const { return files_; }
  const MillRequest& request() const { return request_; }

  // There is no document, so there are no thumbnails and no copies.
  void thumbnail(StepId step, std::function<void(Bytes)> use) override;
  void save_copy(const std::filesystem::path& path, std::function<void(Status)> done) override;

 private:
  using Clock = std::chrono::steady_clock;

  PlaybackSession(PlaybackFiles files, MillPlan plan);
  bool latest(Shown& shown) override;
  bool next_tick(LiveTick& tick) override { return ticks_.pop(tick); }
  void update_history() override;
  bool busy() const override { return moving_; }

  void run();
  // The play thread.
  void loop();
  void aim(MillPlayer& player, Clock::time_point& last);
  void aim_at_line(MillPlayer& player);
  MillMoment play_on(MillPlayer& player, double elapsed_s);
  void show(const MillPlayer& player);

  const PlaybackFiles files_;
  MillRequest request_;
  MillPlan plan_;
  std::vector<std::string> program_names_;
  std::vector<ProgramText> texts_;
  size_t all_lines_ = 0;
  MillTape tape_;

  LatestValue<Shown> states_;
  SmallQueue<LiveTick, 1024> ticks_;
  LatestValue<Tool> tools_;
  std::atomic<bool> moving_{false}, stopping_{false};
  bool hashed_ = false;  // history_.hash is that of the shown model

  mutable std::mutex mutex_;  // guards the following
  std::condition_variable changed_;
  PlaybackStatus status_;
  std::vector<std::string> warnings_;
  struct Wish {
    std::optional<double> time_s;
    std::optional<bool> step_forward;
    std::optional<std::pair<int, int>> line;  // program, line
  };
  Wish wish_;
  double clock_s_ = 0;  // wanted time while it plays
  MillMoment goal_;
  std::optional<double> breakpoint_s_;  // the end of the last one that it has passed

  std::thread run_thread_, play_thread_;
};

}  // namespace kibori
