// SPDX-License-Identifier: MIT
#include "apps/publish/tick_server.h"

#include <atomic>
#include <charconv>
#include <chrono>
#include <deque>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "apps/studio/messages.h"

namespace kibori {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Message = std::shared_ptr<const std::vector<uint8_t>>;

constexpr size_t kReaders = 32;
// About 30 s at 1 kHz. A reader with more unread bytes misses ticks.
constexpr size_t kWaitingBytes = size_t{8} << 20;
constexpr auto kHeaderTime = std::chrono::seconds(10);
constexpr auto kGoodbyeTime = std::chrono::seconds(1);

// The host of "http://host:port" or "host:port".
std::string_view host_of(std::string_view text) {
  if (const size_t scheme = text.find("://"); scheme != text.npos) text.remove_prefix(scheme + 3);
  const size_t colon = text.rfind(':');
  if (colon != text.npos && text.find(']', colon) == text.npos) text = text.substr(0, colon);
  return text;
}

}  // namespace

// The thread that runs `io` owns all members except `readers`.
struct TickServer::State {
  class Reader;

  explicit State(std::string at) : host(std::move(at)), acceptor(io), limit(io) {}

  void accept();
  bool may_read(const http::request<http::empty_body>& request) const;
  void send(const Message& message, bool ticks);
  // Sends every reader its pending messages within kGoodbyeTime. Then `io` has no more work.
  void finish();

  const std::string host;
  std::string address;
  Message about;
  std::atomic<size_t> readers{0};
  bool runs = true;
  std::set<Reader*> all;  // readers, and connections that are still in the handshake
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer limit;  // for finish(), and before accept() retries
  std::thread thread;
};

class TickServer::State::Reader : public std::enable_shared_from_this<Reader> {
 public:
  Reader(tcp::socket socket, State& server) : socket_(std::move(socket)), server_(server) {
    server_.all.insert(this);
  }
  ~Reader() {
    server_.all.erase(this);
    if (reads_) server_.readers--;
    if (server_.runs && server_.all.empty()) server_.limit.cancel();
  }

  void begin() {
    parser_.header_limit(8192);
    beast::get_lowest_layer(socket_).expires_after(kHeaderTime);
    http::async_read(beast::get_lowest_layer(socket_), buffer_, parser_,
                     [self = shared_from_this()](beast::error_code failed, size_t) {
                       if (!failed) self->answer();
                     });
  }

  void send(const Message& message, bool ticks) {
    if (!reads_ || closed_ || (ticks && waiting_bytes_ > kWaitingBytes)) return;
    waiting_bytes_ += message->size();
    queue_.push_back(message);
    if (queue_.size() == 1) write();
  }

  void finish() {
    if (!reads_) return close();
    finishing_ = true;
    if (queue_.empty()) send_end();
  }

 private:
  void answer() {
    const auto& request = parser_.get();
    const bool may = server_.may_read(request);
    if (!websocket::is_upgrade(request) || !may) {
      refusal_.version(request.version());
      refusal_.result(may ? http::status::upgrade_required : http::status::forbidden);
      refusal_.set(http::field::content_type, "text/plain; charset=utf-8");
      if (may) refusal_.set(http::field::upgrade, "websocket");
      refusal_.keep_alive(false);
      refusal_.body() =
          may ? "This address publishes ticks over WebSocket: see docs/recordings.md.\n"
              : "Pages of other sites may not read these ticks.\n";
      refusal_.prepare_payload();
      http::async_write(beast::get_lowest_layer(socket_), refusal_,
                        [self = shared_from_this()](beast::error_code, size_t) { self->close(); });
      return;
    }
    beast::get_lowest_layer(socket_).expires_never();
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.idle_timeout = std::chrono::seconds(30);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(1024);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code failed) {
      if (failed) return;
      self->reads_ = true;
      self->server_.readers++;
      if (self->server_.about) self->send(self->server_.about, false);
      self->read();
    });
  }

  // Ignores the messages of a reader, but detects the end of the connection.
  void read() {
    socket_.async_read(heard_, [self = shared_from_this()](beast::error_code failed, size_t) {
      if (failed) return self->close();
      self->heard_.clear();
      self->read();
    });
  }

  void write() {
    socket_.async_write(asio::buffer(*queue_.front()),
                        [self = shared_from_this()](beast::error_code failed, size_t) {
                          self->waiting_bytes_ -= self->queue_.front()->size();
                          self->queue_.pop_front();
                          if (failed) return self->close();
                          if (!self->queue_.empty())
                            self->write();
                          else if (self->finishing_)
                            self->send_end();
                        });
  }

  void send_end() {
    socket_.async_close(websocket::close_code::normal,
                        [self = shared_from_this()](beast::error_code) { self->close(); });
  }

  void close() {
    if (std::exchange(closed_, true)) return;
    beast::error_code ignored;
    beast::get_lowest_layer(socket_).socket().shutdown(tcp::socket::shutdown_both, ignored);
    beast::get_lowest_layer(socket_).close();
  }

  websocket::stream<beast::tcp_stream> socket_;
  State& server_;
  beast::flat_buffer buffer_{16384}, heard_{4096};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> refusal_;
  std::deque<Message> queue_;
  size_t waiting_bytes_ = 0;
  bool reads_ = false, finishing_ = false, closed_ = false;
};

