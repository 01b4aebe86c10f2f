// SPDX-License-Identifier: MIT
// The studio's server on the loopback interface. It serves the page over HTTP, and one WebSocket
// per open page. At most one document is open. Without one, the page shows the start page.
//
// Access: a browser exchanges the token of the printed address once for a key. The page keeps the
// key by its origin, port included. It sends the key in its first message and with every request.
// There is no cookie, because a browser would send it to every other port too. Host and Origin must
// be this server's own. Without the key, a client gets only the page's program, which is the same
// for everyone.
//
// Everything runs on the thread that calls run(). Every few ms it follows the session and offers
// changes to the pages. A page gets the next chunks after it has drawn the last ones, and then only
// the newest. So a slow or stopped page delays nobody.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

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
  // Calls `notify` with a new address if another browser opens a used one. The user may want that.
  void on_new_address(std::function<void(const std::string& url)> notify);
  // Sends every tick of a hand to the publisher too.
  void publish_by(std::unique_ptr<Publisher> publisher);
  // Shows a document.
  void show(std::unique_ptr<Session> session);
  // Whether this document is shown and no job is running.
  bool shows(const std::string& file) const;
  // Sends a sentence to every page.
  void notify(const std::string& text);
  // Runs until stop() returns true. It is called every few ms.
  void run(const std::function<bool()>& stop);
  // Saves and closes the open document. Returns a sentence on its location if it could not be saved
  // in its place.
  std::string close();
  // After close(): false if work still runs whose result nobody wants. Destroying the server waits
  // for it.
  bool idle() const;

  struct State;  // internal

 private:
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori::studio
