// SPDX-License-Identifier: MIT
// What the servo thread owns, and what a command may do with it between two ticks: model, one hand
// or two, and the stroke that is being made. LiveCarving gives it to the
// commands that others post, and to its owner while no thread runs; so whoever holds one may call
// everything here.
#pragma once

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

// Of the first hand, and of all.
struct LiveSettings : ServoHandSettings {
  double rate_hz = 1000;  // 100 ... 4000
  Brush brush;            // of a mode that reshapes
  std::vector<Material> materials{Material{}};
  Symmetry symmetry;
  ForceModel model = ForceModel::series;
  ServoHandSettings second;      // of a second hand; its mode is cut, deposit, touch or off
  int snapshot_ticks = 16;       // between snapshots
  bool log = false;              // strokes go into LiveCarving::log(), for a DocumentWriter
  double idle_s = 0.3;           // a stroke ends when the tool has not cut or filled for so long
  bool watched = false;          // ticks can be read by next_tick()
  Crumbs crumbs = Crumbs::sort;  // what becomes of what a stroke severs, where strokes are logged
  bool armed = true;  // start() arms the safety stage; else safety().arm() does, by a command
};

// What one tick came to: of the first hand, and of all.
struct LiveTick : HandTick {
  uint64_t number = 0;  // of all ticks that are told: one that is missing was left out
  double time_s = 0;    // since the servo thread began; of its own clock
  double owed_mm3 = 0;  // clay that was pressed away and found no room, at a stroke's end
  // What the stroke before severed: material that fell away, and pieces that are bodies now.
  double fallen_mm3 = 0;
  int parted = 0;
  bool gave_up = false;  // a brush's stroke took more memory than there is, and ended early
  std::optional<HandTick> second;
};

// Over all ticks.
struct LiveTotals {
  double removed_mm3 = 0, deposited_mm3 = 0;
  double max_computed_n = 0, max_given_n = 0;
  uint64_t cutting_ticks = 0;
  // Ticks in which the device moved farther than a hand can; the tool was put there.
  uint64_t jumps = 0;
  Trip trip = Trip::none;  // the first
};

// The body that the tool works on.
struct WorkedBody {
  BodyId id = 1;
  Pose pose;                                    // of its lattice in the world
  bool locked = false;                          // nothing changes it
  std::shared_ptr<const NoGo> no_go = nullptr;  // that strokes on it may not cut
};

class ServoContext {
 public:
  // Tiles per field that may be edited between two refills without asking the system for memory.
  // Callers that keep snapshots must refill (Snapshot::keep_ready).
  static constexpr int kReadyTiles = 1024;

  TriDexel& model() { return *model_; }
  // Of the first hand.
  Device& device() { return first_.device(); }
  SafetyStage& safety() { return first_.safety(); }
  const PassivityObserver& passivity() const { return first_.passivity(); }
  LiveSettings& settings() { return settings_; }
  // The second hand; null: there is none.
  ServoHand* second() { return second_.get(); }
  // Its tool is at `pose`, or backed out from there along its axis until it is clear of material,
  // and works from now on. Gives where it is; nothing where it can't be clear. Unlike place_clear()
  // it goes on with the stroke that is being made.
  std::optional<Pose> put_second_clear(const Pose& pose);
  // The same, without looking whether it is clear.
  void put_second(const Pose& pose);
  // The spring's stiffness [N/mm]; where the device could not bear it, nothing changes.
  void set_stiffness(double n_mm);
  // The hand's strength [N] and stiffness, and the share of the cut's force that it bears; a device
  // is given the pull times `force_scale`. Where it could not bear that, nothing changes.
  void set_hand(double stiffness_n_mm, double strength_n, double hand_share, double force_scale);
  // From the next stroke on; check_symmetry has passed.
  void set_symmetry(const Symmetry& symmetry);
  // The next reading of the device puts the tool there at once; nothing is cut on the way.
  void place_again() { first_.place_again(); }
  // The model was changed from outside.
  void model_changed();
  // Another tool from now on. Where it stands in material it backs out along its axis, and comes in
  // again from there; where it can't, it waits to be pulled out.
  void change_tool(const Tool& tool);
  // The tool is at `pose`, or backed out from there along its axis until it is clear of material,
  // and works from now on. Gives where it is; nothing where it can't be clear: it then waits there.
  std::optional<Pose> place_clear(const Pose& pose);
  // The same, without looking whether it is clear: where material is put down.
  void place_at(const Pose& pose);
  // A mallet's blow of so much work, in the next tick: see SpringTool::advance.
  void strike(double nmm) { first_.strike(nmm); }

