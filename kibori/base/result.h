// SPDX-License-Identifier: MIT
// Errors are values. An error is one sentence for the user: what happened, where, what to do.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include <kibori/base/check.h>

namespace kibori {

// An error. If the text has more than 4000 bytes, an ellipsis replaces its middle.
struct Error {
  Error() = default;
  explicit Error(std::string text);
  std::string message;
};

// Makes a text from outside, such as a name in a file, safe to quote in a message. Replaces control
// characters by spaces. If the text has more than 300 bytes, an ellipsis replaces its middle.
std::string sanitize_message(std::string text);

// A value or an Error. A call of value() for an error, or of error() for a value, is a programming
// error and stops the program.
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
