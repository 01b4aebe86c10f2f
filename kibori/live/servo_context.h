// SPDX-License-Identifier: MIT
// The data of the servo thread (model, one or two hands, current stroke), and the functions that a
// command may call between two ticks. LiveCarving passes a reference to posted commands. While no
// thread runs, LiveCarving also gives the reference to its owner. Code with a reference may call
// all public functions.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/live/crumb_worker.h>
#include <kibori/live/dab_worker.h>
#include <kibori/live/servo_hand.h>
#include <kibori/live/stroke_log.h>

namespace kibori {

// Settings of the first hand and of the session.
struct LiveSettings : ServoHandSettings {
  double rate_hz = 1000;  // 100 ... 4000
  Brush brush;            // for modes that reshape
  std::vector<Material> materials{Material{}};
  Symmetry symmetry;
  ForceModel model = ForceModel::series;
  ServoHandSettings second;      // second hand; its mode is cut, deposit, touch or off
  int snapshot_ticks = 16;       // number of ticks between snapshots
  bool log = false;              // strokes are written to LiveCarving::log(), for a DocumentWriter
  double idle_s = 0.3;           // a stroke ends if there was no edit for this time
  bool watched = false;          // next_tick() returns the ticks
  Crumbs crumbs = Crumbs::sort;  // rule for severed pieces, if strokes are logged
  std::function<void()> after_dab = {};  // for tests of a slow machine: see DabWorker
  bool armed = true;  // start() arms the safety stage; otherwise a command calls safety().arm()
};

// The result of one tick: of the first hand (HandTick), and of the session.
struct LiveTick : HandTick {
  uint64_t number = 0;     // number of the tick; a gap means that the reader lost ticks
  double time_s = 0;       // time since the first tick, as the sum of the ticks' durations
  double pending_mm3 = 0;  // at the end of a stroke: pressed clay that found no room
  // From the last stroke: volume that fell away, and number of pieces that became bodies.
  double fallen_mm3 = 0;
  int parted = 0;
  // A reshaping stroke ended early: it needed more memory than available, or its queue of poses was
  // full.
  bool gave_up = false;
  // Set if a brush's stroke has just ended and changed nothing: its mode. For example, there was
  // nothing to smooth.
  std::optional<Mode> idle_brush;
  size_t pending = 0;  // number of poses of a reshaping stroke that are not in the model yet
  std::optional<HandTick> second;
};

// Sums and maxima over all ticks.
struct LiveTotals {
  double removed_mm3 = 0, deposited_mm3 = 0;
  double max_computed_n = 0, max_given_n = 0;
  uint64_t cutting_ticks = 0;
  // Number of ticks in which the device moved farther than a hand can. Then the tool was placed at
  // the hand without a path.
  uint64_t jumps = 0;
  Trip trip = Trip::none;  // the first trip
};

// The body on which the tool works.
struct WorkedBody {
  BodyId id = 1;
  Pose pose;                                    // pose of the body's lattice in the world
  bool locked = false;                          // true if nothing may change the body
  std::shared_ptr<const NoGo> no_go = nullptr;  // region that strokes must not cut; null: none
};

class ServoContext {
 public:
  // Number of tiles of each field for which the pools have memory. If edits change more tiles
  // before the pools are refilled, the edits allocate. Callers that keep snapshots must refill the
  // pools (Snapshot::keep_ready).
  static constexpr int kReadyTiles = 1024;

