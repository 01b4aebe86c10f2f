// SPDX-License-Identifier: MIT
// The thread that computes reshaping strokes, because they are too slow for a tick. The servo never
// waits for it.
//
//   servo:   begin(stroke), move(pose) ──► ReshapeStroke, on a separate model ──► take(done)
//
// Results arrive in the order of the moves. Each contains the state of the model after the move.
// The servo restores that state between two ticks, as an undo does. Moves before the first one that
// changes anything do not belong to the stroke and have no result.
//
// Dabs follow the whole path, even if they are late. The queue is bounded, and no path is lost:
//
//   less than half full   every pose is a move of its own
//   half full             crowded(): a hand that can wait does so (Device::can_wait). For any other
//                         hand, poses on a straight motion are merged (PoseMerger).
//   full                  move() returns false, and the stroke ends at the last accepted pose
//
// A warp is a function of the last pose alone. If several moves wait, it is computed for the newest
// of them, and a crowded queue keeps only the newest pose.
//
// Dabs also use threads of TBB's pool, which have normal priority. spare_threads() leaves one
// processor for the servo, and one for drawing.
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
    Pose start;           // of the tool
    Snapshot state;       // of the model at the start of the stroke
    LatticeBox bounds;    // of its material
    uint64_t number = 0;  // begin() sets it
  };
  // The result of one move of a stroke.
  struct Done {
    uint64_t stroke = 0;
    Pose before;                // of the tool
    ToolTick result;            // with the pose after the move
    bool ends = false;          // result of ReshapeStroke::end
    double work_per_mm = 0;     // see held_force
    double stiffness_n_mm = 0;  // of a warp: see MaxwellForce
    double pending_mm3 = 0;     // clay for which a press found no room, at its end
    bool failed = false;        // the move could not be computed: the stroke ends before it
    bool changed = false;       // true: the move changed the model; `state` and `bounds` are set
    Snapshot state;
    LatticeBox bounds;
  };

  // `threads`: number of threads for dabs. It does not change the result. `after_change`: for tests
  // of a slow machine; the worker's thread calls it after each move that changed its model.
  explicit DabWorker(std::function<void()> after_change = {}, int threads = spare_threads());
  ~DabWorker();
  DabWorker(const DabWorker&) = delete;

  // Size of the queue: 8 s of a hand at 1 kHz, 1 MB. The second half is for merged motions.
  static constexpr size_t kMaxMoves = 8192;
  // Max number of results that wait to be taken.
  static constexpr size_t kMaxDone = 64;
  // Tolerance of merged motions [cells].
  static constexpr double kMergeTolerance = 0.05;

  // The machine's processors minus two, from 1 to 4.
  static int spare_threads();

  // For the servo's thread. None of these waits, locks or allocates. begin() returns false while
  // kMaxStrokes are waiting.
  bool begin(Stroke stroke);
  // The tool moved to `pose`, with this pressure of a pen. Returns false if there is no room for it,
  // not even merged.
  bool move(const Pose& pose, double pressure = 1);
  // Sends the merged poses to the worker. Call it before the end of a stroke until it returns true.
  // Returns false if there is no room.
  bool flush();
  // The stroke ends at its last pose (ReshapeStroke::end). Returns false if there is no room yet.
  bool end();
  // True if more than half of the queue is in use, or if begin() would return false.
  bool crowded() const;
  // The number of moves that the worker has not processed. A merged motion counts as one.
  size_t pending() const;
  // Moves the next result to `done` if there is one.
  bool take(Done& done);
  // Discards all strokes so far, with the results that were not taken.
  void drop();
  // True if no more results will come.
  bool settled() const;

 private:
  static constexpr size_t kMaxStrokes = 4;
  // Memory of dabs that is kept after a stroke [bytes]. It is enough for brushes of about 80 cells.
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
  // A separate model for one stroke. While it exists, it keeps old tiles in memory.
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
  // For the servo's thread.
  uint64_t number_ = 0, moves_ = 0;
  Pose sent_;                 // the last pose in the queue
  double sent_pressure_ = 1;  // with it
  PoseMerger merged_;
  bool keeps_newest_ = false;  // the stroke is a warp
  double merge_tolerance_mm_ = 0, merge_reach_mm_ = 0;
  // Shared by both threads.
  SmallQueue<Stroke, kMaxStrokes> strokes_;
  SmallQueue<Move, kMaxMoves> waiting_;
  SmallQueue<Done, kMaxDone> done_;
  std::atomic<uint64_t> dropped_{0};   // strokes up to this number are discarded
  std::atomic<uint64_t> answered_{0};  // number of moves that the worker has processed
  std::atomic<int> signals_{0};
  std::atomic<bool> stopping_{false};
  // For the worker's thread.
  std::shared_ptr<DabMemory> memory_ = std::make_shared<DabMemory>();
  std::unique_ptr<Bench> bench_;  // of the current stroke
  Stroke stroke_;
  Pose last_;
  bool changed_ = false;
  std::thread thread_;
};

}  // namespace kibori