void TickServer::State::accept() {
  acceptor.async_accept([this](beast::error_code failed, tcp::socket socket) {
    if (failed == asio::error::operation_aborted || !acceptor.is_open()) return;
    if (failed) {  // too many open files: retry later
      limit.expires_after(kGoodbyeTime);
      limit.async_wait([this](beast::error_code) {
        if (acceptor.is_open()) accept();
      });
      return;
    }
    if (all.size() < kReaders) {
      beast::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Reader>(std::move(socket), *this)->begin();
    }
    accept();
  });
}

bool TickServer::State::may_read(const http::request<http::empty_body>& request) const {
  const auto origin = request.find(http::field::origin);
  if (origin == request.end()) return true;  // not a browser
  const std::string_view from = host_of({origin->value().data(), origin->value().size()});
  return from == "localhost" || from == "127.0.0.1" || from == "[::1]" || from == host;
}

void TickServer::State::send(const Message& message, bool ticks) {
  // A copy, because sending removes a reader that is disconnected from `all`.
  const std::vector<Reader*> now(all.begin(), all.end());
  for (Reader* const reader : now)
    if (all.count(reader)) reader->send(message, ticks);
}

void TickServer::State::finish() {
  beast::error_code ignored;
  acceptor.close(ignored);
  limit.cancel();
  if (all.empty()) return;
  limit.expires_after(kGoodbyeTime);
  limit.async_wait([this](beast::error_code stopped) {
    if (!stopped) io.stop();
  });
  const std::vector<Reader*> now(all.begin(), all.end());
  for (Reader* const reader : now)
    if (all.count(reader)) reader->finish();
}

TickServer::TickServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

TickServer::~TickServer() {
  asio::post(state_->io, [state = state_.get()] { state->finish(); });
  state_->thread.join();
  state_->runs = false;  // the rest is destroyed with `io`
}

Result<std::unique_ptr<TickServer>> TickServer::listen(const std::string& address) {
  const std::string wrong = "cannot publish at '" + address + "'";
  const size_t colon = address.rfind(':');
  if (colon == address.npos || colon == 0)
    return Error{wrong + ": write HOST:PORT, like 127.0.0.1:7070"};
  const std::string port_text = address.substr(colon + 1);
  uint16_t port = 0;
  const auto [end, failed_port] =
      std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (port_text.empty() || failed_port != std::errc() || end != port_text.data() + port_text.size())
    return Error{wrong + ": the port must be 0 to 65535"};
  const std::string host = address.substr(0, colon);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  auto state = std::make_unique<State>(host);
  beast::error_code failed;
  tcp::resolver resolver(state->io);
  const auto found = resolver.resolve(bracketed ? host.substr(1, host.size() - 2) : host, port_text,
                                      tcp::resolver::passive, failed);
  if (failed || found.empty())
    return Error{wrong + ": there is no host " + host + "; check the name"};
  const tcp::endpoint endpoint = found.begin()->endpoint();
  tcp::acceptor& acceptor = state->acceptor;
  acceptor.open(endpoint.protocol(), failed);
  if (!failed) acceptor.set_option(tcp::acceptor::reuse_address(true), failed);
  if (!failed) acceptor.bind(endpoint, failed);
  if (!failed) acceptor.listen(asio::socket_base::max_listen_connections, failed);
  if (failed) return Error{wrong + ": " + failed.message() + "; choose another address or port"};
  state->address = host + ":" + std::to_string(acceptor.local_endpoint(failed).port());
  state->accept();
  state->thread = std::thread([&io = state->io] { io.run(); });
  return std::unique_ptr<TickServer>(new TickServer(std::move(state)));
}

const std::string& TickServer::address() const { return state_->address; }

void TickServer::about(std::string json) {
  auto message = std::make_shared<const std::vector<uint8_t>>(
      studio::encode(studio::PublishedAbout{studio::kProtocolVersion, std::move(json)}));
  asio::post(state_->io, [state = state_.get(), message = std::move(message)] {
    state->about = message;
    state->send(message, false);
  });
}

void TickServer::publish(std::span<const TickRow> rows) {
  if (rows.empty() || state_->readers == 0) return;
  studio::PublishedTicks ticks;
  const auto* const bytes = reinterpret_cast<const uint8_t*>(rows.data());
  ticks.rows.assign(bytes, bytes + rows.size_bytes());
  auto message = std::make_shared<const std::vector<uint8_t>>(studio::encode(std::move(ticks)));
  asio::post(state_->io,
             [state = state_.get(), message = std::move(message)] { state->send(message, true); });
}

}  // namespace kibori
