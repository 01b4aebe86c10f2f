// SPDX-License-Identifier: MIT
#include "apps/cli/lan_text.h"

#include <memory>

#include <qrencode.h>

namespace kibori {
namespace {

constexpr int kQuietZone = 4;  // light modules around the code, which readers need

}  // namespace

std::string qr_text(const std::string& text, bool colors) {
  const std::unique_ptr<QRcode, void (*)(QRcode*)> code(
      QRcode_encodeString(text.c_str(), 0, QR_ECLEVEL_L, QR_MODE_8, 1), QRcode_free);
  if (!code) return {};
  const int width = code->width;
  const auto dark = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < width && (code->data[y * width + x] & 1) != 0;
  };
  std::string lines;
  for (int y = -kQuietZone; y < width + kQuietZone; y += 2) {
    lines += colors ? "  \x1b[30;107m" : "  ";
    for (int x = -kQuietZone; x < width + kQuietZone; x++) {
      // With `colors`, a block character is a dark module on white. Without, it is a light module
      // on a dark terminal.
      const bool upper = dark(x, y) == colors, lower = dark(x, y + 1) == colors;
      lines += upper && lower ? "\u2588" : upper ? "\u2580" : lower ? "\u2584" : " ";
    }
    lines += colors ? "\x1b[0m\n" : "\n";
  }
  return lines;
}

}  // namespace kibori
