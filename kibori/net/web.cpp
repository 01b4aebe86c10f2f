// SPDX-License-Identifier: MIT
// The only source that compiles Beast's templates. All streams have one type, which works with any
// stream socket. So the templates are compiled once.
#include <kibori/net/web.h>

#include <algorithm>
#include <cctype>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <kibori/net/asio.h>

namespace kibori::net {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::generic::stream_protocol;
using asio::ip::tcp;
using boost::system::error_code;
using Stream = beast::basic_stream<stream_protocol>;

constexpr auto kAcceptAgain = std::chrono::seconds(1);
constexpr size_t kReadBytes = 16384;  // maximum size of the buffer for requests

std::string text_of(beast::string_view view) { return {view.data(), view.size()}; }

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

Received received(error_code failed) {
  if (!failed) return Received::ok;
  if (failed == http::error::body_limit) return Received::too_large;
  if (failed == beast::errc::no_space_on_device) return Received::disk_full;
  return Received::failed;
}

void end(Stream& stream) {
  error_code ignored;
  stream.socket().shutdown(asio::socket_base::shutdown_both, ignored);
  stream.close();
}

}  // namespace

// ---- Loop, Timer, Listener

Loop::Loop() : state_(std::make_unique<State>()) {}
Loop::~Loop() = default;
void Loop::post(std::function<void()> work) { asio::post(state_->io, std::move(work)); }
void Loop::run() { state_->io.run(); }
void Loop::stop() { state_->io.stop(); }

struct Timer::State {
  explicit State(asio::io_context& io) : timer(io) {}
  asio::steady_timer timer;
  uint64_t start = 0;  // counts starts and cancels, so that a queued call can be skipped
};

Timer::Timer(Loop& loop) : state_(std::make_shared<State>(loop.state().io)) {}
Timer::~Timer() { cancel(); }
void Timer::start(Duration after, std::function<void()> call) {
  const uint64_t start = ++state_->start;
  state_->timer.expires_after(after);
  state_->timer.async_wait([state = state_, start, call = std::move(call)](error_code failed) {
    if (!failed && state->start == start) call();
  });
}
void Timer::cancel() {
  state_->start++;
  state_->timer.cancel();
}

Socket::Socket(std::unique_ptr<State> state) : state_(std::move(state)) {}
Socket::Socket(Socket&&) noexcept = default;
Socket::~Socket() = default;

struct Listener::State : std::enable_shared_from_this<State> {
  explicit State(Loop& loop) : acceptor(loop.state().io), again(loop) {}
  void accept() {
    acceptor.async_accept([self = shared_from_this()](error_code failed, tcp::socket socket) {
      if (!self->acceptor.is_open()) return;
      if (failed) {
        self->again.start(kAcceptAgain, [self] { self->accept(); });
        return;
      }
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      self->on_connection(
          Socket(std::make_unique<Socket::State>(stream_protocol::socket(std::move(socket)))));
      if (self->acceptor.is_open()) self->accept();
    });
  }
  tcp::acceptor acceptor;
  Timer again;
  std::function<void(Socket)> on_connection;
};

Listener::Listener(Loop& loop) : state_(std::make_shared<State>(loop)) {}
Listener::~Listener() { close(); }

Status Listener::listen(const std::string& host, uint16_t port) {
  error_code failed;
  tcp::resolver resolver(state_->acceptor.get_executor());
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, failed);
  if (failed || found.empty()) return Error{"there is no host " + host};
  const tcp::endpoint endpoint = found.begin()->endpoint();
  tcp::acceptor& acceptor = state_->acceptor;
  acceptor.open(endpoint.protocol(), failed);
  if (!failed) acceptor.set_option(tcp::acceptor::reuse_address(true), failed);
  if (!failed) acceptor.bind(endpoint, failed);
  if (!failed) acceptor.listen(asio::socket_base::max_listen_connections, failed);
  if (failed) return Error{failed.message()};
  return Ok{};
}

uint16_t Listener::port() const {
  error_code failed;
  return state_->acceptor.local_endpoint(failed).port();
}

void Listener::start(std::function<void(Socket)> on_connection) {
  state_->on_connection = std::move(on_connection);
  state_->accept();
}

void Listener::close() {
  error_code ignored;
  state_->acceptor.close(ignored);
  state_->again.cancel();
}

// ---- HTTP

size_t Request::count(std::string_view name) const {
  return static_cast<size_t>(std::count_if(
      headers.begin(), headers.end(), [&](const auto& h) { return same_name(h.first, name); }));
}

std::string_view Request::header(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (same_name(key, name)) return value;
  return {};
}