  TriDexel& model() { return *model_; }
  // These belong to the first hand.
  Device& device() { return first_.device(); }
  SafetyStage& safety() { return first_.safety(); }
  const PassivityObserver& passivity() const { return first_.passivity(); }
  LiveSettings& settings() { return settings_; }
  // Returns the second hand, or null.
  ServoHand* second() { return second_.get(); }
  // Places the second hand's tool at `pose`, or moves it from there out along its axis until it is
  // clear of material. Then the tool works. Returns the final pose. If the tool cannot be clear,
  // returns nullopt, and the tool waits at `pose`. Unlike place_clear(), continues the current
  // stroke.
  std::optional<Pose> put_second_clear(const Pose& pose);
  // Places the second hand's tool at `pose`, without a check for material.
  void put_second(const Pose& pose);
  // Sets the stiffness of the spring [N/mm]. Does nothing if the device cannot render it.
  void set_stiffness(double n_mm);
  // Sets the stiffness of the hand's spring, the hand's strength [N], and the share of the cutting
  // force that the hand supports. The device receives the pull times `force_scale`. Does nothing if
  // the device cannot render it.
  void set_hand(double stiffness_n_mm, double strength_n, double hand_share, double force_scale);
  // Sets the symmetry for the next strokes. `symmetry` must have passed check_symmetry.
  void set_symmetry(const Symmetry& symmetry);
  // At the next reading of the device, the tool jumps to the hand's pose. It cuts nothing on the
  // path.
  void place_again() { first_.place_again(); }
  // Call this after other code changed the model.
  void model_changed();
  // Changes the tool. If the new tool is inside material, moves it out along its axis until it is
  // clear. If this is not possible, the tool waits until the hand pulls it out.
  void change_tool(const Tool& tool);
  // Places the tool at `pose`, or moves it from there out along its axis until it is clear of
  // material. Then the tool works. Returns the final pose. If the tool cannot be clear, returns
  // nullopt, and the tool waits at `pose`. Ends the current stroke.
  std::optional<Pose> place_clear(const Pose& pose);
  // Places the tool at `pose`, without a check for material. Modes that add material use it.
  void place_at(const Pose& pose);
  // Gives the tool a blow of a mallet with this energy [N mm], in the next tick: see
  // SpringTool::advance.
  void strike(double nmm) { first_.strike(nmm); }

  // Restores the model to another step of its document, or to another body. The material is within
  // `bounds`. The log gets the event `moved`. `body` is the new body. Afterwards, it contains the
  // old one, so that another thread frees its memory.
  void go_to(const Snapshot& state, const LatticeBox& bounds, WorkedBody& body);
  // Changes only the body. `body` is used as in go_to().
  void set_body(WorkedBody& body);
  // Adds a fence for a request to the log. Everything before the fence was done before the request.
  // Until go_to() or resume(), no tool changes the model. Tools that cut only produce forces.
  void fence_log() {
    log_.fence();
    fenced_ = true;
  }
  void resume() { fenced_ = false; }
  // Ends the current stroke, and waits for its dabs and crumbs. For the owner, while no thread
  // runs. The servo thread calls it when it stops.
  void finish_stroke();

 private:
  friend class LiveCarving;
  using Watched = SmallQueue<LiveTick, 8192>;
  // `settings` must have passed the checks of LiveCarving::make.
  ServoContext(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
               const LiveSettings& settings, std::unique_ptr<Device> second);
  ServoContext(const ServoContext&) = delete;

