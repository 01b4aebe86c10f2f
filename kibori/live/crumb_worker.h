// SPDX-License-Identifier: MIT
// The thread that searches for crumbs: pieces that a stroke severed. The servo thread never waits
// for it.
//
//   servo:   begin(stroke that ended) ──► take_crumbs, on a separate model ──► take(done)
//
// The worker handles one stroke at a time. Until the servo thread has taken the result, no tool
// changes the model. Tools that cut only produce forces.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include <kibori/base/handover.h>
#include <kibori/body/bodies.h>

namespace kibori {

class CrumbWorker {
 public:
  struct Stroke {
    Snapshot before, after;
    LatticeBox bounds;  // bounds of the material after the stroke
    double removed_mm3 = 0;
    Crumbs rule = Crumbs::sort;
    std::shared_ptr<const NoGo> no_go;  // pieces that contain a part of it stay
  };
  struct Done {
    Stroke stroke;         // without the crumbs in `after` and `bounds`
    bool changed = false;  // true if there were crumbs
    CrumbResult crumbs;
  };

  CrumbWorker();
  ~CrumbWorker();
  CrumbWorker(const CrumbWorker&) = delete;

  // These functions are for the servo thread. Except wait(), none of them waits, locks or
  // allocates. Call begin() only if idle() is true.
  void begin(Stroke stroke);
  bool idle() const { return idle_; }
  // If there is a result, moves it to `done` and returns true. Then the worker is idle.
  bool take(Done& done);
  // Waits for the result of the current stroke. For callers that run the ticks themselves
  // (LiveCarving::tick).
  void wait() const;

 private:
  void signal();
  void run();

  bool idle_ = true;  // for the servo's thread
  // Members that both threads use.
  SmallQueue<Stroke, 2> strokes_;
  SmallQueue<Done, 2> done_;
  std::atomic<int> signals_{0}, answers_{0};
  int request_count_ = 0;  // for the servo's thread
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kibori
