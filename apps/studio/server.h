// SPDX-License-Identifier: MIT
// The studio on the loopback interface: the page over HTTP, and one WebSocket for each page that is
// open. One document at a time is carved, or none, and then the page asks what to begin with.
//
// Who may come in: the token of the address that is printed is exchanged, once, for a key. The page
// keeps it by its origin, port included, and shows it in its first message and with every request;
// there is no cookie, which a browser would send to every other port as well. Host and Origin must
// be this server's own. Without the key there is the page's program, the same for everyone, and
// nothing else. Everything happens on the thread that calls run(): every few ms the studio is
// followed, and what changed is offered to the pages. A page gets the next chunks when it has drawn
// the last, and then the newest: so one that is slow or stands still holds up nobody.
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
  size_t message_bytes = size_t{1} << 20;     // of a page's messages
  uint64_t import_bytes = uint64_t{1} << 30;  // of a file that is brought
  size_t waiting_bytes = size_t{8} << 20;     // to a page that does not read; then it is let go of
  size_t connections = 32;                    // that have shown the key
  size_t strangers = 16;                      // that have not; then the first of them goes
  double header_s = 10;                       // for a request's head, and a page's first message
};

class Server {
 public:
  // Listens on 127.0.0.1; port 0: any that is free. `how` documents are opened that pages ask for.
  // Errors: the port is taken.
  static Result<std::unique_ptr<Server>> listen(Library library, uint16_t port,
                                                const SessionOptions& how = {},
                                                const Limits& limits = {});
  ~Server();

  uint16_t port() const;
  // With the token, to be opened in a browser by whoever may; once.
  std::string url() const;
  // Told the next address when one that was used is opened by another browser, which the person may
  // want.
  void on_new_address(std::function<void(const std::string& url)> notify);
  // Every tick that a hand makes goes to it, too.
  void publish_by(std::unique_ptr<Publisher> publisher);
  // The document that is carved.
  void show(std::unique_ptr<Session> session);
  // Whether that document is shown, and nothing else is under way.
  bool shows(const std::string& file) const;
  // A sentence for every page.
  void notify(const std::string& text);
  // Until stop() says so, which is asked every few ms.
  void run(const std::function<bool()>& stop);
  // Saves and closes what is open. A sentence on where it is, if not where it belongs.
  std::string close();

  struct State;  // internal

 private:
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori::studio
