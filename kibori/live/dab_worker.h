// SPDX-License-Identifier: MIT
// The thread that computes reshaping strokes, because they are too slow for a tick. A dab is one
// change of the surface within a brush. The servo thread never waits for the worker.
//
//   servo:   begin(stroke), move(pose) ──► ReshapeStroke, on a separate model ──► take(done)
//
// The results are in the order of the moves. A result contains the state of the model after the
// move. The servo thread restores this state between two ticks, as for an undo. A stroke begins
// with the first move that changes the model. Earlier moves have no result.
//
// Dabs follow the whole path, even if the worker is late. The queue is bounded, but no path is
// lost:
//
//   less than half full   every pose is a move
//   half full             crowded() returns true. A hand that can wait does so (Device::can_wait).
//                         For other hands, poses on a straight line are merged (PoseMerger).
//   full                  move() returns false, and the stroke ends at the last accepted pose
//
// A warp depends only on the last pose. If several moves wait, the worker computes the warp only
// for the newest one. If the queue is crowded, only the newest pose is kept.
//
// Dabs also use threads of TBB's pool, which have normal priority. spare_threads() leaves one
// processor for the servo thread, and one for drawing.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/live/pose_merger.h>
#include <kibori/motion/reshape_stroke.h>

namespace kibori {

class DabWorker {
 public:
  struct Stroke {
    ReshapeSettings settings;
    std::shared_ptr<const std::vector<Material>> materials;
    Pose start;           // pose of the tool
    Snapshot state;       // state of the model at the start of the stroke
    LatticeBox bounds;    // bounds of the material at the start of the stroke
    uint64_t number = 0;  // begin() sets it
  };
  // The result of one move.
  struct Done {
    uint64_t stroke = 0;
    Pose before;                // pose of the tool before the move
    ToolTick result;            // result of the tick; its pose is that after the move
    bool ends = false;          // true for the result of ReshapeStroke::end
    double work_per_mm = 0;     // see held_force
    double stiffness_n_mm = 0;  // for warps: see MaxwellForce
    double pending_mm3 = 0;     // at the end of a press: clay that found no room
    bool failed = false;        // true if the move could not be computed; the stroke ends before it
    bool changed = false;       // true if the model changed; then `state` and `bounds` are set
    Snapshot state;
    LatticeBox bounds;
  };

  // `threads` is the number of threads for dabs. It does not change the results. `after_change` is
  // for tests of slow machines. The worker's thread calls it after each move that changed the
  // model.
  explicit DabWorker(std::function<void()> after_change = {}, int threads = spare_threads());
  ~DabWorker();
  DabWorker(const DabWorker&) = delete;

  // Size of the queue: 8 s of a hand at 1 kHz, 1 MB. The second half is for merged poses.
  static constexpr size_t kMaxMoves = 8192;
  // Maximum number of results that are not taken yet.
  static constexpr size_t kMaxDone = 64;
  // Tolerance for merged poses [cells].
  static constexpr double kMergeTolerance = 0.05;

  // Returns the number of processors minus two, from 1 to 4.
  static int spare_threads();

  // The next functions are for the servo thread. None of them waits, locks or allocates. begin()
  // starts a stroke. It returns false if kMaxStrokes strokes are waiting.
  bool begin(Stroke stroke);
  // Sends the worker a move of the tool to `pose`. `pressure` is that of a pen. Returns false if
  // the queue has no room, even for a merged pose.
  bool move(const Pose& pose, double pressure = 1);
  // Sends the merged poses to the worker. Returns false if there is no room. Before the end of a
  // stroke, call it until it returns true.
  bool flush();
  // Ends the stroke at its last pose (ReshapeStroke::end). Returns false if there is no room yet.
  bool end();
  // Returns true if at least half of the queue is in use, or if begin() would return false.
  bool crowded() const;
  // Returns the number of moves that the worker has not processed. Merged poses count as one move.
  size_t pending() const;
  // If there is a result, moves the next one to `done` and returns true.
  bool take(Done& done);
  // Discards all strokes so far, with the results that are not taken yet.
  void drop();
  // Returns true if all moves are processed. Then take() returns the last results.
  bool settled() const;

 private:
  static constexpr size_t kMaxStrokes = 4;
  // Maximum memory of dabs that is kept after a stroke [bytes]. It is enough for brushes of about
  // 80 cells.
  static constexpr size_t kMaxKeptBytes = 256 << 20;
  struct Move {
    uint64_t stroke = 0;
    Pose pose;
    double pressure = 1;
    bool ends = false;
  };
  size_t queued() const;
  void merge_from_sent();
  bool push(const Pose& pose, double pressure, bool ends);
  void signal();
  void run();
  void work(const Move& move);
  void give_up();
  void clear_bench();
  bool is_dropped(uint64_t stroke) const {
    return stroke <= dropped_.load(std::memory_order_acquire);
  }
  // The worker's model for one stroke. While it exists, it keeps old tiles in memory.
  struct Bench {
    Bench(const Stroke& stroke, int threads, std::shared_ptr<DabMemory> memory)
        : model(stroke.state, stroke.bounds), reshape(model, std::move(memory)) {
      reshape.set_threads(threads);
    }
    TriDexel model;
    ReshapeStroke reshape;
  };

  const std::function<void()> after_change_;
  const int threads_;
  // Members for the servo thread.
  uint64_t number_ = 0, moves_ = 0;
  Pose sent_;                 // the last pose in the queue
  double sent_pressure_ = 1;  // pressure with sent_
  PoseMerger merged_;
  bool keeps_newest_ = false;  // true if the stroke is a warp
  double merge_tolerance_mm_ = 0, merge_reach_mm_ = 0;
  // Members that both threads use.
  SmallQueue<Stroke, kMaxStrokes> strokes_;
  SmallQueue<Move, kMaxMoves> waiting_;
  SmallQueue<Done, kMaxDone> done_;
  std::atomic<uint64_t> dropped_{0};   // strokes up to this number are discarded
  std::atomic<uint64_t> answered_{0};  // number of moves that the worker has processed
  std::atomic<int> signals_{0};
  std::atomic<bool> stopping_{false};
  // Members for the worker's thread.
  std::shared_ptr<DabMemory> memory_ = std::make_shared<DabMemory>();
  std::unique_ptr<Bench> bench_;  // model of the current stroke
  Stroke stroke_;
  Pose last_;
  bool changed_ = false;
  std::thread thread_;
};

}  // namespace kibori
