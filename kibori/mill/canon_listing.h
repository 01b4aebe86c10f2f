// SPDX-License-Identifier: MIT
// Reads a canonical listing: the output of LinuxCNC's interpreter (`rs274 -g`). Each line is one
// call:
//
//     17 N0080  STRAIGHT_FEED(1.0000, 2.0000, -0.5000, 0.0000, 0.0000, 0.0000)
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/mill/canon_move.h>
#include <kibori/mill/interpreter.h>

namespace kibori {

// Returns true if a line looks like a line of a listing.
bool is_canon_line(std::string_view line);

class CanonListing {
 public:
  // Executes one line and appends its moves. A line without a call, or with an unknown call, causes
  // a warning. Errors (without file and line): a call has too few numbers; a number is too large; a
  // call is not supported.
  Status run(std::string_view line, int number, std::vector<CanonMove>& out);
  // After this call, moves get the number of the N word of their line, not the number of the line
  // in the listing. If a line has no N word, its moves get the number of the line before.
  void use_line_words() { line_words_ = true; }
  bool ended() const { return ended_; }
  const std::vector<ProgramWarning>& warnings() const { return warnings_; }

 private:
  struct Call;
  bool set_mode(const Call& call);
  bool set_state(const Call& call);
  Result<bool> move(const Call& call);
  Status arc(const Call& call);
  void to(AxisPosition position, bool feed);
  void add(CanonAction action) { out_->push_back({line_, std::move(action)}); }
  double scale() const { return inches_ ? 25.4 : 1; }
  AxisPosition position(const Call& call, size_t first) const;

  std::vector<CanonMove>* out_ = nullptr;  // set during run()
  int line_ = 0;
  bool ended_ = false, inches_ = false, started_ = false, line_words_ = false;
  ArcPlane plane_ = ArcPlane::xy;
  Vec3 first_offset_ = Vec3::Zero(), offset_ = Vec3::Zero(), shift_ = Vec3::Zero();
  FeedRate feed_;
  double rpm_ = 0;
  int direction_ = 0, selected_ = 0;
  Coolant coolant_;
  std::vector<ProgramWarning> warnings_;
  std::set<std::string> warned_;
};

}  // namespace kibori
