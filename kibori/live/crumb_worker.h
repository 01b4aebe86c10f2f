// SPDX-License-Identifier: MIT
// The thread that searches for pieces that a stroke cut off. The servo never waits for it.
//
//   servo:   begin(stroke that ended) ──► take_crumbs, on a separate model ──► take(done)
//
// It handles one stroke at a time. Until the servo has taken the result, its tool changes no
// material and only produces forces.
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
    LatticeBox bounds;  // of the material
    double removed_mm3 = 0;
    Crumbs rule = Crumbs::sort;
    std::shared_ptr<const NoGo> no_go;  // pieces that contain a part of this region stay
  };
  struct Done {
    Stroke stroke;         // `after` and `bounds` exclude the crumbs
    bool changed = false;  // true if there were crumbs
    CrumbResult crumbs;
  };

  CrumbWorker();
  ~CrumbWorker();
  CrumbWorker(const CrumbWorker&) = delete;

  // For the servo's thread. Only wait() waits; none of these locks or allocates. Call begin() only
  // while idle.
  void begin(Stroke stroke);
  bool idle() const { return idle_; }
  // Moves the result to `done` if it exists. Then the worker is idle.
  bool take(Done& done);
  // Waits until the result of a pending stroke exists. For a caller that runs the ticks itself
  // (LiveCarving::tick).
  void wait() const;

 private:
  void signal();
  void run();

  bool idle_ = true;  // for the servo's thread
  // Shared by both threads.
  SmallQueue<Stroke, 2> strokes_;
  SmallQueue<Done, 2> done_;
  std::atomic<int> signals_{0}, answers_{0};
  int request_count_ = 0;  // for the servo's thread
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kibori
