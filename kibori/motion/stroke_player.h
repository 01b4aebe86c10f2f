// SPDX-License-Identifier: MIT
// Makes strokes on a model. A StrokePlayer converts the motion of a hand, or a record of it, into
// edits, forces and records. Scenes, Python and documents use this class.
//
//   a hand:    begin(settings) ─► move() ... ─► end()        each tick gives a RecordedTick to keep
//   a record:  begin(settings) ─► play(tick) ... ─► finish_record()
//                                    │
//        first or second hand ─► HandTool ─► ToolEdit        cut, deposit, touch
//                                    └─────► ReshapeStroke   brushes, warps, clay, wheel, paint
//
// A replay on an equal model gives the same bytes as the stroke.
//
// The servo thread uses HandTool directly, and runs ReshapeStroke on another thread (DabWorker).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/hand_tool.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

// Returns Ok if a stroke can have these settings. Otherwise, returns an error sentence. Errors: a
// tool, the symmetry or the brush is invalid; a material does not exist; check_modes rejects the
// modes.
Status check_stroke(const StrokeSettings& settings, const NoGo* no_go);

class StrokePlayer {
 public:
  // Places the first hand and its tool at `start`. The model must outlive the player.
  StrokePlayer(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : first_(model, start, spring), reshape_(model), model_(model) {}

  // Adds the second hand, with its tool at `start`. Call it before the setters.
  void add_second(const Pose& start, const SeriesSpring& spring) {
    second_.emplace(model_, start, spring);
  }
  bool has_second() const { return second_.has_value(); }

  // Sets the number of threads. It does not change the result.
  void set_threads(int threads);
  // Sets the protected region, which edits do not cut; null: none. The region must outlive the
  // player or be unset before its end.
  void set_no_go(const NoGo* no_go);
  // Sets the direction of the wood's fibres; null: none. `grain` must outlive the player or be
  // unset before its end.
  void set_grain(const Grain* grain);
  // Call this when the model changed under the tools, or when a tool changed its shape. Then a tool
  // on a spring does not work until it is clear of material.
  void disengage(bool second = false) { hand(second).disengage(); }

  // Starts a stroke at the current poses of the hands. Errors: those of check_stroke.
  Status begin(const StrokeSettings& settings);
  const StrokeSettings& settings() const { return settings_; }

  // Return the poses of a hand's tool and of the hand. They differ only in the model `series`.
  const Pose& tool_pose(bool second = false) const { return hand(second).pose(); }
  const Pose& hand_pose(bool second = false) const { return hand(second).hand(); }

  // Moves a hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to a pose.
  // In each tick, move the first hand before the second. Errors: those of HandTool::move, after
  // which the stroke can continue; those of ReshapeStroke::advance, after which failed() is true.
  Result<ToolTick> move(const Vec3& tip_mm, const Vec3& turn_rad, bool second = false);
  // Makes a tick in which the hand does not move.
  Result<ToolTick> rest(bool second = false) {
    return move(hand_pose(second).tip, Vec3::Zero(), second);
  }
  Result<ToolTick> move_to(const Pose& pose);
  // Returns a record of the second hand's pose. It belongs at the start of a stroke of both hands.
  RecordedTick second_place() const { return {PutTick{tool_pose(true)}, true}; }
  // Returns the record of the last move().
  RecordedTick recorded(bool second = false) const;
  // Ends the stroke: computes a warp at the tool's pose, or returns pending clay. Adds these
  // changes to `last`, the result of the last tick. If the mode has ends_apart(), returns an
  // additional tick to record. Errors: those of move().
  Result<std::optional<RecordedTick>> end(ToolTick& last);
  // Returns true if an error left a part of a tick in the model. Then the caller must restore an
  // earlier state of the model.
  bool failed() const { return failed_; }
  // Returns the volume of pressed clay that has not returned [mm^3]. After end(), this volume has
  // found no room.
  double pending_mm3() const { return reshape_.pending_mm3(); }

  // Returns the volume that the tools of both hands removed or added without a force [mm^3]. It can
  // be above 0 only in the model `energy`, whose force is a mean over a cell of path. So the volume
  // just before a reversal or the end causes no force.
  double without_force_mm3() const;

  // Plays a recorded tick. Errors: those of move(); the tick is of a second hand, but there is
  // none.
  Result<ToolTick> play(const RecordedTick& tick);
  // Call this at the end of the record, also if the record ends in the middle of the stroke.
  Status finish_record();
  // Returns the volume that a tool cut or deposited in the last play(), for each material, with the
  // images. Null if no tool edited.
  const Removed* played() const { return played_; }

 private:
  HandTool& hand(bool second) { return second ? *second_ : first_; }
  const HandTool& hand(bool second) const { return second ? *second_ : first_; }
  // Returns the input of a hand's tick in this stroke. A second hand without settings only moves.
  ToolUse use_of(bool second) const;
  Status reshape(ToolTick& tick, const Pose& before, bool computes = false);
  Status end_reshaping(ToolTick& tick);
  Result<ToolTick> play_move(const MoveTick& tick, bool second);

  HandTool first_;
  std::optional<HandTool> second_;
  ReshapeStroke reshape_;
  TriDexel& model_;
  const NoGo* no_go_ = nullptr;
  StrokeSettings settings_;
  bool reshaping_ = false;  // true if ReshapeStroke::begin was called in this stroke
  bool failed_ = false;
  const Removed* played_ = nullptr;
};

}  // namespace kibori
