// SPDX-License-Identifier: MIT
// The thread that looks for what a stroke severed, beside the servo, which never waits for it.
//
//   servo:   begin(stroke that ended) ──► take_crumbs, on a model beside ──► take(done)
//
// One stroke at a time: until it is answered, the material is only felt.
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
    std::shared_ptr<const NoGo> no_go;  // what holds some of it stays
  };
  struct Done {
    Stroke stroke;         // its `after` and `bounds` are without the crumbs
    bool changed = false;  // there were any
    CrumbResult crumbs;
  };

  CrumbWorker();
  ~CrumbWorker();
  CrumbWorker(const CrumbWorker&) = delete;

  // The servo's thread; none of these waits, locks or allocates.
  // Only where it is idle.
  void begin(Stroke stroke);
  bool idle() const { return idle_; }
  // The answer, once it is there; it is idle then.
  bool take(Done& done);
  // Until the answer is there, if one is to come: for the owner of a servo that has no thread.
  void wait() const;

 private:
  void signal();
  void run();

  bool idle_ = true;  // the servo's
  // Of both.
  SmallQueue<Stroke, 2> strokes_;
  SmallQueue<Done, 2> done_;
  std::atomic<int> signals_{0}, answers_{0};
  int asked_ = 0;  // the servo's
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace kibori
