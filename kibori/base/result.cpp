// SPDX-License-Identifier: MIT
#include <kibori/base/result.h>

#include <cstddef>

namespace kibori {
namespace {

constexpr size_t kMaxQuoted = 300, kMaxMessage = 4000;

// True if a byte continues a UTF-8 character.
bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

// Replaces the middle of a long text. The beginning says what is meant, the end what to do.
std::string shortened(std::string text, size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  size_t head = max_bytes * 2 / 3, tail = text.size() - max_bytes / 3;
  while (head > 0 && continues(text[head])) head--;
  while (tail < text.size() && continues(text[tail])) tail++;
  return text.replace(head, tail - head, " … ");
}

}  // namespace

std::string sanitize_message(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  return shortened(std::move(text), kMaxQuoted);
}

Error::Error(std::string text) : message(shortened(std::move(text), kMaxMessage)) {}

}  // namespace kibori
