// SPDX-License-Identifier: MIT
// The network of Kibori: an event loop, a listener, HTTP connections and WebSockets. Boost.Asio and
// Boost.Beast are behind this header, because a source that includes them costs up to a minute to
// compile. Internal.
//
//   Listener --Socket--> HttpStream --upgrade()--> WebSocket      served, on a Loop
//   WebSocketClient                                               a blocking client
//
// Callbacks run on the thread that calls Loop::run(). Objects belong to that thread. A callback
// must keep alive the object that calls it. Bytes that are passed as a span must live until the
// callback.
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

// An event loop that calls callbacks. Its destructor drops pending callbacks, with all objects that
// they keep alive.
class Loop {
 public:
  Loop();
  ~Loop();
  // Calls `work` on the loop's thread. Any thread.
  void post(std::function<void()> work);
  // Runs until stop(), or until nothing is pending.
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
  // Replaces a pending call.
  void start(Duration after, std::function<void()> call);
  // The pending call is not made, even if its time has already passed.
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
  // Binds to a host name or numeric address. Port 0 chooses a free port. Error: the reason, such as
  // "Address already in use".
  Status listen(const std::string& host, uint16_t port);
  uint16_t port() const;
  // Calls on_connection for each new connection. If accepting fails, for example because of too
  // many open files, it tries again after a second.
  void start(std::function<void(Socket)> on_connection);
  void close();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

// ---- HTTP

// The head of a request.
struct Request {
  std::string method, target;
  std::vector<std::pair<std::string, std::string>> headers;
  std::optional<uint64_t> content_length;
  bool chunked = false, keep_alive = false;
  bool upgrade = false;  // asks for a WebSocket

  // Number of headers with this name. Names are compared without case.
  size_t count(std::string_view name) const;
  // The value of the first header with this name; empty if there is none.
  std::string_view header(std::string_view name) const;
};

// The headers Content-Length and Connection are added when the response is sent.
struct Response {
  unsigned status = 200;
  std::vector<std::pair<std::string, std::string>> headers;
  // A view must live until the response is sent.
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

// One HTTP connection of a server. One operation at a time.
class HttpStream {
 public:
  explicit HttpStream(Socket socket);
  ~HttpStream();

  // Sets a deadline for the current and later operations: this time from now. Operations that are
  // not finished by then fail.
  void expire_after(Duration time);
  void expire_never();
  // Reads the head of the next request.
  void read_head(const RequestLimits& limits, std::function<void(Received)> done);
  const Request& request() const;
  // Reads the body into a new file. If the file cannot be written, it returns false and does not
  // call `done`.
  bool receive_body(const std::filesystem::path& file, std::function<void(Received)> done);
  void write(Response response, std::function<void(bool ok)> done);
  // Sends the file as the body. If the file cannot be read, it returns false and does not call
  // `done`.
  bool write_file(Response head, const std::filesystem::path& file,
                  std::function<void(bool ok)> done);
  // Ends the connection after the peer has closed it, or after `linger`. Until then, it reads and
  // drops the remaining input, because the peer would lose the response if this end closed at once.
  // Keeps `owner` alive.
  void finish(Duration linger, std::shared_ptr<void> owner);
  // Ends the connection at once.
  void close();
  // Turns the connection into a WebSocket, as the last request asks. This object must not be used
  // afterwards.
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

// The server's end of a WebSocket. It sends binary messages. One read and one write at a time. It
// pings a silent peer, and ends the connection if there is no answer within 30 s.
class WebSocket {
 public:
  struct State;  // internal
  explicit WebSocket(std::unique_ptr<State> state);
  ~WebSocket();

  void accept(std::function<void(bool ok)> done);
  // Sets the maximum size of a message from the peer. A larger one ends the connection.
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

// A blocking client. Each call waits at most `patience`. Not for a thread that runs a Loop.
class WebSocketClient {
 public:
  // max_message: 0 for no limit.
  WebSocketClient(std::chrono::milliseconds patience, size_t max_message);
  ~WebSocketClient();

  // Call these three in this order to connect. Errors are messages of the system.
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