  // The model is that of another step of its document, or of another body, from now on, whose
  // material lies within `bounds`; the log says so. `body` is then what was worked on before, so
  // that its memory is let go of elsewhere.
  void go_to(const Snapshot& state, const LatticeBox& bounds, WorkedBody& body);
  // The model is of this body; the same of `body`.
  void stand(WorkedBody& body);
  // The log says that all before this was done before it was asked for. Until go_to() or go_on()
  // the material is only felt.
  void fence_log() {
    log_.fence();
    fenced_ = true;
  }
  void go_on() { fenced_ = false; }
  // Ends the stroke that is being made, and waits for its dabs and crumbs: for the owner, while no
  // thread runs. LiveCarving::stop() does it where one ran.
  void finish_stroke();

 private:
  friend class LiveCarving;
  using Watched = SmallQueue<LiveTick, 8192>;
  // `settings` have passed LiveCarving::make.
  ServoContext(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
               const LiveSettings& settings, std::unique_ptr<Device> second);
  ServoContext(const ServoContext&) = delete;

  // One tick, `elapsed_s` after the last.
  LiveTick tick(double elapsed_s);
  void discard_stroke();
  // Takes no more of the hand's way for dabs; whether all that are under way are in the model, and
  // what the stroke before severed is taken out.
  bool settle();
  // The same, and waits for them.
  void settle_all();
  // Ends the stroke that is being made; dabs that are under way are left off. What it severed is
  // looked for from now on.
  void end_stroke();
  void take_crumbs();
  // Touch or off where a tool may not change anything now.
  Mode mode_now(const ServoHand& hand) const;
  bool is_second(const ServoHand& hand) const { return &hand == second_.get(); }
  // f(hand) of each.
  template <class F>
  void for_hands(F&& f) {
    f(first_);
    if (second_) f(*second_);
  }
  void place_in_body(const Pose& pose);
  // Places the tool, in the body; the stroke that is being made goes on.
  void put(ServoHand& hand, const Pose& pose);
  Pose to_world(const Pose& pose) const;
  Pose to_body(const Pose& pose) const;
  // The brush of a reshaping mode goes on from `before` to where the tool is now; what the worker
  // has done comes into the model, and is felt.
  void reshape(Mode mode, const Pose& before, LiveTick& result);
  void take_dabs(LiveTick& result);
  void dab_to(const Pose& pose, bool ends = false);
  // `start`: of the first hand's tool; of the second hand's, where it takes part.
  void begin_log(const Pose& start, const Pose* second);
  const std::shared_ptr<const std::vector<Material>>& shared_materials();
  void keep_before_stroke();
  // The hand's next place, and what its tool does on its way there.
  ServoHand::Advance advance(ServoHand& hand, Mode& mode);
  LiveTick advance_first();
  HandTick advance_second();
  void to_world(HandTick& tick) const;
  void count(const HandTick& tick);
  void note(LiveTick& tick);
  // A tick is in the log once it is known what its hand was given.
  void log_tick(const ServoHand& hand, const ServoHand::Advance& done);
  void log_waiting();
  Wrench given_in_body(const ServoHand& hand) const;

  std::unique_ptr<TriDexel> model_;
  LiveSettings settings_;
  ServoHand first_;
  std::unique_ptr<ServoHand> second_;
  bool second_logged_ = false;  // it takes part in the stroke that is being made
  StrokeLog log_;
  struct WaitingTick {
    StrokeTick tick;
    Wrench felt;
  };
  std::optional<WaitingTick> waiting_tick_;  // for the log
  std::shared_ptr<const std::vector<Material>> logged_materials_;
  bool in_stroke_ = false;
  std::unique_ptr<Watched> watched_;    // null: no one does
  uint64_t noted_ = 0;                  // ticks
  double time_s_ = 0;                   // of all ticks
  std::shared_ptr<const Grain> grain_;  // of the lattice's wood
  WorkedBody body_;
  bool turned_ = false;  // it stands otherwise than the world
  bool fenced_ = false;
  Snapshot before_stroke_;              // what discard_stroke() goes back to
  uint64_t before_generation_ = ~0ull;  // of it
  int idle_ticks_ = 0;                  // since the stroke's last edit
  double stroke_removed_mm3_ = 0;
  CrumbWorker crumbs_;
  double fallen_mm3_ = 0;  // that no tick has told of yet, as the next
  int parted_ = 0;
  Crumbs stroke_crumbs_ = Crumbs::stay;  // of the stroke that is being made
  DabWorker dabs_;
  bool dabbing_ = false;   // a stroke of dabs is with the worker
  bool settling_ = false;  // it takes no more moves
  bool settled_ = true;    // all that it took are in the model
  Pose dab_pose_;          // its last move, which waits for a place where there was none
  bool dab_waits_ = false;
  bool dab_ends_ = false;  // that move is the stroke's end
  // Of the dabs, as it is felt: faded from one to the next; of the tool, smoothed.
  double work_per_mm_ = 0, felt_per_mm_ = 0;
  Vec3 velocity_mm_s_ = Vec3::Zero();
  double stiffness_n_mm_ = 0;  // of a warp
  MaxwellForce pull_;
  LiveTotals totals_;
};

}  // namespace kibori
