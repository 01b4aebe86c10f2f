// SPDX-License-Identifier: MIT
// A milling job that pages watch, at any time of its run and at any speed.
//
//   run thread     run_plan ─► MillTape       computes ahead: moves, forces, collisions, snapshots
//   play thread    MillPlayer ─► states_      goes to the wanted time within what is computed
//   server thread  follow(), status()         shows the newest state
//
// The threads share only short critical sections. So no thread waits for the work of another
// thread.
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

// The state of a playback that pages show.
struct PlaybackStatus {
  double time_s = 0;      // the time that is shown
  double computed_s = 0;  // end of the computed part
  double share = 0;       // progress of the computation, 0..1
  bool done = false;      // true if all is computed
  bool playing = false;
  double speed = 1;                     // 0: highest speed
  bool stops = true;                    // true: stops at collisions
  int program = 0, line = 0, tool = 0;  // line 0: before the first move
  bool rapid = false;
  double force_n = 0, power_w = 0;
  size_t problems = 0;  // number of collisions so far
  int stopped_at = -1;  // index of the collision at which it stopped; -1: none
  bool operator==(const PlaybackStatus&) const = default;
};

class PlaybackSession final : public Session {
 public:
  // Reads all files and begins to compute. Errors: those of playback_request, plan_milling and
  // make_models; the stock is too fine for a page.
  static Result<std::unique_ptr<Session>> start(PlaybackFiles files, const PlaybackChoice& choice);
  ~PlaybackSession() override;

  PlaybackSession* playback() override { return this; }

  // ---- Requests of the user.
  void play(bool playing, double speed, bool stops);
  void seek(double time_s);
  // Goes to the end of the next line that moves, or to the beginning of the current line.
  void step_line(bool forward);
  // Goes to the end of a line (from 1), at its first execution. Waits until this part is computed.
  void go_to_line(int program, int line);

  // ---- State for pages.
  PlaybackStatus status() const;
  const std::vector<std::string>& programs() const { return program_names_; }
  const std::vector<ProgramText>& texts() const { return texts_; }
  std::vector<MillTape::Collision> collisions() const { return tape_.collisions(); }
  // Returns the end of the move that collides [s].
  double time_of(const MillTape::Collision& collision) const;
  MillTape::Curve curve(size_t parts) const { return tape_.curve(parts); }
  // Returns sentences about the job. They are complete when the run is done.
  std::vector<std::string> warnings() const;
  std::string error() const;  // reason why the run ended early, or empty
  // Writes the current tool to `tool` and returns true, if it has changed since the last call. Call
  // it on one thread.
  bool next_tool(Tool& tool) { return tools_.take(tool); }
  // Return the job, so that it can be run again into a document.
  const PlaybackFiles& files() const { return files_; }
  const MillRequest& request() const { return request_; }

  // A playback has no document, so it has no thumbnails and cannot be saved as a copy.
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
  // Functions of the play thread.
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
  bool hashed_ = false;  // true if history_.hash is that of the shown model

  mutable std::mutex mutex_;  // guards the members below
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
