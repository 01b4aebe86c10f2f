// SPDX-License-Identifier: MIT
// The queue of events from the servo thread to the document writer. It uses no lock. If the reader
// is more than kMaxEvents late, all later events are lost, and lost() returns true.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include <kibori/base/handover.h>
#include <kibori/body/bodies.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

class StrokeLog {
 public:
  struct Begin {
    Tool tool;
    Mode mode = Mode::cut;
    uint8_t material = 0;
    StrokeForce force;
    double rate_hz = 1000;
    std::shared_ptr<const std::vector<Material>> materials;
    Pose start;
    Symmetry symmetry;
    Brush brush = {};
    Crumbs crumbs = Crumbs::stay;
    std::optional<StrokeHand> second = std::nullopt;
    Lattice lattice = {};  // lattice before the stroke
  };
  struct End {
    Snapshot state;     // state after the stroke, without the severed pieces
    Snapshot before;    // state before the stroke; the reader frees it, because this takes time
    LatticeBox bounds;  // bounds of the material after the stroke
    double removed_mm3 = 0;
    CrumbResult crumbs;
  };
  // begin, tick, end: of a stroke. cancel: the current stroke is discarded. fence: marks a request,
  // for example an undo; everything before the fence was done before the request. moved: the model
  // now belongs to another step.
  enum class Kind : uint8_t { begin, tick, end, cancel, fence, moved };
  struct Event {
    Kind kind = Kind::tick;
    RecordedTick tick = {};
    // The force model's result, and the wrench that the device received.
    Wrench computed = {}, given = {};
  };

  // Functions for the reader.
  bool pop(Event& event) { return events_.pop(event); }
  bool pop(Begin& begin) { return begins_.pop(begin); }
  bool pop(End& end) { return ends_.pop(end); }
  // For any thread.
  bool lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  friend class ServoContext;  // the only writer
  void begin(Begin begin) {
    if (lost()) return;
    if (!begins_.push(std::move(begin))) return lose();
    put({Kind::begin});
  }
  void tick(const RecordedTick& tick, const Wrench& computed, const Wrench& given) {
    put({Kind::tick, tick, computed, given});
  }
  void end(End end) {
    if (lost()) return;
    if (!ends_.push(std::move(end))) return lose();
    put({Kind::end});
  }
  void cancel() { put({Kind::cancel}); }
  void fence() { put({Kind::fence}); }
  void moved() { put({Kind::moved}); }

  static constexpr size_t kMaxEvents = 32768;  // 8 s at 4 kHz
  void put(const Event& event) {
    if (!lost() && !events_.push(event)) lose();
  }
  void lose() { lost_.store(true, std::memory_order_relaxed); }
  SmallQueue<Event, kMaxEvents> events_;
  SmallQueue<Begin, 64> begins_;
  SmallQueue<End, 64> ends_;
  std::atomic<bool> lost_{false};
};

}  // namespace kibori