struct HttpStream::State {
  explicit State(Socket socket) : stream(std::move(socket.state().socket)) {}

  void describe() {
    const auto& head = parser->get();
    request = {};
    request.method = text_of(head.method_string());
    request.target = text_of(head.target());
    for (const auto& field : head)
      request.headers.emplace_back(text_of(field.name_string()), text_of(field.value()));
    if (const auto length = parser->content_length()) request.content_length = *length;
    request.chunked = parser->chunked();
    request.keep_alive = head.keep_alive();
    request.upgrade = websocket::is_upgrade(head);
  }

  template <class Body>
  void prepare(http::response<Body>& message, const Response& head) {
    message.version(11);
    message.result(head.status);
    for (const auto& [name, value] : head.headers) message.set(name, value);
    message.keep_alive(head.keep_alive);
    message.prepare_payload();
  }

  void drain(const std::shared_ptr<void>& owner) {
    buffer.clear();
    stream.async_read_some(buffer.prepare(8192), [this, owner](error_code failed, size_t) {
      if (failed) return stream.close();
      drain(owner);
    });
  }

  Stream stream;
  beast::flat_buffer buffer{kReadBytes};
  std::optional<http::request_parser<http::empty_body>> parser;
  std::optional<http::request_parser<http::file_body>> upload;
  bool upgraded = false;  // `stream` belongs to a WebSocket
  Request request;
  std::string body;
  http::response<http::span_body<const char>> response;
  http::response<http::file_body> file_response;
};

HttpStream::HttpStream(Socket socket) : state_(std::make_unique<State>(std::move(socket))) {}
HttpStream::~HttpStream() = default;
void HttpStream::expire_after(Duration time) { state_->stream.expires_after(time); }
void HttpStream::expire_never() { state_->stream.expires_never(); }
const Request& HttpStream::request() const { return state_->request; }

void HttpStream::read_head(const RequestLimits& limits, std::function<void(Received)> done) {
  State& s = *state_;
  s.parser.emplace();
  s.parser->header_limit(limits.header_bytes);
  s.parser->body_limit(limits.body_bytes);
  http::async_read_header(s.stream, s.buffer, *s.parser,
                          [&s, done = std::move(done)](error_code failed, size_t) {
                            if (!failed) s.describe();
                            done(received(failed));
                          });
}

bool HttpStream::receive_body(const std::filesystem::path& file,
                              std::function<void(Received)> done) {
  State& s = *state_;
  s.upload.emplace(std::move(*s.parser));
  error_code failed;
  s.upload->get().body().open(file.c_str(), beast::file_mode::write, failed);
  if (failed) return false;
  http::async_read(s.stream, s.buffer, *s.upload,
                   [&s, done = std::move(done)](error_code stopped, size_t) {
                     if (!stopped) s.upload->get().body().close();
                     done(received(stopped));
                   });
  return true;
}

void HttpStream::write(Response response, std::function<void(bool)> done) {
  State& s = *state_;
  s.response = {};
  if (auto* const text = std::get_if<std::string>(&response.body)) {
    s.body = std::move(*text);
    s.response.body() = {s.body.data(), s.body.size()};
  } else {
    const std::string_view view = std::get<std::string_view>(response.body);
    s.response.body() = {view.data(), view.size()};
  }
  s.prepare(s.response, response);
  http::async_write(s.stream, s.response,
                    [done = std::move(done)](error_code failed, size_t) { done(!failed); });
}

bool HttpStream::write_file(Response head, const std::filesystem::path& file,
                            std::function<void(bool)> done) {
  State& s = *state_;
  s.file_response = {};
  error_code failed;
  s.file_response.body().open(file.c_str(), beast::file_mode::scan, failed);
  if (failed) return false;
  s.prepare(s.file_response, head);
  http::async_write(s.stream, s.file_response,
                    [&s, done = std::move(done)](error_code stopped, size_t) {
                      s.file_response = {};  // closes the file
                      done(!stopped);
                    });
  return true;
}

void HttpStream::finish(Duration linger, std::shared_ptr<void> owner) {
  error_code ignored;
  state_->stream.socket().shutdown(asio::socket_base::shutdown_send, ignored);
  state_->stream.expires_after(linger);
  state_->drain(owner);
}

void HttpStream::close() {
  if (!state_->upgraded) end(state_->stream);
}

// ---- WebSocket

struct WebSocket::State {
  State(Stream stream, http::request<http::empty_body> asked)
      : socket(std::move(stream)), request(std::move(asked)) {}
  websocket::stream<Stream> socket;
  http::request<http::empty_body> request;
  beast::flat_buffer buffer;
};

