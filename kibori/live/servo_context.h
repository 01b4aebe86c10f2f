// SPDX-License-Identifier: MIT
// The data of the servo thread (model, one or two hands, current stroke), and the operations that a
// command may call between two ticks. LiveCarving passes a reference to posted commands, and to its
// owner while no thread runs. So code that has a reference may call everything here.
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
  Brush brush;            // for a mode that reshapes
  std::vector<Material> materials{Material{}};
  Symmetry symmetry;
  ForceModel model = ForceModel::series;
  ServoHandSettings second;      // for a second hand; its mode is cut, deposit, touch or off
  int snapshot_ticks = 16;       // ticks between snapshots
  bool log = false;              // strokes go into LiveCarving::log(), for a DocumentWriter
  double idle_s = 0.3;           // a stroke ends if the tool has not cut or filled for this time
  bool watched = false;          // next_tick() returns ticks
  Crumbs crumbs = Crumbs::sort;  // rule for severed pieces, if strokes are logged
  std::function<void()> after_dab = {};  // for tests of a slow machine: see DabWorker
  bool armed = true;  // start() arms the safety stage; otherwise a command calls safety().arm()
};

// Result of one tick: of the first hand, and of the session.
struct LiveTick : HandTick {
  uint64_t number = 0;     // number of the tick; a gap means that ticks were lost
  double time_s = 0;       // since the servo thread started, by its own clock
  double pending_mm3 = 0;  // pressed clay that found no room, at the end of a stroke
  // Result of the last stroke: material that fell away, and pieces that became bodies.
  double fallen_mm3 = 0;
  int parted = 0;
  // A brush's stroke ended early: it needed more memory than available, or it was so far behind the
  // hand that there was no room for more of the path.
  bool gave_up = false;
  // Mode of a brush's stroke that has just ended and changed nothing: there was nothing to smooth,
  // to rasp, to fill or to flatten.
  std::optional<Mode> idle_brush;
  size_t pending = 0;  // poses of a brush's stroke that are not in the model yet
  std::optional<HandTick> second;
};

// Totals over all ticks.
struct LiveTotals {
  double removed_mm3 = 0, deposited_mm3 = 0;
  double max_computed_n = 0, max_given_n = 0;
  uint64_t cutting_ticks = 0;
  // Ticks in which the device moved farther than a hand can. The tool was placed there without a
  // path.
  uint64_t jumps = 0;
  Trip trip = Trip::none;  // the first one
};

// The body that the tool works on.
struct WorkedBody {
  BodyId id = 1;
  Pose pose;                                    // of its lattice in the world
  bool locked = false;                          // nothing changes it
  std::shared_ptr<const NoGo> no_go = nullptr;  // strokes on the body must not cut it
};

class ServoContext {
 public:
  // Number of tiles of each field for which the pools have memory. If edits change more before the
  // pools are refilled, they allocate. Callers that keep snapshots must refill
  // (Snapshot::keep_ready).
  static constexpr int kReadyTiles = 1024;

  TriDexel& model() { return *model_; }
  // For the first hand.
  Device& device() { return first_.device(); }
  SafetyStage& safety() { return first_.safety(); }
  const PassivityObserver& passivity() const { return first_.passivity(); }
  LiveSettings& settings() { return settings_; }
  // The second hand; null if there is none.
  ServoHand* second() { return second_.get(); }
  // Places the second hand's tool at `pose`, or backs it out from there along its axis until it is
  // clear of material. From then on the hand works. Returns the final pose; nullopt if the tool
  // cannot be clear. Unlike place_clear(), it continues the current stroke.
  std::optional<Pose> put_second_clear(const Pose& pose);
  // The same, without the check for material.
  void put_second(const Pose& pose);
  // Sets the spring's stiffness [N/mm]. Does nothing if the device cannot render it.
  void set_stiffness(double n_mm);
  // Sets the hand's stiffness, its strength [N], and the share of the cutting force that it
  // supports. The device receives the pull times `force_scale`. Does nothing if the device cannot
  // render that.
  void set_hand(double stiffness_n_mm, double strength_n, double hand_share, double force_scale);
  // Takes effect at the next stroke. `symmetry` must have passed check_symmetry.
  void set_symmetry(const Symmetry& symmetry);
  // At the next reading of the device, the tool jumps to that pose and cuts nothing in between.
  void place_again() { first_.place_again(); }
  // Call after the model was changed from outside.
  void model_changed();
  // Changes the tool. If the new tool is in material, it backs out along its axis and enters again
  // from there. If it cannot, it waits until the hand pulls it out.
  void change_tool(const Tool& tool);
  // Places the tool at `pose`, or backs it out along its axis until it is clear of material. Then
  // it works. Returns the final pose. If the tool cannot be clear, it returns nullopt and the tool
  // waits there.
  std::optional<Pose> place_clear(const Pose& pose);
  // The same, without the check for material. For modes that add material.
  void place_at(const Pose& pose);
  // A mallet's blow with this energy [N mm], in the next tick: see SpringTool::advance.
  void strike(double nmm) { first_.strike(nmm); }

  // Restores the model to another step of its document, or to another body. Its material is within
  // `bounds`. The log records this. Afterwards, `body` holds the previous body, so that its memory
  // is freed on another thread.
  void go_to(const Snapshot& state, const LatticeBox& bounds, WorkedBody& body);
  // Changes the body of the model. `body` is used as in go_to().
  void set_body(WorkedBody& body);
  // Adds a fence to the log, for a request: everything before the fence was done before the
  // request. Until go_to() or resume(), the tool changes no material and only produces forces.
  void fence_log() {
    log_.fence();
    fenced_ = true;
  }
  void resume() { fenced_ = false; }
  // Ends the current stroke, and waits for its dabs and crumbs. For the owner, while no thread
  // runs. LiveCarving::stop() calls it if a thread ran.
  void finish_stroke();

