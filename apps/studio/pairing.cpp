// SPDX-License-Identifier: MIT
#include "apps/studio/pairing.h"

#include <random>

#include "apps/studio/secret.h"

namespace kibori::studio {
namespace {

// Without I, O, 0 and 1, which look alike.
constexpr std::string_view kCodeLetters = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789";
static_assert(kCodeLetters.size() == 32);  // a power of two: all letters are equally probable
constexpr size_t kCodeLength = 6;

std::string random_code() {
  std::random_device random;
  std::string code;
  for (size_t i = 0; i < kCodeLength; i++) code += kCodeLetters[random() % kCodeLetters.size()];
  return code;
}

std::string as_code(std::string_view typed) {
  std::string code;
  for (const char c : typed)
    if (c != ' ' && c != '-') code += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return code;
}

}  // namespace

void Pairing::offer(Clock::time_point now) {
  if (valid(now) || now < free_at_) return;
  code_ = random_code();
  ends_ = now + kCodeTime;
  wrong_ = 0;
  if (on_code) on_code(code_);
}

Pairing::Answer Pairing::enter(std::string_view code, Clock::time_point now) {
  if (now < free_at_)
    return {Outcome::wait, {}, std::chrono::ceil<std::chrono::seconds>(free_at_ - now)};
  if (!valid(now)) {
    offer(now);
    return {Outcome::expired, {}};
  }
  if (same_secret(as_code(code), code_)) {
    code_.clear();
    return {Outcome::paired, sessions_.emplace_back(random_hex())};
  }
  if (++wrong_ < kWrongCodes) return {Outcome::wrong, {}};
  code_.clear();
  free_at_ = now + kWait;
  return {Outcome::wait, {}, kWait};
}

bool Pairing::is_session(std::string_view session) const {
  bool found = false;
  for (const std::string& one : sessions_) found |= same_secret(session, one);
  return found;
}

}  // namespace kibori::studio
