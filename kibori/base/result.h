// SPDX-License-Identifier: MIT
// Errors as values. An error is one sentence for the user: what happened, where, what to do.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include <kibori/base/check.h>

namespace kibori {

// A text of more than 4000 bytes loses its middle.
struct Error {
  Error() = default;
  explicit Error(std::string text);
  std::string message;
};

// For what a message quotes, such as a name from a file: replaces control characters, and the
// middle of more than 300 bytes.
std::string sanitize_message(std::string text);

// A value or an Error. Access to the one that is not set is a programming error and stops the
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
