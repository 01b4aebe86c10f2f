// SPDX-License-Identifier: MIT
// Errors as values: what happened, where, what to do, in one sentence a user can read.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include <kibori/base/check.h>

namespace kibori {

struct Error {
  std::string message;
};

// What a file holds may stand in a message: control characters would tear it apart.
inline std::string sanitize_message(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  return text;
}

// A value or an Error. Reading the one that is not there is a programming mistake and stops the
// program.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  T& value() & {
    KIBORI_CHECK(ok());
    return std::get<T>(state_);
  }
  const T& value() const& {
    KIBORI_CHECK(ok());
    return std::get<T>(state_);
  }
  T&& value() && {
    KIBORI_CHECK(ok());
    return std::get<T>(std::move(state_));
  }
  const std::string& error() const {
    KIBORI_CHECK(!ok());
    return std::get<Error>(state_).message;
  }

 private:
  std::variant<T, Error> state_;
};

struct Ok {};
using Status = Result<Ok>;

}  // namespace kibori
