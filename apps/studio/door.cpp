// SPDX-License-Identifier: MIT
#include "apps/studio/door.h"

#include <utility>

namespace kibori::studio {
bool Door::is_key(std::string_view key) const { return same_secret(key, key_); }

std::string Door::enter(std::string_view token, std::string_view key) {
  if (is_key(key)) return key_;
  if (!token_.empty() && same_secret(token, token_)) {
    used_token_ = std::exchange(token_, {});
    return key_;
  }
  if (!used_token_.empty() && same_secret(token, used_token_)) {
    used_token_.clear();
    token_ = random_hex();
    if (on_new_token) on_new_token(token_);
  }
  return {};
}

Guest::Guest(GuestList& list, std::function<void()> leave) : list_(list), leave_(std::move(leave)) {
  list_.strangers_.push_back(this);
  if (list_.strangers_.size() <= list_.max_strangers_) return;
  Guest* const first = list_.strangers_.front();
  list_.strangers_.pop_front();
  first->leave_();
}

Guest::~Guest() {
  list_.strangers_.remove(this);
  if (known_) list_.known_--;
}

bool Guest::welcome() {
  if (known_) return true;
  if (list_.known_ >= list_.max_known_) return false;
  list_.strangers_.remove(this);
  list_.known_++;
  return known_ = true;
}

}  // namespace kibori::studio
