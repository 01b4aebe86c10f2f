// SPDX-License-Identifier: MIT
// The studio's server on the loopback interface, and on request in the network. It serves the page
// over HTTP, and one WebSocket per open page. At most one document is open. Without one, the page
// shows the start page.
//
// Access: a browser exchanges the token of the printed address once for a key. The page keeps the
// key by its origin, port included. It sends the key in its first message and with every request.
// There is no cookie, because a browser would send it to every other port too. Host and Origin must
// be this server's own. Without the key, a client gets only the files of the page, which hold no
// data of the user.
//
// A device of the network has its own entrance: TLS, and a session cookie that it gets for a code
// (pairing.h). The token and the key are not valid there.
//
// Everything runs on the thread that calls run(). Every few ms it reads the session's state and
// sends changes to the pages. A page gets new chunks only after it has drawn the previous ones, and
// skips intermediate states. So a slow or stopped page does not delay other pages.
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
  size_t message_bytes = size_t{1} << 20;     // max size of a page's message
  uint64_t import_bytes = uint64_t{1} << 30;  // max size of an upload
  size_t waiting_bytes = size_t{8} << 20;     // unread bytes after which a page is dropped
  size_t connections = 32;                    // that have shown the key
  size_t strangers = 16;                      // that have not; one more disconnects the oldest
  double header_s = 10;                       // limit for a request's head and a page's first
                                              // message
};

// Serving the network.
struct LanOptions {
  std::vector<std::string> addresses;  // numeric, of this machine
  uint16_t port = 0;                   // 0: any free one
  std::filesystem::path certificate;   // see keep_certificate
};
struct LanPlace {
  std::vector<std::string> urls;
  std::string fingerprint;       // of the certificate
  std::string certificate_made;  // why it is a new one; empty: it is the old one
};

class Server {
 public:
  // Listens on 127.0.0.1. Port 0 chooses a free one. `how` applies to documents that pages open.
  // Errors: the port is in use.
  static Result<std::unique_ptr<Server>> listen(Library library, uint16_t port,
                                                const SessionOptions& how = {},
                                                const Limits& limits = {});
  ~Server();

  uint16_t port() const;
  // The address with the token. A browser can open it once.
  std::string url() const;
  // Calls `notify` with a new address if another browser opens a used one, because the user may
  // have opened it on purpose.
  void on_new_address(std::function<void(const std::string& url)> notify);
  // Also serves devices of the network, over TLS. They must pair with a code. `on_code` receives
  // each new code: at offer_code(), and when a device opens the page and none is valid. Errors: an
  // address or the port cannot be used, or the certificate cannot be stored.
  Result<LanPlace> serve_lan(const LanOptions& how,
                             std::function<void(const std::string& code)> on_code);
  // Makes a code unless there is a valid one.
  void offer_code();
  // Sends every tick of a hand to the publisher too.
  void publish_by(std::unique_ptr<Publisher> publisher);
  // Shows a document.
  void show(std::unique_ptr<Session> session);
  // True if this document is shown and no job is running.
  bool shows(const std::string& file) const;
  // Sends a sentence to every page.
  void notify(const std::string& text);
  // Runs until stop() returns true. It is called every few ms.
  void run(const std::function<bool()>& stop);
  // Saves and closes the open document. If its own file could not be written, returns a sentence
  // that says where the document is now.
  std::string close();
  // After close(): false if work still runs. Its result is not needed. Destroying the server waits
  // for it.
  bool idle() const;

  struct State;  // internal

 private:
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori::studio
