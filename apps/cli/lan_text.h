// SPDX-License-Identifier: MIT
// Makes the QR code of the studio's address, as text for the terminal.
#pragma once

#include <string>

namespace kibori {

// Returns a QR code made of block characters. Each line of text shows two rows of the code. If
// `colors` is true, escape sequences make the code black on white. Otherwise, the terminal must
// have a dark background. Returns an empty text if `text` is too long.
std::string qr_text(const std::string& text, bool colors);

}  // namespace kibori