  // Runs one tick, `elapsed_s` after the last tick.
  LiveTick tick(double elapsed_s);
  void discard_stroke();
  // Sends no more moves to the dab worker. Returns true if the model contains all pending dabs, and
  // if the severed pieces of the last stroke are removed.
  bool settle();
  // Calls settle() until it returns true, and sleeps in between. Not for ticks of the servo thread.
  void settle_all();
  // Ends the current stroke and drops its pending dabs. Starts the search for severed pieces.
  void end_stroke();
  // Ends the current stroke here. If it has pending dabs, it ends when they are done. Until then,
  // the hand does nothing.
  void break_off();
  void take_crumbs();
  // Returns the mode of a hand in this tick. While the hand must not change the model, this is
  // `touch` or `off`.
  Mode mode_now(const ServoHand& hand) const;
  bool is_second(const ServoHand& hand) const { return &hand == second_.get(); }
  // Calls f(hand) for each hand.
  template <class F>
  void for_hands(F&& f) {
    f(first_);
    if (second_) f(*second_);
  }
  void place_in_body(const Pose& pose);
  // Places a tool. `pose` is in the coordinates of the body. The current stroke continues.
  void put(ServoHand& hand, const Pose& pose);
  Pose to_world(const Pose& pose) const;
  Pose to_body(const Pose& pose) const;
  // Moves the brush of a reshaping mode from `before` to the tool's current pose. Applies the
  // results of the worker to the model and to the force.
  void reshape(Mode mode, const Pose& before, LiveTick& result);
  void take_dabs(LiveTick& result);
  // Returns false if the dab worker has no room for the pose.
  bool dab_to(const Pose& pose);
  // Returns true if the hand must wait for the dab worker.
  bool waits(ServoHand& hand);
  // Logs the beginning of a stroke. `start` is the pose of the first hand's tool. `second` is the
  // pose of the second hand's tool, or null if this hand takes no part.
  void begin_log(const Pose& start, const Pose* second);
  const std::shared_ptr<const std::vector<Material>>& shared_materials();
  void keep_before_stroke();
  // Reads the next pose of the hand, and moves its tool there.
  ServoHand::Advance advance(ServoHand& hand, Mode& mode);
  LiveTick advance_first();
  HandTick advance_second();
  void to_world(HandTick& tick) const;
  void count(const HandTick& tick);
  void note(LiveTick& tick);
  // Keeps the tick for the log. log_waiting() logs it when the force that the hand received is
  // known.
  void log_tick(const ServoHand& hand, const ServoHand::Advance& done);
  void log_waiting();
  Wrench given_in_body(const ServoHand& hand) const;

  std::unique_ptr<TriDexel> model_;
  LiveSettings settings_;
  ServoHand first_;
  std::unique_ptr<ServoHand> second_;
  bool second_logged_ = false;  // true if the second hand takes part in the current stroke
  StrokeLog log_;
  struct PendingTick {
    RecordedTick tick;
    Wrench computed;
  };
  std::optional<PendingTick> pending_tick_;  // waits for log_waiting()
  std::shared_ptr<const std::vector<Material>> logged_materials_;
  bool in_stroke_ = false;
  std::unique_ptr<Watched> watched_;    // null: not watched
  uint64_t noted_ = 0;                  // number of ticks so far (LiveTick::number)
  double time_s_ = 0;                   // sum of the times of all ticks
  std::shared_ptr<const Grain> grain_;  // of the wood of the lattice
  WorkedBody body_;
  bool turned_ = false;  // true if the body's frame is not the world's
  bool fenced_ = false;
  Snapshot before_stroke_;              // state that discard_stroke() restores
  uint64_t before_generation_ = ~0ull;  // generation of the model in before_stroke_
  int idle_ticks_ = 0;                  // number of ticks since the stroke's last edit
  double stroke_removed_mm3_ = 0;
  double moved_mm3_ = 0;            // volume that the brush's stroke has moved
  std::optional<Mode> idle_brush_;  // waits for the next tick's result
  CrumbWorker crumbs_;
  double fallen_mm3_ = 0;  // waits for the next tick's result, as parted_ does
  int parted_ = 0;
  Crumbs stroke_crumbs_ = Crumbs::stay;  // rule of the current stroke
  DabWorker dabs_;
  bool dabbing_ = false;     // true while the worker has a stroke
  bool settling_ = false;    // true if the stroke accepts no more moves
  bool settled_ = true;      // true if the model contains all accepted moves
  bool dab_ends_ = false;    // true if the end must still be sent (ends_apart)
  bool breaks_off_ = false;  // true if the stroke ends when it is settled
  bool hand_waits_ = false;  // true if the first hand was not read in this tick
  // For the force of dabs. force_per_mm_ changes smoothly from one dab to the next. velocity_mm_s_
  // is the smoothed velocity of the tool.
  double work_per_mm_ = 0, force_per_mm_ = 0;
  Vec3 velocity_mm_s_ = Vec3::Zero();
  double stiffness_n_mm_ = 0;  // for warps
  MaxwellForce pull_;
  LiveTotals totals_;
};

}  // namespace kibori
