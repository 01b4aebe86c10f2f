// SPDX-License-Identifier: MIT
#include <kibori/mill/refeed.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <zlib.h>

#include <kibori/base/file.h>
#include <kibori/mill/canon_listing.h>
#include <kibori/mill/gcode_parser.h>
#include <kibori/mill/program_lines.h>

namespace kibori {
namespace {

// Significant digits of a changed feed rate.
constexpr int kDigits = 5;

bool is_number_part(char c) { return ('0' <= c && c <= '9') || c == '.' || c == '-' || c == '+'; }
bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }

// Where the number of the F word is, and where the code of a line ends.
struct Places {
  size_t number = std::string_view::npos, number_end = 0, code_end = 0;
};

Places places_in(std::string_view text) {
  Places places;
  for (size_t i = 0; i < text.size() && text[i] != ';'; i++) {
    if (text[i] == '(') {
      i = text.find(')', i);
      if (i == std::string_view::npos) break;
      continue;
    }
    if (is_space(text[i])) continue;
    places.code_end = i + 1;
    if (text[i] != 'F' && text[i] != 'f') continue;
    places.number = i + 1;
    // Blanks have no meaning, even within a number.
    for (size_t k = i + 1; k < text.size() && (is_number_part(text[k]) || is_space(text[k])); k++)
      if (!is_space(text[k])) places.number_end = k + 1;
  }
  return places;
}

std::string number_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

// Rounds down to kDigits significant digits.
double rounded_down(double value) {
  if (!(value > 0)) return value;
  const double step = std::pow(10.0, std::floor(std::log10(value)) - (kDigits - 1));
  return std::floor(value / step * (1 + 1e-12)) * step;
}

}  // namespace

Status set_feed_limit(FeedLimits& limits, const std::string& text) {
  const size_t equals = text.find('=');
  const std::string key = text.substr(0, equals);
  char* end = nullptr;
  const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
  const double value = std::strtod(number.c_str(), &end);
  if (number.empty() || *end != 0 || !(value > 0) || !std::isfinite(value))
    return Error{"--feed-for '" + sanitize_message(text) +
                 "' must be a name and a positive number, as in force=50"};
  if (key == "force")
    limits.force_n = value;
  else if (key == "power")
    limits.power_w = value;
  else if (key == "min")
    limits.min_mm_min = value;
  else if (key == "max")
    limits.max_mm_min = value;
  else
    return Error{"--feed-for has no '" + sanitize_message(key) +
                 "'; it has force (N), power (W), min and max (mm/min)"};
  return Ok{};
}

Result<std::string> FeedRewriter::rewrite(std::string_view text, int number, double factor) {
  std::string line(text);
  if (interpreter_.ended()) return line;
  const Result<GcodeLine> words = parse_gcode(text);
  if (!words) return Error{words.error()};
  std::vector<CanonMove> moves;
  if (const Status ok = interpreter_.run(words.value(), number, moves); !ok)
    return Error{ok.error()};
  const FeedRate* feed = nullptr;
  for (const CanonMove& move : moves) {
    if (const auto* straight = std::get_if<FeedMove>(&move.action)) feed = &straight->feed;
    if (const auto* arc = std::get_if<ArcMove>(&move.action)) feed = &arc->feed;
  }
  const GcodeWord* const word = words.value().find('F');
  for (const GcodeWord& one : words.value().words)
    if (one.letter == 'G' &&
        (one.value == 20 || one.value == 21 || (93 <= one.value && one.value <= 95)))
      modal_.clear();
  if (!feed || !(feed->value > 0)) {
    if (word) modal_ = number_text(word->value);
    return line;
  }
  const bool by_length = feed->mode != FeedMode::inverse_time && interpreter_.inches();
  const double programmed = feed->value / (by_length ? 25.4 : 1);
  const std::string wanted =
      number_text(factor == 1 ? programmed : rounded_down(factor * programmed));
  const Places places = places_in(text);
  if (word) {
    modal_ = wanted;
    if (number_text(word->value) != wanted)
      line.replace(places.number, places.number_end - places.number, wanted);
  } else if (modal_ != wanted) {
    // While no rate was changed, the line needs no F word.
    const bool as_before = modal_.empty() && factor == 1 && !changed_;
    if (!as_before) line.insert(places.code_end, " F" + wanted);
    modal_ = wanted;
  }
  changed_ |= factor != 1;
  return line;
}

Status write_refed(const std::filesystem::path& program, const std::filesystem::path& to,
                   const InterpreterOptions& controller,
                   const std::function<double(int line)>& factor) {
  const std::string name = program.string();
  const gzFile file = gzopen(program.c_str(), "rb");
  if (!file) return Error{name + ": can't be opened; check its permissions"};
  Lines lines(file);
  FeedRewriter rewriter(controller);
  NewFile out(to);
  while (true) {
    const auto line = lines.next();
    if (!line) return Error{name + ": " + line.error()};
    if (!line.value()) break;
    const std::string place = name + ":" + std::to_string(lines.number()) + ": ";
    if (is_canon_line(*line.value()))
      return Error{place +
                   "is a canonical listing, and --feed-for needs the G-code it was made of"};
    const Result<std::string> text =
        rewriter.rewrite(*line.value(), lines.number(), factor(lines.number()));
    if (!text && text.error().ends_with(need_rs274()))
      return Error{place +
                   "needs LinuxCNC's interpreter, and --feed-for changes plain G-code only; "
                   "let the post-processor write every move"};
    if (!text) return Error{place + text.error()};
    out.write(text.value() + (lines.ended_with_newline() ? "\n" : ""));
  }
  return out.commit();
}

}  // namespace kibori
