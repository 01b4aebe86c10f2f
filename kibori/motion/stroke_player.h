// SPDX-License-Identifier: MIT
// Plays strokes on a model: the one way in which a hand's motion, or its record, becomes edits,
// forces and records. Scenes, Python, documents and the studio all play strokes through it.
//
//   a hand:    begin(settings) ─► move() ... ─► end()        each tick gives a StrokeTick to keep
//   a record:  begin(settings) ─► play(tick) ... ─► finish_record()
//                                    │
//        first or second hand ─► HandTool ─► ToolEdit        cut, deposit, touch
//                                    └─────► ReshapeStroke   brushes, warps, clay, wheel, paint
//
// Playing the record of a stroke on the same model leaves the same bytes as the stroke did.
//
// The servo thread uses HandTool itself: it computes reshaping modes on another thread (DabWorker).
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

// Ok, or one sentence that says why no stroke can have these settings: a tool, symmetry or brush
// that is refused, a second hand next to a mode that reshapes, a second hand that reshapes, a
// material that does not exist, a reshaping mode next to a protected region.
Status check_stroke(const StrokeSettings& settings, const NoGo* no_go);

class StrokePlayer {
 public:
  // The first hand and its tool are at `start`. The model must outlive the player.
  StrokePlayer(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : first_(model, start, spring), reshape_(model), model_(model) {}

  // Adds the second hand, with its tool at `start`. Call it before the setters.
  void add_second(const Pose& start, const SeriesSpring& spring) {
    second_.emplace(model_, start, spring);
  }
  bool has_second() const { return second_.has_value(); }

  // Results do not depend on the number of threads.
  void set_threads(int threads);
  // What is not cut; null: nothing. It must outlive the player, or be taken away.
  void set_no_go(const NoGo* no_go);
  // The direction of the wood's fibres; null: none. It must outlive the player, or be taken away.
  void set_grain(const Grain* grain);
  // The model changed under the tools, or a tool its shape: a sprung tool waits until it is clear.
  void disengage(bool second = false) { hand(second).disengage(); }

  // Starts a stroke where the hands are. Errors: those of check_stroke.
  Status begin(const StrokeSettings& settings);
  const StrokeSettings& settings() const { return settings_; }

  // Where a hand's tool is, and where the hand is (model `series`; else the same).
  const Pose& tool_pose(bool second = false) const { return hand(second).pose(); }
  const Pose& hand_pose(bool second = false) const { return hand(second).hand(); }

  // Moves a hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to a pose;
  // the first hand comes first in each tick. Errors: those of HandTool::move, after which the
  // stroke can go on; those of ReshapeStroke::advance, after which failed() is true.
  Result<ToolTick> move(const Vec3& tip_mm, const Vec3& turn_rad, bool second = false);
  // A tick in which the hand stays where it is.
  Result<ToolTick> rest(bool second = false) {
    return move(hand_pose(second).tip, Vec3::Zero(), second);
  }
  Result<ToolTick> move_to(const Pose& pose);
  // The record of the second hand's place, for the start of a stroke of both hands.
  StrokeTick second_place() const { return {PutTick{tool_pose(true)}, true}; }
  // The record of the last move().
  StrokeTick recorded(bool second = false) const;
  // Ends the stroke: a warp is computed where the tool is, pending clay comes back. Adds to `last`,
  // which is the last tick's result, what that changed. Returns the tick to record, if the mode has
  // one (ends_apart). Errors: as of move().
  Result<std::optional<StrokeTick>> end(ToolTick& last);
  // An error has left part of a tick in the model: only going back helps.
  bool failed() const { return failed_; }
  // Clay that found no room so far [mm^3].
  double owed_mm3() const { return reshape_.owed_mm3(); }

  // Plays a recorded tick. Errors: as of move(); a tick of a second hand that the settings lack.
  Result<ToolTick> play(const StrokeTick& tick);
  // The record is over, perhaps in the middle of the stroke.
  Status finish_record();
  // What the last play() cut or put down, by material, images included; null if it did not.
  const Removed* played() const { return played_; }

 private:
  HandTool& hand(bool second) { return second ? *second_ : first_; }
  const HandTool& hand(bool second) const { return second ? *second_ : first_; }
  // What a hand does in a tick of this stroke; a second hand that has no part in it only moves.
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
