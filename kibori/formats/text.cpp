// SPDX-License-Identifier: MIT
#include <kibori/formats/text.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace kibori {
namespace {

constexpr size_t kShownBytes = 40;
// Maximum displacement of a vertex by rounding, as a fraction of the longest side. The distance of
// ordinary models from the origin is less than ten times their size. There, float32 moves them by
// less. With a larger value, a part in map coordinates would lose its shape.
constexpr double kMaxRounding = 1e-6;

}  // namespace

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
    if (word.starts_with('-')) return std::nullopt;
  }
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, value);
  if (rest != end || word.empty()) return std::nullopt;
  // The number is too large or too small for a double. strtod returns infinity or almost 0.
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(word).c_str(), nullptr);
  else if (error != std::errc())
    return std::nullopt;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string in_quotes(std::string_view word) {
  size_t shown = std::min(word.size(), kShownBytes);
  // Do not cut within a UTF-8 character.
  while (shown > 0 && shown < word.size() &&
         (static_cast<unsigned char>(word[shown]) & 0xc0) == 0x80)
    shown--;
  std::string text("'");
  text.append(word.substr(0, shown));
  return text += shown < word.size() ? "...'" : "'";
}

std::string_view without_bom(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  return text;
}

bool is_utf16(std::string_view text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff");
}

std::string_view without_comment(std::string_view line) {
  size_t at = line.find('#');
  while (at != std::string_view::npos && at > 0 && line[at - 1] == '.') at = line.find('#', at + 1);
  return line.substr(0, at);
}

std::string_view take_word(std::string_view& text) {
  size_t begin = 0;
  while (begin < text.size() && is_space(text[begin])) begin++;
  size_t end = begin;
  while (end < text.size() && !is_space(text[end])) end++;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

bool Lines::next(std::string_view& line) {
  if (rest_.empty()) return false;
  const size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  line = rest_.substr(0, end);
  const bool both = rest_.substr(end, 2) == "\r\n";
  rest_.remove_prefix(std::min(end + (both ? 2 : 1), rest_.size()));
  number_++;
  return true;
}

void round_to_float(TriangleMesh& mesh) {
  const double longest = mesh.triangles.empty() ? 0 : mesh.bounds().size().maxCoeff();
  const auto rounded = [](const Vec3& p) { return Vec3(p.cast<float>().cast<double>()); };
  for (const Vec3& p : mesh.vertices)
    if (!((rounded(p) - p).cwiseAbs().maxCoeff() <= kMaxRounding * longest)) return;
  for (Vec3& p : mesh.vertices) p = rounded(p);
}

}  // namespace kibori
