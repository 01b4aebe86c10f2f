// SPDX-License-Identifier: MIT
// The network code of Kibori: an event loop, a listener, HTTP connections and WebSockets. This
// header hides Boost.Asio and Boost.Beast, because a source that includes these takes up to a
// minute to compile. Internal.
//
//   Listener --Socket--> HttpStream --upgrade()--> WebSocket      served, on a Loop
//   WebSocketClient                                               a blocking client
//
// Callbacks run on the thread that calls Loop::run(). All objects on a loop belong to that thread.
// An object must stay alive until it has called its callbacks, so a callback must keep its object
// alive. Bytes that are passed as a span must stay valid until the callback runs.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <kibori/base/result.h>

namespace kibori::net {

using Duration = std::chrono::steady_clock::duration;

// An event loop that calls callbacks. Its destructor drops the pending callbacks, and the objects
// that only these callbacks keep alive.
class Loop {
 public:
  Loop();
  ~Loop();
  // Calls `work` on the loop's thread. Any thread.
  void post(std::function<void()> work);
  // Runs until stop() is called, or until nothing is pending.
  void run();
  void stop();

  struct State;  // internal
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

// Calls a function once, after a delay.
class Timer {
 public:
  explicit Timer(Loop& loop);
  ~Timer();  // cancels
  // Calls `call` after the time `after`. Replaces a pending call.
  void start(Duration after, std::function<void()> call);
  // Cancels the pending call. The call is not made, even if its time has already passed.
  void cancel();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

// A connected stream of bytes.
class Socket {
 public:
  struct State;  // internal
  explicit Socket(std::unique_ptr<State> state);
  Socket(Socket&&) noexcept;
  ~Socket();
  State& state() { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

// Accepts TCP connections.
class Listener {
 public:
  explicit Listener(Loop& loop);
  ~Listener();  // closes
  // Binds to a host name or a numeric address, and listens. Port 0 chooses a free port. Error: the
  // reason, such as "Address already in use".
  Status listen(const std::string& host, uint16_t port);
  uint16_t port() const;
  // Calls on_connection for each new connection. If a connection cannot be accepted, for example
  // because too many files are open, tries again after a second.
  void start(std::function<void(Socket)> on_connection);
  void close();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

// ---- HTTP

// The head of an HTTP request: everything before its body.
struct Request {
  std::string method, target;
  std::vector<std::pair<std::string, std::string>> headers;
  std::optional<uint64_t> content_length;
  bool chunked = false, keep_alive = false;
  bool upgrade = false;  // true: the request asks for a WebSocket

  // Returns the number of headers with this name. Upper and lower case are equal in names.
  size_t count(std::string_view name) const;
  // Returns the value of the first header with this name; empty if there is none.
  std::string_view header(std::string_view name) const;
};

// An HTTP response. The headers Content-Length and Connection are added when it is sent.
struct Response {
  unsigned status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  // A string_view must stay valid until the response is sent.
  std::variant<std::string, std::string_view> body;
  bool keep_alive = false;
};

enum class Received {
  ok,
  too_large,  // the body exceeds the limit
  disk_full,  // the file for the body cannot be written
  failed,     // the connection ended, timed out, or is not HTTP
};

struct RequestLimits {
  uint32_t header_bytes = 8192;
  uint64_t body_bytes = 0;
};

class WebSocket;

// One HTTP connection of a server. Only one operation may run at a time.
class HttpStream {
 public:
  explicit HttpStream(Socket socket);
  ~HttpStream();

  // Sets a deadline, `time` from now, for the current operation and all later ones. An operation
  // that is not finished by then fails.
  void expire_after(Duration time);
  void expire_never();
  // Reads the head of the next request. Then request() returns it.
  void read_head(const RequestLimits& limits, std::function<void(Received)> done);
  const Request& request() const;
  // Reads the body into a new file. If the file cannot be opened, returns false and does not call
  // `done`.
  bool receive_body(const std::filesystem::path& file, std::function<void(Received)> done);
  void write(Response response, std::function<void(bool ok)> done);
  // Sends a response with the file as its body. If the file cannot be opened, returns false and
  // does not call `done`.
  bool write_file(Response head, const std::filesystem::path& file,
                  std::function<void(bool ok)> done);
  // Ends the connection when the peer has closed it, or after `linger`. Until then, reads the
  // remaining input and drops it. (If this end closed at once, the peer could lose the response.)
  // Keeps `owner` alive until the end.
  void finish(Duration linger, std::shared_ptr<void> owner);
  // Ends the connection at once. Has no effect after upgrade().
  void close();
  // Turns the connection into a WebSocket, as the last request asks. Afterwards, this object must
  // not be used, except for close().
  std::unique_ptr<WebSocket> upgrade();

 private:
  friend class WebSocket;
  struct State;
  std::unique_ptr<State> state_;
};

// ---- WebSocket

struct WebSocketMessage {
  std::span<const uint8_t> bytes;  // valid until the next read
  bool binary = false;
};

// Close codes of RFC 6455.
constexpr uint16_t kCloseNormal = 1000, kClosePolicy = 1008, kCloseTryLater = 1013;

// The server's end of a WebSocket. It sends binary messages. Only one read and one write may run at
// a time. It pings a silent peer. If nothing arrives from the peer for 30 s, it ends the
// connection.
class WebSocket {
 public:
  struct State;  // internal
  explicit WebSocket(std::unique_ptr<State> state);
  ~WebSocket();

  void accept(std::function<void(bool ok)> done);
  // Sets the maximum size of a message from the peer. A larger message ends the connection.
  void max_message(size_t bytes);
  // `done` receives nullopt if the connection has ended.
  void read(std::function<void(std::optional<WebSocketMessage>)> done);
  void write(std::span<const uint8_t> message, std::function<void(bool ok)> done);
  void close(uint16_t code, std::function<void()> done);
  // Ends the connection at once.
  void drop();

 private:
  std::unique_ptr<State> state_;
};

// A blocking client. Each call except resolve() waits at most `patience`. Do not use it on a thread
// that runs a Loop.
class WebSocketClient {
 public:
  // `max_message` is the maximum size of a received message [bytes]; 0 means no limit.
  WebSocketClient(std::chrono::milliseconds patience, size_t max_message);
  ~WebSocketClient();

  // To connect, call these three in this order. An error is the message of the system.
  Status resolve(const std::string& host, const std::string& port);
  Status connect();
  Status handshake();
  bool send_text(std::string_view text);
  // Waits for the next message and returns its bytes.
  Result<std::string> receive();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kibori::net
