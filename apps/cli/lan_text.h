// SPDX-License-Identifier: MIT
// The QR code of the studio's address, as text for the terminal.
#pragma once

#include <string>

namespace kibori {

// Returns a QR code that consists of block characters. Each line of text shows two rows of modules.
// With `colors`, escape sequences make it black on white. Without, the terminal must have a dark
// background. Empty if the text is too long.
std::string qr_text(const std::string& text, bool colors);

}  // namespace kibori
