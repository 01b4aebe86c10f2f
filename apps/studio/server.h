// SPDX-License-Identifier: MIT
// The studio's server. It listens on the loopback interface, and on request in the network. It
// serves the files of the page over HTTP, and has one WebSocket per open page. At most one document
// is open. If none is open, the page shows the start page.
//
// Access from this machine: a browser exchanges the token of the printed address for a key, once.
// The page stores the key for its origin, which includes the port. It sends the key in its first
// message and with every request. The key is not in a cookie, because a browser would send a cookie
// to every other port, too. The headers Host and Origin must name this server. Without the key, a
// client gets only the files of the page, which contain no data of the user.
//
// Access from the network: a device has a separate entrance, with TLS. For a code (pairing.h), it
// gets a session in a cookie. The token and the key are not valid there.
//
// Everything runs on the thread that calls run(). Every few ms, the server reads the state of the
// session, and sends changes to the pages. A page gets new chunks only after it has drawn the last
// ones. It skips the states in between. So a slow or stopped page does not delay other pages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include "apps/publish/publisher.h"
#include "apps/studio/session/library.h"
#include "apps/studio/session/session.h"

namespace kibori::studio {

struct Limits {
  size_t message_bytes = size_t{1} << 20;     // maximum size of a page's message
  uint64_t import_bytes = uint64_t{1} << 30;  // maximum size of an upload
  size_t waiting_bytes = size_t{8} << 20;  // maximum size of unread data; then the page is dropped
  size_t connections = 32;                 // maximum number with the key
  size_t strangers = 16;  // maximum number without; one more disconnects the oldest
  // Time limit for the head of a request, and for the first message of a page [s].
  double header_s = 10;
};

// Options for serving the network.
struct LanOptions {
  std::vector<std::string> addresses;  // numeric addresses of this machine
  uint16_t port = 0;                   // 0: any free port
  std::filesystem::path certificate;   // see keep_certificate
};
struct LanPlace {
  std::vector<std::string> urls;
  std::string fingerprint;       // fingerprint of the certificate
  std::string certificate_made;  // reason why it is new; empty: it is the old one
};

class Server {
 public:
  // Listens on 127.0.0.1. Port 0 selects a free port. `how` applies to documents that pages open.
  // Errors: the port is in use.
  static Result<std::unique_ptr<Server>> listen(Library library, uint16_t port,
                                                const SessionOptions& how = {},
                                                const Limits& limits = {});
  ~Server();

  uint16_t port() const;
  // Returns the address with the token. It can be opened once.
  std::string url() const;
  // Sets a callback for new addresses. If a browser opens a used address, the server makes a new
  // address and calls `notify`. The user may have opened the used address on purpose.
  void on_new_address(std::function<void(const std::string& url)> notify);
  // Also serves devices of the network, over TLS. They must pair with a code. `on_code` receives
  // each new code: in offer_code(), and when a device opens the page while no code is valid.
  // Errors: an address or the port cannot be used; the certificate cannot be stored.
  Result<LanPlace> serve_lan(const LanOptions& how,
                             std::function<void(const std::string& code)> on_code);
  // Makes a code, unless there is a valid one.
  void offer_code();
  // Also sends every tick of a hand to the publisher.
  void publish_by(std::unique_ptr<Publisher> publisher);
  // Shows a document on all pages.
  void show(std::unique_ptr<Session> session);
  // Returns true if this document is shown and no job is running.
  bool shows(const std::string& file) const;
  // Sends a sentence to every page.
  void notify(const std::string& text);
  // Runs until stop() returns true. stop() is called every few ms.
  void run(const std::function<bool()>& stop);
  // Saves and closes the open document. If its file could not be written, returns a sentence with
  // the place where the document is now. Otherwise, returns an empty text.
  std::string close();
  // Call this after close(). Returns false if a job still runs. Its result is not needed, but the
  // destructor waits for it.
  bool idle() const;

  struct State;  // internal

 private:
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori::studio
