// SPDX-License-Identifier: MIT
// Who may come in. The token of the address that is printed is exchanged, once, for a key, which is
// shown from then on. Internal to apps/studio.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <string>
#include <string_view>

namespace kibori::studio {

// 256 random bits.
std::string random_hex();

class Guest;

class Door {
 public:
  // At most `known` connections that have shown the key, and `strangers` that have not.
  Door(size_t known, size_t strangers)
      : max_known_(known), max_strangers_(strangers), token_(random_hex()), key_(random_hex()) {}

  const std::string& token() const { return token_; }
  // The key for the token, which is then used, or for the key itself; empty where both are wrong. A
  // token that was used gets nothing, but `on_new_token` hears the next one: whoever has it could
  // read the terminal.
  std::string enter(std::string_view token, std::string_view key);
  bool is_key(std::string_view key) const;

  std::function<void(const std::string& token)> on_new_token;

 private:
  friend Guest;

  const size_t max_known_, max_strangers_;
  std::string token_, used_token_;
  const std::string key_;
  std::list<Guest*> strangers_;  // the first came first
  size_t known_ = 0;
};

// A connection while it is there: a stranger until it has shown the key. Where strangers are too
// many, the one that came first goes: who only connects keeps nobody out.
class Guest {
 public:
  // `leave` ends the connection.
  Guest(Door& door, std::function<void()> leave);
  ~Guest();
  Guest(const Guest&) = delete;

  // It has shown the key. false: there are too many that have.
  bool welcome();
  // How it ends, from now on.
  void leave_by(std::function<void()> leave) { leave_ = std::move(leave); }

 private:
  Door& door_;
  std::function<void()> leave_;
  bool known_ = false;
};

}  // namespace kibori::studio
