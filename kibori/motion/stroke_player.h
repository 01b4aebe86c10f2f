// SPDX-License-Identifier: MIT
// Makes strokes on a model: converts a hand's motion, or its record, into edits, forces and
// records. Scenes, Python and documents use it.
//
//   a hand:    begin(settings) ─► move() ... ─► end()        each tick gives a RecordedTick to keep
//   a record:  begin(settings) ─► play(tick) ... ─► finish_record()
//                                    │
//        first or second hand ─► HandTool ─► ToolEdit        cut, deposit, touch
//                                    └─────► ReshapeStroke   brushes, warps, clay, wheel, paint
//
// On the same model, a replay of the record gives the same bytes as the stroke did.
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

// Returns Ok, or one sentence that says why no stroke can have these settings. Rejects: an invalid
// tool, symmetry or brush; a material that does not exist; a second hand that reshapes; an editing
// second hand with a mode that reshapes; a reshaping mode with a protected region.
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

  // Number of threads. Results do not depend on it.
  void set_threads(int threads);
  // Sets the protected region, which is not cut; null: none. The region must outlive the player or
  // be unset first.
  void set_no_go(const NoGo* no_go);
  // Sets the direction of the wood's fibres; null: none. It must outlive the player or be unset
  // first.
  void set_grain(const Grain* grain);
  // Call this when the model changed under the tools, or when a tool changed its shape. A tool on a
  // spring then waits until it is clear.
  void disengage(bool second = false) { hand(second).disengage(); }

  // Starts a stroke at the current poses of the hands. Errors: those of check_stroke.
  Status begin(const StrokeSettings& settings);
  const StrokeSettings& settings() const { return settings_; }

  // Pose of a hand's tool, and pose of the hand. They are equal except in model `series`.
  const Pose& tool_pose(bool second = false) const { return hand(second).pose(); }
  const Pose& hand_pose(bool second = false) const { return hand(second).hand(); }

  // Moves a hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to a pose.
  // In each tick, move the first hand first. Errors: those of HandTool::move, after which the
  // stroke can continue; those of ReshapeStroke::advance, after which failed() is true.
  Result<ToolTick> move(const Vec3& tip_mm, const Vec3& turn_rad, bool second = false);
  // A tick in which the hand does not move.
  Result<ToolTick> rest(bool second = false) {
    return move(hand_pose(second).tip, Vec3::Zero(), second);
  }
  Result<ToolTick> move_to(const Pose& pose);
  // Record of the second hand's pose, for the start of a stroke of both hands.
  RecordedTick second_place() const { return {PutTick{tool_pose(true)}, true}; }
  // Record of the last move().
  RecordedTick recorded(bool second = false) const;
  // Ends the stroke. Computes a warp at the tool's pose, or returns pending clay. Adds these
  // changes to `last`, the result of the last tick. Returns the tick to record, if the mode has one
  // (ends_apart). Errors: those of move().
  Result<std::optional<RecordedTick>> end(ToolTick& last);
  // True if an error left part of a tick in the model. The caller must restore an earlier state.
  bool failed() const { return failed_; }
  // Pressed clay that has not returned [mm^3]. After end(), it is that which found no room.
  double pending_mm3() const { return reshape_.pending_mm3(); }

  // Volume that the tools of both hands removed or added without a force [mm^3]. Above 0 only in
  // model `energy`: its force is a mean over a cell of path, so volume that was removed just before
  // a reversal or the end causes none.
  double without_force_mm3() const;

  // Plays a recorded tick. Errors: those of move(); a tick of a second hand that the settings lack.
  Result<ToolTick> play(const RecordedTick& tick);
  // Call this when the record ends, possibly in the middle of the stroke.
  Status finish_record();
  // Volume that the last play() cut or deposited, by material, images included. Null if none.
  const Removed* played() const { return played_; }

 private:
  HandTool& hand(bool second) { return second ? *second_ : first_; }
  const HandTool& hand(bool second) const { return second ? *second_ : first_; }
  // Input of a hand's tick in this stroke. A second hand without settings only moves.
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
  bool reshaping_ = false;  // ReshapeStroke::begin was called in this stroke
  bool failed_ = false;
  const Removed* played_ = nullptr;
};

}  // namespace kibori
