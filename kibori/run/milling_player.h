// SPDX-License-Identifier: MIT
// Plays a MillTape back. A player has a separate model, and brings this model to any moment of the
// run. One thread may use it at a time.
//
// To go back, the player restores the nearest earlier snapshot of the tape, and cuts the moves
// after it. After whole moves, the model equals that of the run, byte for byte. Within a move, the
// model is only for display.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/batch.h>
#include <kibori/run/milling_tape.h>
#include <kibori/solid/tool.h>

namespace kibori {

// A moment of a run: after the first `moves` moves and a share of the next move.
struct MillMoment {
  size_t moves = 0;
  double share = 0;  // 0..1
  bool operator==(const MillMoment&) const = default;
};

class MillPlayer {
 public:
  // `tape` must outlive the player, and must have its first snapshot.
  MillPlayer(const MillTape& tape, int threads);

  const TriDexel& model() const { return model_; }
  const MillMoment& at() const { return at_; }
  // Returns the moment at a time of playback [s]. It is at most the end of the published moves.
  MillMoment moment(double seconds) const;
  // Returns the current time of playback [s].
  double seconds() const;
  // Returns the move of the current moment: the one that is cut in part, or the last whole one.
  // nullopt: none.
  const std::optional<MillTapeMove>& move() const { return move_; }
  // Returns the index of the tool of move(), or of the tape's first move. -1: there is none.
  int tool() const;
  // Returns the pose of the tool in the model, or nullopt if there is no move.
  std::optional<Pose> pose() const;
  // Goes towards a moment. One call cuts at most one batch of moves. Returns true if the moment is
  // reached. Errors: those of substeps_of.
  Result<bool> go(const MillMoment& to);

 private:
  // Number of moves in a batch.
  static constexpr size_t kBatch = 256;
  // Number of sweeps that are cut together. A sweep takes some kB.
  static constexpr size_t kMaxSweeps = 1024;

  struct Sweeps {
    std::deque<SweptTool> tools;  // `cuts` points to them
    std::vector<BatchCut> cuts;
  };
  void restore(const MillTape::Key& key);
  // Adds the sweeps of the part of a move from the share `begin` to the share `end`.
  Status add(Sweeps& to, const MillTapeMove& move, double begin, double end);
  void cut(Sweeps& sweeps);
  Status cut_whole(size_t count);
  Status cut_share(double share);

  const MillTape& tape_;
  const int threads_;
  std::vector<Tool> tools_;  // cutters of the tools on the tape
  TriDexel model_;
  MillMoment at_;
  std::optional<MillTapeMove> move_;
  std::optional<Snapshot>
      whole_;  // after at_.moves moves, while the model holds a share of the next
};

}  // namespace kibori