 private:
  friend class LiveCarving;
  using Watched = SmallQueue<LiveTick, 8192>;
  // `settings` must have passed the checks of LiveCarving::make.
  ServoContext(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
               const LiveSettings& settings, std::unique_ptr<Device> second);
  ServoContext(const ServoContext&) = delete;

  // One tick, `elapsed_s` after the last.
  LiveTick tick(double elapsed_s);
  void discard_stroke();
  // Sends no more moves to the dab worker. Returns true if the model contains all pending dabs, and
  // the severed pieces of the last stroke are removed.
  bool settle();
  // The same, but waits until that is true. Not for the servo thread's ticks.
  void settle_all();
  // Ends the current stroke and drops pending dabs. The search for severed pieces starts.
  void end_stroke();
  // Ends the current stroke here, as soon as its pending dabs are done. Until then, the hand does
  // nothing.
  void break_off();
  void take_crumbs();
  // The mode of a hand in this tick: `touch` or `off` instead of its own while it must not change
  // anything.
  Mode mode_now(const ServoHand& hand) const;
  bool is_second(const ServoHand& hand) const { return &hand == second_.get(); }
  // Calls f(hand) for each hand.
  template <class F>
  void for_hands(F&& f) {
    f(first_);
    if (second_) f(*second_);
  }
  void place_in_body(const Pose& pose);
  // Places the tool, in the body's coordinates. The current stroke continues.
  void put(ServoHand& hand, const Pose& pose);
  Pose to_world(const Pose& pose) const;
  Pose to_body(const Pose& pose) const;
  // Moves the brush of a reshaping mode from `before` to the tool's current pose. Applies the
  // worker's results to the model and to the force.
  void reshape(Mode mode, const Pose& before, LiveTick& result);
  void take_dabs(LiveTick& result);
  // Returns false if the dab worker has no room for more of the path.
  bool dab_to(const Pose& pose);
  // True if the hand must wait for the dab worker.
  bool waits(ServoHand& hand);
  // `start` is the pose of the first hand's tool. `second` is that of the second hand's, if it
  // takes part.
  void begin_log(const Pose& start, const Pose* second);
  const std::shared_ptr<const std::vector<Material>>& shared_materials();
  void keep_before_stroke();
  // Computes the hand's next pose, and moves its tool there.
  ServoHand::Advance advance(ServoHand& hand, Mode& mode);
  LiveTick advance_first();
  HandTick advance_second();
  void to_world(HandTick& tick) const;
  void count(const HandTick& tick);
  void note(LiveTick& tick);
  // The log gets a tick only when the force that its hand received is known.
  void log_tick(const ServoHand& hand, const ServoHand::Advance& done);
  void log_waiting();
  Wrench given_in_body(const ServoHand& hand) const;

  std::unique_ptr<TriDexel> model_;
  LiveSettings settings_;
  ServoHand first_;
  std::unique_ptr<ServoHand> second_;
  bool second_logged_ = false;  // it takes part in the current stroke
  StrokeLog log_;
  struct PendingTick {
    RecordedTick tick;
    Wrench computed;
  };
  std::optional<PendingTick> pending_tick_;  // for the log
  std::shared_ptr<const std::vector<Material>> logged_materials_;
  bool in_stroke_ = false;
  std::unique_ptr<Watched> watched_;    // null: not watched
  uint64_t noted_ = 0;                  // number of ticks so far: LiveTick::number
  double time_s_ = 0;                   // sum of the times of all ticks
  std::shared_ptr<const Grain> grain_;  // of the lattice's wood
  WorkedBody body_;
  bool turned_ = false;  // the body's pose differs from the world's
  bool fenced_ = false;
  Snapshot before_stroke_;              // the state that discard_stroke() restores
  uint64_t before_generation_ = ~0ull;  // generation of the model in before_stroke_
  int idle_ticks_ = 0;                  // since the stroke's last edit
  double stroke_removed_mm3_ = 0;
  double moved_mm3_ = 0;            // volume that the brush's stroke added plus that it removed
  std::optional<Mode> idle_brush_;  // not reported by a tick yet
  CrumbWorker crumbs_;
  double fallen_mm3_ = 0;  // not reported by a tick yet, like parted_
  int parted_ = 0;
  Crumbs stroke_crumbs_ = Crumbs::stay;  // of the current stroke
  DabWorker dabs_;
  bool dabbing_ = false;     // the worker has a stroke of dabs
  bool settling_ = false;    // the stroke accepts no more moves
  bool settled_ = true;      // the model contains all its accepted moves
  bool dab_ends_ = false;    // the end of the stroke is not sent yet: see ends_apart
  bool breaks_off_ = false;  // the stroke ends as soon as it is settled
  bool hand_waits_ = false;  // the first hand was not read in this tick
  // Force of the dabs; force_per_mm_ fades from one dab to the next. velocity_mm_s_ is the smoothed
  // velocity of the tool.
  double work_per_mm_ = 0, force_per_mm_ = 0;
  Vec3 velocity_mm_s_ = Vec3::Zero();
  double stiffness_n_mm_ = 0;  // of a warp
  MaxwellForce pull_;
  LiveTotals totals_;
};

}  // namespace kibori
