// SPDX-License-Identifier: MIT
// The thread that computes reshaping strokes beside the servo, which never waits for it.
//
//   servo:   begin(stroke), move(pose) ──► ReshapeStroke, on a model beside ──► take(done)
//
// What is taken comes in the order of the moves, each with the state of the model after it: the
// servo restores that between two ticks, as an undo does. Moves before the first one that changes
// anything are no part of the stroke, and nothing comes of them. A warp is a function of the last
// pose alone: where moves are waiting, it is computed for the newest of them.
//
// Dabs may run on more threads than the worker's own. They are the pool's, of ordinary priority,
// and fewer than the machine's processors, so that the servo and who draws what it carves find one
// each.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/reshape_stroke.h>

namespace kibori {

class DabWorker {
 public:
  struct Stroke {
    ReshapeSettings settings;
    std::shared_ptr<const std::vector<Material>> materials;
    Pose start;           // of the tool
    Snapshot state;       // of the model, where it begins
    LatticeBox bounds;    // of its material
    uint64_t number = 0;  // begin() sets it
  };
  // A move that belongs to its stroke.
  struct Done {
    uint64_t stroke = 0;
    Pose before;                // of the tool
    ToolTick felt;              // with the pose after it
    bool ends = false;          // see end()
    double work_per_mm = 0;     // see held_force
    double stiffness_n_mm = 0;  // of a warp: see MaxwellForce
    double owed_mm3 = 0;        // what a press could not give back, at its end
    bool failed = false;        // it could not be computed: its stroke ends before it
    bool changed = false;       // then there is a state
    Snapshot state;
    LatticeBox bounds;
  };

  // `threads`: on how many threads dabs run; what comes of them does not depend on it.
  explicit DabWorker(int threads = spare_threads());
  ~DabWorker();
  DabWorker(const DabWorker&) = delete;

  // The machine's processors but two, from 1 to 4.
  static int spare_threads();

  // The servo's thread; none of these waits, locks or allocates.
  // Whether a stroke can begin now: not while kMaxStrokes are waiting.
  bool begin(Stroke stroke);
  // The tool moved to `pose`. False while kMaxMoves are waiting: then the next move goes from where
  // the last one that was taken ended. `ends`: the stroke is over there (ReshapeStroke::end).
  bool move(const Pose& pose, bool ends = false);
  // The next move that is done, if one is.
  bool take(Done& done);
  // The strokes so far are over; moves that were not taken are as if they had not been.
  void drop();
  // Whether nothing more will come.
  bool settled() const;

 private:
  static constexpr size_t kMaxStrokes = 4, kMaxMoves = 32, kMaxDone = 64;
  // Memory of dabs that is kept after a stroke [bytes]: of brushes of some 80 cells.
  static constexpr size_t kMostKept = 256 << 20;
  struct Move {
    uint64_t stroke = 0;
    Pose pose;
    bool ends = false;
  };
  void signal();
  void run();
  void work(const Move& move);
  void give_up();
  void clear_bench();
  bool is_dropped(uint64_t stroke) const {
    return stroke <= dropped_.load(std::memory_order_acquire);
  }
  // A model beside the servo's for one stroke: it keeps tiles alive that no one else needs.
  struct Bench {
    Bench(const Stroke& stroke, int threads, std::shared_ptr<DabMemory> memory)
        : model(stroke.state, stroke.bounds), reshape(model, std::move(memory)) {
      reshape.set_threads(threads);
    }
    TriDexel model;
    ReshapeStroke reshape;
  };

  const int threads_;
  // The servo's.
  uint64_t number_ = 0, moves_ = 0;
  // Of both.
  SmallQueue<Stroke, kMaxStrokes> strokes_;
  SmallQueue<Move, kMaxMoves> waiting_;
  SmallQueue<Done, kMaxDone> done_;
  std::atomic<uint64_t> dropped_{0};   // strokes up to this one
  std::atomic<uint64_t> answered_{0};  // moves
  std::atomic<int> signals_{0};
  std::atomic<bool> stopping_{false};
  // The worker's.
  std::shared_ptr<DabMemory> memory_ = std::make_shared<DabMemory>();
  std::unique_ptr<Bench> bench_;  // of the stroke that is being made
  Stroke stroke_;
  Pose last_;
  bool changed_ = false;
  std::thread thread_;
};

}  // namespace kibori
