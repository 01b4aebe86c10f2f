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

#include <kibori/net/web.h>
#include "apps/studio/messages.h"

namespace kibori {
namespace {

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

// The thread that runs `loop` owns all members except `readers`.
struct TickServer::State {
  class Reader;

  explicit State(std::string at) : host(std::move(at)) {}

  void accept(net::Socket socket);
  bool may_read(const net::Request& request) const;
  void send(const Message& message, bool ticks);
  // Sends every reader its pending messages within kGoodbyeTime. Then `loop` has no more work.
  void finish();

  const std::string host;
  std::string address;
  Message about;
  std::atomic<size_t> readers{0};
  bool runs = true;
  std::set<Reader*> all;  // readers, and connections that are still in the handshake
  net::Loop loop;
  net::Listener listener{loop};
  net::Timer limit{loop};  // for finish()
  std::thread thread;
};

class TickServer::State::Reader : public std::enable_shared_from_this<Reader> {
 public:
  Reader(net::Socket socket, State& server) : http_(std::move(socket)), server_(server) {
    server_.all.insert(this);
  }
  ~Reader() {
    server_.all.erase(this);
    if (reads_) server_.readers--;
    if (server_.runs && server_.all.empty()) server_.limit.cancel();
  }

  void begin() {
    http_.expire_after(kHeaderTime);
    http_.read_head({}, [self = shared_from_this()](net::Received head) {
      if (head == net::Received::ok) self->answer();
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
    const net::Request& request = http_.request();
    const bool may = server_.may_read(request);
    if (!request.upgrade || !may) return refuse(may);
    socket_ = http_.upgrade();
    socket_->max_message(1024);
    socket_->accept([self = shared_from_this()](bool accepted) {
      if (!accepted) return;
      self->reads_ = true;
      self->server_.readers++;
      if (self->server_.about) self->send(self->server_.about, false);
      self->read();
    });
  }

  void refuse(bool may) {
    net::Response refusal;
    refusal.status = may ? 426 : 403;
    refusal.headers = {{"Content-Type", "text/plain; charset=utf-8"}};
    if (may) refusal.headers.emplace_back("Upgrade", "websocket");
    refusal.body = std::string_view(
        may ? "This address publishes ticks over WebSocket: see docs/recordings.md.\n"
            : "Pages of other sites may not read these ticks.\n");
    http_.write(std::move(refusal), [self = shared_from_this()](bool) { self->close(); });
  }

  // Ignores the messages of a reader, but detects the end of the connection.
  void read() {
    socket_->read([self = shared_from_this()](std::optional<net::WebSocketMessage> message) {
      if (!message) return self->close();
      self->read();
    });
  }

  void write() {
    socket_->write(*queue_.front(), [self = shared_from_this()](bool sent) {
      self->waiting_bytes_ -= self->queue_.front()->size();
      self->queue_.pop_front();
      if (!sent) return self->close();
      if (!self->queue_.empty())
        self->write();
      else if (self->finishing_)
        self->send_end();
    });
  }

  void send_end() {
    socket_->close(net::kCloseNormal, [self = shared_from_this()] { self->close(); });
  }

  void close() {
    if (std::exchange(closed_, true)) return;
    if (socket_)
      socket_->drop();
    else
      http_.close();
  }

  net::HttpStream http_;  // until the handshake
  std::unique_ptr<net::WebSocket> socket_;
  State& server_;
  std::deque<Message> queue_;
  size_t waiting_bytes_ = 0;
  bool reads_ = false, finishing_ = false, closed_ = false;
};

void TickServer::State::accept(net::Socket socket) {
  if (all.size() < kReaders) std::make_shared<Reader>(std::move(socket), *this)->begin();
}

bool TickServer::State::may_read(const net::Request& request) const {
  if (request.count("Origin") == 0) return true;  // not a browser
  const std::string_view from = host_of(request.header("Origin"));
  return from == "localhost" || from == "127.0.0.1" || from == "[::1]" || from == host;
}

void TickServer::State::send(const Message& message, bool ticks) {
  // A copy, because sending removes a reader that is disconnected from `all`.
  const std::vector<Reader*> now(all.begin(), all.end());
  for (Reader* const reader : now)
    if (all.count(reader)) reader->send(message, ticks);
}

void TickServer::State::finish() {
  listener.close();
  if (all.empty()) return;
  limit.start(kGoodbyeTime, [this] { loop.stop(); });
  const std::vector<Reader*> now(all.begin(), all.end());
  for (Reader* const reader : now)
    if (all.count(reader)) reader->finish();
}

TickServer::TickServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

TickServer::~TickServer() {
  state_->loop.post([state = state_.get()] { state->finish(); });
  state_->thread.join();
  state_->runs = false;  // `loop` destroys the remaining readers
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
  const Status listening =
      state->listener.listen(bracketed ? host.substr(1, host.size() - 2) : host, port);
  if (!listening)
    return Error{wrong + ": " + listening.error() + "; choose another address or port"};
  state->address = host + ":" + std::to_string(state->listener.port());
  state->listener.start(
      [here = state.get()](net::Socket socket) { here->accept(std::move(socket)); });
  state->thread = std::thread([&loop = state->loop] { loop.run(); });
  return std::unique_ptr<TickServer>(new TickServer(std::move(state)));
}

const std::string& TickServer::address() const { return state_->address; }

void TickServer::about(std::string json) {
  auto message = std::make_shared<const std::vector<uint8_t>>(
      studio::encode(studio::PublishedAbout{studio::kProtocolVersion, std::move(json)}));
  state_->loop.post([state = state_.get(), message = std::move(message)] {
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
  state_->loop.post(
      [state = state_.get(), message = std::move(message)] { state->send(message, true); });
}

}  // namespace kibori
