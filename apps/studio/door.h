// SPDX-License-Identifier: MIT
// Access control. A browser exchanges the token of the printed address once for a key, and shows
// the key from then on. Internal to apps/studio.
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
  // Returns the key for the valid token or for the key itself, else an empty text. A token works
  // once. If the used token comes again, `on_new_token` receives a new token, to be printed in the
  // terminal. This is safe: a client that knows the used token could already read the terminal.
  std::string enter(std::string_view token, std::string_view key);
  bool is_key(std::string_view key) const;

  std::function<void(const std::string& token)> on_new_token;

 private:
  std::string token_ = random_hex(), used_token_;
  const std::string key_ = random_hex();
};

class Guest;

// Counts the connections of an entrance.
class GuestList {
 public:
  // `known`: max number of connections that have shown a valid key or session. `strangers`: max
  // number of other connections.
  GuestList(size_t known, size_t strangers) : max_known_(known), max_strangers_(strangers) {}
  GuestList(const GuestList&) = delete;

 private:
  friend Guest;

  const size_t max_known_, max_strangers_;
  std::list<Guest*> strangers_;  // oldest first
  size_t known_ = 0;
};

// A connection. It is a stranger until it has shown a valid key or session. If there are too many
// strangers, the oldest one is disconnected. So clients that only connect cannot block others.
class Guest {
 public:
  // `leave` ends the connection.
  Guest(GuestList& list, std::function<void()> leave);
  ~Guest();
  Guest(const Guest&) = delete;

  // Call this when the connection has shown a valid key or session. Returns false if too many such
  // connections exist.
  bool welcome();
  // Replaces the callback that ends the connection.
  void leave_by(std::function<void()> leave) { leave_ = std::move(leave); }

 private:
  GuestList& list_;
  std::function<void()> leave_;
  bool known_ = false;
};

}  // namespace kibori::studio
