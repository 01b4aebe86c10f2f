// SPDX-License-Identifier: MIT
#include <kibori/mill/gcode_block.h>

#include <cmath>
#include <string_view>

namespace kibori {
namespace {

// G-codes have at most one decimal, and are stored as ten times their number. This is the tolerance
// for rounding a number to a code, as in LinuxCNC.
constexpr double kCodeTolerance = 1e-3;

std::optional<GGroup> group_of_g(int code10) {
  switch (code10) {
    case 40:
    case 280:
    case 300:
    case 920:
    case 921:
    case 922:
    case 923:
      return GGroup::non_modal;
    case 530:
      return GGroup::machine;
    case 0:
    case 10:
    case 20:
    case 30:
    case 730:
    case 800:
    case 810:
    case 820:
    case 830:
    case 850:
    case 890:
      return GGroup::motion;
    case 170:
    case 180:
    case 190:
      return GGroup::plane;
    case 900:
    case 910:
      return GGroup::distance;
    case 901:
    case 911:
      return GGroup::arc_distance;
    case 930:
    case 940:
    case 950:
      return GGroup::feed_mode;
    case 200:
    case 210:
      return GGroup::units;
    case 400:
      return GGroup::cutter;
    case 430:
    case 490:
      return GGroup::length;
    case 980:
    case 990:
      return GGroup::retract;
    case 540:
    case 550:
    case 560:
    case 570:
    case 580:
    case 590:
    case 591:
    case 592:
    case 593:
      return GGroup::work_offset;
    case 610:
    case 611:
    case 640:
      return GGroup::path;
    default:
      return std::nullopt;
  }
}

// The meaning of a known G-code that is not supported; empty if the code is unknown.
std::string_view meaning_of_g(int code10) {
  switch (code10) {
    case 50:
    case 51:
    case 52:
    case 53:
      return "a spline";
    case 70:
    case 80:
      return "lathe diameter mode";
    case 100:
      return "setting of stored data";
    case 171:
    case 181:
    case 191:
      return "a plane of secondary axes";
    case 281:
    case 301:
      return "storing of a position";
    case 330:
    case 331:
      return "threading and rigid tapping";
    case 382:
    case 383:
    case 384:
    case 385:
      return "probing";
    case 410:
    case 411:
    case 420:
    case 421:
      return "cutter radius compensation";
    case 431:
    case 432:
      return "a tool length given by the program";
    case 520:
      return "a local offset";
    case 700:
    case 710:
    case 711:
    case 712:
    case 720:
    case 721:
    case 722:
      return "a lathe cycle";
    case 740:
    case 840:
      return "tapping";
    case 760:
      return "a threading cycle";
    case 860:
    case 870:
    case 880:
      return "a boring cycle that stops the spindle";
    case 960:
    case 970:
      return "constant surface speed";
    default:
      return {};
  }
}

std::optional<int> code_of(double value) {
  const double code = std::round(10 * value);
  if (value < 0 || code > 9999 || std::abs(10 * value - code) > kCodeTolerance) return std::nullopt;
  return static_cast<int>(code);
}

Status add_g(GcodeBlock& block, const GcodeWord& word) {
  const std::optional<int> code = code_of(word.value);
  const std::string name = word_text('G', word.value);
  if (!code) return Error{name + " is not a G-code; codes have at most one decimal"};
  const std::optional<GGroup> group = group_of_g(*code);
  if (!group) {
    const std::string_view meaning = meaning_of_g(*code);
    if (meaning.empty()) return Error{name + " is an unknown G-code; remove it"};
    return Error{name + " (" + std::string(meaning) + ") needs LinuxCNC's interpreter; " +
                 need_rs274()};
  }
  int& place = block.g[static_cast<size_t>(*group)];
  if (place != kNoCode && place != *code)
    return Error{code_text('G', place) + " and " + name +
                 " cannot be on one line; write them on two lines"};
  place = *code;
  return Ok{};
}

Status put(GcodeBlock& block, MGroup group, int code) {
  int& place = block.m[static_cast<size_t>(group)];
  if (place != kNoCode && place != code)
    return Error{code_text('M', place) + " and " + code_text('M', code) +
                 " cannot be on one line; write them on two lines"};
  place = code;
  return Ok{};
}

Status add_m(GcodeBlock& block, const GcodeWord& word) {
  const std::string name = word_text('M', word.value);
  const double number = std::round(word.value);
  if (word.value < 0 || number > 9999 || std::abs(word.value - number) > kCodeTolerance)
    return Error{name + " is not an M-code; codes are whole numbers"};
  const int code = static_cast<int>(number);
  switch (code) {
    case 0:
    case 1:
    case 2:
    case 30:
    case 60:
      return put(block, MGroup::stop, 10 * code);
    case 6:
    case 61:
      return put(block, MGroup::tool, 10 * code);
    case 3:
    case 4:
    case 5:
      return put(block, MGroup::spindle, 10 * code);
    case 7:
    case 8:
    case 9:
      block.coolant.push_back(10 * code);
      return Ok{};
    // These codes switch the operator's speed overrides, which do not change the path.
    case 48:
    case 49:
    case 50:
    case 51:
    case 52:
    case 53:
      return Ok{};
    case 70:
    case 71:
    case 72:
    case 73:
      return Error{name + " (stored modal states) needs LinuxCNC's interpreter; " + need_rs274()};
    case 97:
    case 98:
    case 99:
      return Error{name +
                   " (subprograms) needs a program without them; let the post-processor "
                   "write every move"};
    default:
      break;
  }
  for (const int known : block.user)
    if (known == code) return Ok{};
  block.user.push_back(code);
  return Ok{};
}

Status add_value(GcodeBlock& block, const GcodeWord& word) {
  switch (word.letter) {
    case 'U':
    case 'V':
    case 'W':
      return Error{word_text(word.letter, word.value) +
                   " moves a secondary axis, which is not supported; use X, Y and Z"};
    case 'E':
      return Error{word_text('E', word.value) + " is an extruder, and this is a milling program"};
    default:
      break;
  }
  std::optional<double>& place = block.values[static_cast<size_t>(word.letter - 'A')];
  if (place) return Error{std::string(1, word.letter) + " is twice on the line; remove one"};
  place = word.value;
  return Ok{};
}

}  // namespace

std::string code_text(char letter, int code10) {
  return word_text(letter, static_cast<double>(code10) / 10);
}

bool GcodeBlock::has_axis() const {
  for (const char letter : {'X', 'Y', 'Z', 'A', 'B', 'C'})
    if (has(letter)) return true;
  return false;
}

Result<GcodeBlock> make_block(const GcodeLine& line) {
  GcodeBlock block;
  block.g.fill(kNoCode);
  block.m.fill(kNoCode);
  for (const GcodeWord& word : line.words) {
    Status ok = Ok{};
    switch (word.letter) {
      case 'G':
        ok = add_g(block, word);
        break;
      case 'M':
        ok = add_m(block, word);
        break;
      case 'N':
      case 'O':
        break;
      default:
        ok = add_value(block, word);
    }
    if (!ok) return Error{ok.error()};
  }
  return block;
}

}  // namespace kibori