std::unique_ptr<WebSocket> HttpStream::upgrade() {
  state_->stream.expires_never();
  auto made = std::make_unique<WebSocket>(
      std::make_unique<WebSocket::State>(std::move(state_->stream), state_->parser->release()));
  state_->upgraded = true;
  return made;
}

WebSocket::WebSocket(std::unique_ptr<State> state) : state_(std::move(state)) {}
WebSocket::~WebSocket() = default;

void WebSocket::accept(std::function<void(bool)> done) {
  auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeout.idle_timeout = std::chrono::seconds(30);
  timeout.keep_alive_pings = true;
  state_->socket.set_option(timeout);
  state_->socket.binary(true);
  state_->socket.async_accept(state_->request,
                              [done = std::move(done)](error_code failed) { done(!failed); });
}

void WebSocket::max_message(size_t bytes) { state_->socket.read_message_max(bytes); }

void WebSocket::read(std::function<void(std::optional<WebSocketMessage>)> done) {
  State& s = *state_;
  s.buffer.clear();
  s.socket.async_read(s.buffer, [&s, done = std::move(done)](error_code failed, size_t) {
    if (failed) return done(std::nullopt);
    const auto data = s.buffer.cdata();
    done(WebSocketMessage{{static_cast<const uint8_t*>(data.data()), data.size()},
                          s.socket.got_binary()});
  });
}

void WebSocket::write(std::span<const uint8_t> message, std::function<void(bool)> done) {
  state_->socket.async_write(
      asio::buffer(message.data(), message.size()),
      [done = std::move(done)](error_code failed, size_t) { done(!failed); });
}

void WebSocket::close(uint16_t code, std::function<void()> done) {
  state_->socket.async_close(code, [done = std::move(done)](error_code) { done(); });
}

void WebSocket::drop() { end(beast::get_lowest_layer(state_->socket)); }

// ---- The blocking client

struct WebSocketClient::State {
  State(std::chrono::milliseconds time, size_t max_message) : patience(time) {
    socket.read_message_max(max_message);
  }
  Stream& stream() { return beast::get_lowest_layer(socket); }
  // Calls begin(handler), which starts an operation. Waits until the operation ends or times out.
  template <class Begin>
  error_code wait_for(Begin begin) {
    error_code code = asio::error::timed_out;
    stream().expires_after(patience);
    begin([&code](error_code ended, const auto&...) { code = ended; });
    io.restart();
    io.run();
    return code;
  }

  const std::chrono::milliseconds patience;
  asio::io_context io;
  websocket::stream<Stream> socket{io};
  beast::flat_buffer buffer;
  std::string host;  // with the port
  std::vector<stream_protocol::endpoint> endpoints;
};

WebSocketClient::WebSocketClient(std::chrono::milliseconds patience, size_t max_message)
    : state_(std::make_unique<State>(patience, max_message)) {}
WebSocketClient::~WebSocketClient() = default;

Status WebSocketClient::resolve(const std::string& host, const std::string& port) {
  error_code failed;
  tcp::resolver resolver(state_->io);
  const auto found = resolver.resolve(host, port, failed);
  if (failed) return Error{failed.message()};
  state_->host = host + ":" + port;
  for (const auto& entry : found) state_->endpoints.emplace_back(entry.endpoint());
  return Ok{};
}

Status WebSocketClient::connect() {
  const error_code failed = state_->wait_for(
      [this](auto done) { state_->stream().async_connect(state_->endpoints, std::move(done)); });
  if (failed) return Error{failed.message()};
  error_code ignored;
  state_->stream().socket().set_option(tcp::no_delay(true), ignored);
  return Ok{};
}

Status WebSocketClient::handshake() {
  const error_code failed = state_->wait_for(
      [this](auto done) { state_->socket.async_handshake(state_->host, "/", std::move(done)); });
  if (failed) return Error{failed.message()};
  return Ok{};
}

bool WebSocketClient::send_text(std::string_view text) {
  return !state_->wait_for([&](auto done) {
    state_->socket.async_write(asio::buffer(text.data(), text.size()), std::move(done));
  });
}

Result<std::string> WebSocketClient::receive() {
  state_->buffer.clear();
  const error_code failed = state_->wait_for(
      [this](auto done) { state_->socket.async_read(state_->buffer, std::move(done)); });
  if (failed == beast::error::timeout)
    return Error{"no answer within " + std::to_string(state_->patience.count() / 1000) + " s"};
  if (failed) return Error{"the connection was closed"};
  return beast::buffers_to_string(state_->buffer.data());
}

}  // namespace kibori::net
