// SPDX-License-Identifier: MIT
// Access control. A browser exchanges the token of the printed address once for a key, and shows
// the key from then on. Internal to apps/studio.
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
  // `known`: max number of connections that have shown the key. `strangers`: max number of others.
  Door(size_t known, size_t strangers)
      : max_known_(known), max_strangers_(strangers), token_(random_hex()), key_(random_hex()) {}

  const std::string& token() const { return token_; }
  // Returns the key for the valid token or for the key itself, else an empty text. A token works
  // once. If the used token comes again, `on_new_token` receives a new token, to be printed in the
  // terminal. A client that knows the used token can read the terminal anyway.
  std::string enter(std::string_view token, std::string_view key);
  bool is_key(std::string_view key) const;

  std::function<void(const std::string& token)> on_new_token;

 private:
  friend Guest;

  const size_t max_known_, max_strangers_;
  std::string token_, used_token_;
  const std::string key_;
  std::list<Guest*> strangers_;  // oldest first
  size_t known_ = 0;
};

// A connection. It is a stranger until it has shown the key. If there are too many strangers, the
// oldest one is disconnected. So a client that only connects keeps nobody out.
class Guest {
 public:
  // `leave` ends the connection.
  Guest(Door& door, std::function<void()> leave);
  ~Guest();
  Guest(const Guest&) = delete;

  // The connection has shown the key. Returns false if too many connections have.
  bool welcome();
  // Replaces the callback that ends the connection.
  void leave_by(std::function<void()> leave) { leave_ = std::move(leave); }

 private:
  Door& door_;
  std::function<void()> leave_;
  bool known_ = false;
};

}  // namespace kibori::studio
