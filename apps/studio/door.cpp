// SPDX-License-Identifier: MIT
#include "apps/studio/door.h"

#include <cstdio>
#include <random>
#include <utility>

namespace kibori::studio {
namespace {

// Compares in constant time, independent of the position of a difference.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differ = 0;
  for (size_t i = 0; i < a.size(); i++)
    differ |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differ == 0;
}

}  // namespace

std::string random_hex() {
  std::random_device random;
  std::string text;
  for (int i = 0; i < 8; i++) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(random()));
    text += digits;
  }
  return text;
}

bool Door::is_key(std::string_view key) const { return same(key, key_); }

std::string Door::enter(std::string_view token, std::string_view key) {
  if (is_key(key)) return key_;
  if (!token_.empty() && same(token, token_)) {
    used_token_ = std::exchange(token_, {});
    return key_;
  }
  if (!used_token_.empty() && same(token, used_token_)) {
    used_token_.clear();
    token_ = random_hex();
    if (on_new_token) on_new_token(token_);
  }
  return {};
}

Guest::Guest(Door& door, std::function<void()> leave) : door_(door), leave_(std::move(leave)) {
  door_.strangers_.push_back(this);
  if (door_.strangers_.size() <= door_.max_strangers_) return;
  Guest* const first = door_.strangers_.front();
  door_.strangers_.pop_front();
  first->leave_();
}

Guest::~Guest() {
  door_.strangers_.remove(this);
  if (known_) door_.known_--;
}

bool Guest::welcome() {
  if (known_) return true;
  if (door_.known_ >= door_.max_known_) return false;
  door_.strangers_.remove(this);
  door_.known_++;
  return known_ = true;
}

}  // namespace kibori::studio
