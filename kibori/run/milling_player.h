// SPDX-License-Identifier: MIT
// Plays a MillTape back: it has a separate model, and brings it to any moment of the run. One
// thread owns it.
//
// To go back, it restores the nearest earlier snapshot of the tape and cuts the moves after it. The
// model after whole moves equals that of the run, to the byte. Within a move, the model is only for
// display.
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

// A moment of a run: the first `moves` moves, and a share of the next one.
struct MillMoment {
  size_t moves = 0;
  double share = 0;  // 0..1
  bool operator==(const MillMoment&) const = default;
};

class MillPlayer {
 public:
  // `tape` must outlive the player, and hold its first snapshot.
  MillPlayer(const MillTape& tape, int threads);

  const TriDexel& model() const { return model_; }
  const MillMoment& at() const { return at_; }
  // The moment at a time [s], at most the end of what is published.
  MillMoment moment(double seconds) const;
  // Time of playback [s].
  double seconds() const;
  // The move that is cut, or the last one before; nullopt: none.
  const std::optional<MillTapeMove>& move() const { return move_; }
  // Index of the tool in the tape: that of move(), or of the first move. -1: none.
  int tool() const;
  // The tool's pose in the model; nullopt: there is no move.
  std::optional<Pose> pose() const;
  // Goes towards a moment and cuts at most a batch of moves. Returns true if it is there. Errors:
  // see substeps_of.
  Result<bool> go(const MillMoment& to);

 private:
  // Moves of one batch.
  static constexpr size_t kBatch = 256;
  // Sweeps that are cut together. A sweep takes some kB.
  static constexpr size_t kMaxSweeps = 1024;

  struct Sweeps {
    std::deque<SweptTool> tools;  // the cuts point to them
    std::vector<BatchCut> cuts;
  };
  void restore(const MillTape::Key& key);
  // Adds the sweeps of a part of a move.
  Status add(Sweeps& to, const MillTapeMove& move, double begin, double end);
  void cut(Sweeps& sweeps);
  Status cut_whole(size_t count);
  Status cut_share(double share);

  const MillTape& tape_;
  const int threads_;
  std::vector<Tool> tools_;  // cutters of the tape's tools
  TriDexel model_;
  MillMoment at_;
  std::optional<MillTapeMove> move_;
  std::optional<Snapshot>
      whole_;  // after at_.moves moves, while the model holds a share of the next
};

}  // namespace kibori
