// SPDX-License-Identifier: MIT
#include "apps/studio/tls_listener.h"

#include <array>
#include <cerrno>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/local/connect_pair.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/asio/write.hpp>
#include <sys/socket.h>

#include <kibori/net/asio.h>

namespace kibori::studio {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using ByteSocket = asio::generic::stream_protocol::socket;

constexpr uint8_t kTlsHandshake = 22;  // the first byte of TLS (RFC 8446, 5.1)
constexpr auto kGoodbye = std::chrono::seconds(2);
constexpr size_t kBlock = 65536;  // size of the buffer of each direction

// Answers a client that speaks HTTP without TLS, and ends the connection.
void refuse_plain(net::Socket socket) {
  const auto stream = std::make_shared<net::HttpStream>(std::move(socket));
  stream->expire_after(kGoodbye);
  stream->read_head({}, [stream](net::Received head) {
    if (head != net::Received::ok) return stream->finish(kGoodbye, stream);
    net::Response response;
    response.status = 400;
    response.headers = {{"Content-Type", "text/plain; charset=utf-8"}};
    response.body = std::string_view("this address needs TLS; write https:// instead of http://\n");
    stream->write(std::move(response), [stream](bool) { stream->finish(kGoodbye, stream); });
  });
}

}  // namespace

struct TlsListener::State {
  class Link;

  net::Loop& loop;
  GuestList& guests;
  const net::Duration handshake;
  std::function<void(net::Socket)> on_connection;
  std::shared_ptr<asio::ssl::context> tls;
  std::vector<std::unique_ptr<net::Listener>> listeners;
};

// One TLS connection. It copies bytes between the device and the server.
class TlsListener::State::Link : public std::enable_shared_from_this<Link> {
 public:
  Link(net::Socket socket, std::shared_ptr<State> listener)
      : listener_(std::move(listener)),
        tls_(listener_->tls),
        outer_(std::move(socket.state().socket), *tls_),
        inner_(outer_.get_executor()),
        limit_(listener_->loop),
        guest_(std::make_shared<Guest>(listener_->guests, [this] { close(); })) {}

  void begin() {
    limit_.start(listener_->handshake, [self = shared_from_this()] { self->close(); });
    wait_for_first_byte();
  }

 private:
  void wait_for_first_byte() {
    outer_.next_layer().async_wait(ByteSocket::wait_read,
                                   [self = shared_from_this()](error_code failed) {
                                     if (failed) return self->close();
                                     self->look();
                                   });
  }

  // Checks if the first byte begins a TLS handshake. A wait may end although nothing has arrived:
  // Asio may attribute an event of a closed socket to a new one that reuses its state.
  void look() {
    uint8_t first = 0;
    const auto size = recv(outer_.next_layer().native_handle(), &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return wait_for_first_byte();
    if (size != 1) return close();
    if (first != kTlsHandshake) {
      end_stranger();
      return refuse_plain(
          net::Socket(std::make_unique<net::Socket::State>(std::move(outer_.next_layer()))));
    }
    outer_.async_handshake(asio::ssl::stream_base::server,
                           [self = shared_from_this()](error_code failed) {
                             if (failed) return self->close();
                             self->hand_over();
                           });
  }

  void end_stranger() {
    limit_.cancel();
    guest_.reset();
  }

  void hand_over() {
    asio::local::stream_protocol::socket near(outer_.get_executor()), far(outer_.get_executor());
    error_code failed;
    asio::local::connect_pair(near, far, failed);
    end_stranger();
    if (failed) return close();  // too many open files
    inner_ = std::move(near);
    receive();
    send();
    listener_->on_connection(net::Socket(std::make_unique<net::Socket::State>(std::move(far))));
  }

  // From the device to the server.
  void receive() {
    outer_.async_read_some(
        asio::buffer(received_), [self = shared_from_this()](error_code failed, size_t size) {
          if (failed) {
            error_code ignored;
            self->inner_.shutdown(ByteSocket::shutdown_send, ignored);
            return;
          }
          asio::async_write(self->inner_, asio::buffer(self->received_.data(), size),
                            [self](error_code stopped, size_t) {
                              if (stopped) return self->close();
                              self->receive();
                            });
        });
  }

  // From the server to the device.
  void send() {
    inner_.async_read_some(asio::buffer(sent_),
                           [self = shared_from_this()](error_code failed, size_t size) {
                             if (failed) return self->finish();
                             asio::async_write(self->outer_, asio::buffer(self->sent_.data(), size),
                                               [self](error_code stopped, size_t) {
                                                 if (stopped) return self->close();
                                                 self->send();
                                               });
                           });
  }

  // The server has sent everything. Sends close_notify, then closes.
  void finish() {
    limit_.start(kGoodbye, [self = shared_from_this()] { self->close(); });
    outer_.async_shutdown([self = shared_from_this()](error_code) { self->close(); });
  }

  void close() {
    limit_.cancel();
    error_code ignored;
    outer_.next_layer().shutdown(ByteSocket::shutdown_both, ignored);
    outer_.next_layer().close(ignored);
    inner_.close(ignored);
  }

  const std::shared_ptr<State> listener_;
  const std::shared_ptr<asio::ssl::context> tls_;
  asio::ssl::stream<ByteSocket> outer_;
  ByteSocket inner_;
  net::Timer limit_;
  std::shared_ptr<Guest> guest_;  // until the handshake has ended
  std::array<char, kBlock> received_, sent_;
};

TlsListener::TlsListener(std::shared_ptr<State> state) : state_(std::move(state)) {}
TlsListener::~TlsListener() {
  for (auto& listener : state_->listeners) listener->close();
}
uint16_t TlsListener::port() const { return state_->listeners.front()->port(); }

Result<std::unique_ptr<TlsListener>> TlsListener::listen(
    net::Loop& loop, const std::vector<std::string>& addresses, uint16_t port,
    const std::string& pem, GuestList& guests, net::Duration handshake,
    std::function<void(net::Socket)> on_connection) {
  auto state = std::shared_ptr<State>(
      new State{loop, guests, handshake, std::move(on_connection), nullptr, {}});
  using Tls = asio::ssl::context;
  state->tls = std::make_shared<Tls>(Tls::tls_server);
  error_code failed;
  state->tls->set_options(Tls::default_workarounds | Tls::no_sslv2 | Tls::no_sslv3 | Tls::no_tlsv1 |
                              Tls::no_tlsv1_1 | Tls::no_compression | SSL_OP_NO_RENEGOTIATION,
                          failed);
  if (!failed) state->tls->use_certificate_chain(asio::buffer(pem), failed);
  if (!failed) state->tls->use_private_key(asio::buffer(pem), Tls::pem, failed);
  if (failed) return Error{"the certificate cannot be used (" + failed.message() + ")"};
  for (const std::string& address : addresses) {
    auto listener = std::make_unique<net::Listener>(loop);
    if (const Status listening = listener->listen(address, port); !listening)
      return Error{"cannot listen on port " + std::to_string(port) + " of " + address + " (" +
                   listening.error() + ")"};
    port = listener->port();
    listener->start([here = std::weak_ptr<State>(state)](net::Socket socket) {
      if (const auto there = here.lock())
        std::make_shared<State::Link>(std::move(socket), there)->begin();
    });
    state->listeners.push_back(std::move(listener));
  }
  return std::unique_ptr<TlsListener>(new TlsListener(std::move(state)));
}

}  // namespace kibori::studio
