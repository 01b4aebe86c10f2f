// SPDX-License-Identifier: MIT
// Access control. A token is a secret in the address that the studio prints. A browser exchanges
// the token for a key, once. Later, it shows the key. Internal to apps/studio.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <string>
#include <string_view>

#include "apps/studio/secret.h"

namespace kibori::studio {

class Door {
 public:
  const std::string& token() const { return token_; }
  // Returns the key if `token` is valid, or if `key` is the key. Otherwise, returns an empty text.
  // A token is valid once. If a used token arrives again, `on_new_token` receives a new token,
  // which the terminal prints. This is safe, because only a client that can read the terminal knows
  // the used token.
  std::string enter(std::string_view token, std::string_view key);
  bool is_key(std::string_view key) const;

  std::function<void(const std::string& token)> on_new_token;

 private:
  std::string token_ = random_hex(), used_token_;
  const std::string key_ = random_hex();
};

class Guest;

// Counts the connections of an entrance. A stranger is a connection that has not shown a valid key
// or session.
class GuestList {
 public:
  // `known` is the maximum number of connections that have shown a valid key or session.
  // `strangers` is the maximum number of strangers.
  GuestList(size_t known, size_t strangers) : max_known_(known), max_strangers_(strangers) {}
  GuestList(const GuestList&) = delete;

 private:
  friend Guest;

  const size_t max_known_, max_strangers_;
  std::list<Guest*> strangers_;  // the oldest first
  size_t known_ = 0;
};

// A connection. It is a stranger until welcome(). If there are too many strangers, the oldest one
// is disconnected. So clients that only connect cannot block others.
class Guest {
 public:
  // `leave` must end the connection.
  Guest(GuestList& list, std::function<void()> leave);
  ~Guest();
  Guest(const Guest&) = delete;

  // Call this when the connection has shown a valid key or session. Returns false if there are too
  // many such connections.
  bool welcome();
  // Replaces the callback that ends the connection.
  void leave_by(std::function<void()> leave) { leave_ = std::move(leave); }

 private:
  GuestList& list_;
  std::function<void()> leave_;
  bool known_ = false;
};

}  // namespace kibori::studio
