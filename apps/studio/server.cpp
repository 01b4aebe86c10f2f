// SPDX-License-Identifier: MIT
#include "apps/studio/server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <optional>
#include <random>
#include <set>
#include <string_view>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "apps/studio/bundle.h"
#include "apps/studio/chunks.h"
#include "apps/studio/messages.h"

namespace kibori::studio {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using Request = http::request<http::string_body>;
using Response = http::response<http::span_body<const char>>;

constexpr auto kFollowEvery = std::chrono::milliseconds(6);
constexpr auto kStateEvery = std::chrono::milliseconds(50);
constexpr size_t kFrameBytes = 400000;  // a frame of chunks is about this large
// Ticks are left out for a page that has not read so much of what was sent before.
constexpr size_t kTicksWait = 400000;

std::string random_hex() {
  std::random_device random;
  std::string text;
  for (int i = 0; i < 8; i++) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(random()));
    text += digits;
  }
  return text;
}

// Takes as long whatever is alike.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differ = 0;
  for (size_t i = 0; i < a.size(); i++)
    differ |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differ == 0;
}

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

// The value of a cookie; empty where there is none.
std::string_view cookie(std::string_view all, std::string_view name) {
  while (!all.empty()) {
    const size_t end = std::min(all.find(';'), all.size());
    std::string_view one = all.substr(0, end);
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    if (one.size() > name.size() && one.substr(0, name.size()) == name && one[name.size()] == '=')
      return one.substr(name.size() + 1);
    all.remove_prefix(std::min(end + 1, all.size()));
  }
  return {};
}

const char* mime(std::string_view path) {
  const auto ends = [&](std::string_view end) {
    return path.size() >= end.size() && path.substr(path.size() - end.size()) == end;
  };
  if (ends(".html")) return "text/html; charset=utf-8";
  if (ends(".js")) return "text/javascript; charset=utf-8";
  if (ends(".css")) return "text/css; charset=utf-8";
  if (ends(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

struct Later {
  bool operator()(const Index3& a, const Index3& b) const {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  }
};

class Page;

}  // namespace

struct Server::State {
  State(Studio& s, const Limits& l) : studio(s), limits(l), acceptor(io), timer(io) {}

  void accept();
  void follow();
  void hold(Page* page);
  void hear(Page& page, const FromPage& message);

  Studio& studio;
  const Limits limits;
  std::string token = random_hex(), secret = random_hex();
  std::string host, local_host;  // as a browser names this server
  std::string cookie_name;
  int connections = 0;
  std::set<Page*> pages;  // that said hello
  Page* holder = nullptr;
  double ticks_sent = 0;
  Clock::time_point state_at{};
  std::function<bool()> stop;
  // Gone first, and with it the pages that wait for something, which know the rest.
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer timer;
};

namespace {

// Counts a connection while it is there.
struct Counted {
  explicit Counted(int& c) : count(c) { count++; }
  ~Counted() { count--; }
  Counted(const Counted&) = delete;
  int& count;
};

// One page that is open.
class Page : public std::enable_shared_from_this<Page> {
 public:
  Page(beast::tcp_stream stream, Server::State& server, std::shared_ptr<Counted> counted)
      : socket_(std::move(stream)), server_(server), counted_(std::move(counted)), first_(server.io) {}
  ~Page() {
    server_.pages.erase(this);
    if (server_.holder == this) server_.holder = nullptr;
  }

  void accept(const Request& request) {
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.idle_timeout = std::chrono::seconds(30);
    timeout.keep_alive_pings = true;
    socket_.set_option(timeout);
    socket_.read_message_max(server_.limits.message_bytes);
    socket_.binary(true);
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code failed) {
      if (failed) return;
      // Who says nothing has no place here.
      self->first_.expires_after(std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(self->server_.limits.header_s)));
      self->first_.async_wait([self](beast::error_code stopped) {
        if (!stopped && !self->greeted_) self->drop();
      });
      self->read();
    });
  }

  void send(std::vector<uint8_t> message) {
    if (closed_) return;
    waiting_bytes_ += message.size();
    if (waiting_bytes_ > server_.limits.waiting_bytes) return drop();
    queue_.push_back(std::move(message));
    if (queue_.size() == 1) write();
  }
  void notice(const std::string& text) { send(encode(Notice{text})); }

  // Chunks of the surface that are not as they were when this page got them.
  void changed(const std::vector<Index3>& chunks) { dirty_.insert(chunks.begin(), chunks.end()); }
  void all_changed() {
    const Index3 count = surface_chunks(server_.studio.lattice());
    for (int x = 0; x < count.x(); x++)
      for (int y = 0; y < count.y(); y++)
        for (int z = 0; z < count.z(); z++)
          if (!server_.studio.surface().chunk({x, y, z}).triangles.empty()) dirty_.insert(Index3(x, y, z));
  }
  void offer_chunks() {
    if (dirty_.empty() || frame_ != got_) return;
    Chunks frame;
    while (!dirty_.empty() && frame.data.size() < kFrameBytes) {
      const Index3 at = *dirty_.begin();
      dirty_.erase(dirty_.begin());
      put_chunk(frame.data, server_.studio.surface().chunk(at), at, server_.studio.lattice());
    }
    frame.frame = ++frame_;
    frame.more = !dirty_.empty();
    send(encode(frame));
  }
  size_t waiting_bytes() const { return waiting_bytes_; }
  void got(uint32_t frame) {
    if (frame == frame_) got_ = frame;
  }

 private:
  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code failed, size_t) {
      if (failed) return self->leave();
      const auto data = self->buffer_.cdata();
      const std::optional<FromPage> message =
          self->socket_.got_binary() ? decode<FromPage>(static_cast<const uint8_t*>(data.data()), data.size())
                                     : std::nullopt;
      self->buffer_.consume(self->buffer_.size());
      if (!message) return self->drop();
      if (!self->greeted_) {
        const auto* const hello = std::get_if<Hello>(&*message);
        if (!hello) return self->drop();
        if (hello->version != kProtocolVersion) {
          self->notice("this page is of another version of Kibori; reload it");
        } else {
          self->greet();
        }
      } else {
        self->server_.hear(*self, *message);
      }
      if (!self->closed_) self->read();
    });
  }

  void greet() {
    greeted_ = true;
    first_.cancel();
    server_.pages.insert(this);
    if (!server_.holder) server_.hold(this);
    const Lattice& lattice = server_.studio.lattice();
    send(encode(Welcome{kProtocolVersion, lattice.origin_mm, lattice.nodes.matrix().cast<double>(),
                        lattice.pitch_mm, server_.studio.rate_hz(), server_.studio.document_name()}));
    all_changed();
  }

  void write() {
    socket_.async_write(asio::buffer(queue_.front()),
                        [self = shared_from_this()](beast::error_code failed, size_t) {
                          if (failed) return self->leave();
                          self->waiting_bytes_ -= self->queue_.front().size();
                          self->queue_.pop_front();
                          if (!self->queue_.empty() && !self->closed_) self->write();
                        });
  }

  void drop() {
    leave();
    beast::get_lowest_layer(socket_).close();
  }
  void leave() {
    closed_ = true;
    first_.cancel();
    server_.pages.erase(this);
    if (server_.holder == this) server_.hold(nullptr);
  }

  websocket::stream<beast::tcp_stream> socket_;
  Server::State& server_;
  std::shared_ptr<Counted> counted_;
  asio::steady_timer first_;
  beast::flat_buffer buffer_;
  std::deque<std::vector<uint8_t>> queue_;
  size_t waiting_bytes_ = 0;
  std::set<Index3, Later> dirty_;
  uint32_t frame_ = 0, got_ = 0;
  bool greeted_ = false, closed_ = false;
};

// One connection, while it asks for files.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(tcp::socket socket, Server::State& server)
      : stream_(std::move(socket)),
        server_(server),
        counted_(std::make_shared<Counted>(server.connections)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(8192);
    parser_->body_limit(0);
    stream_.expires_after(
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(server_.limits.header_s)));
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code failed, size_t) {
                       if (failed) return self->close();
                       self->answer();
                     });
  }

 private:
  void answer() {
    const Request& request = parser_->get();
    const std::string_view target = view(request.target());
    const std::string_view host = view(request[http::field::host]);
    // A name that leads here from elsewhere is not ours.
    if (request.count(http::field::host) != 1 || (host != server_.host && host != server_.local_host))
      return say(http::status::misdirected_request, "this is not the server that was asked for\n");
    const std::string_view origin = view(request[http::field::origin]);
    const bool own = origin.substr(0, 7) == "http://" && origin.substr(7) == host;
    if (request.count(http::field::origin) != 0 && !own)
      return say(http::status::forbidden, "asked for by another site\n");
    if (request.method() != http::verb::get) return say(http::status::method_not_allowed, "only GET\n");
    constexpr std::string_view kToken = "/?token=";
    if (target.substr(0, kToken.size()) == kToken) {
      if (!same(target.substr(kToken.size()), server_.token))
        return say(http::status::forbidden,
                   "the token is another one; use the address that 'kibori studio' printed\n");
      return let_in();
    }
    if (!same(cookie(view(request[http::field::cookie]), server_.cookie_name), server_.secret))
      return say(http::status::forbidden, "open the address that 'kibori studio' printed, with its token\n");
    if (target == "/ws") {
      if (!websocket::is_upgrade(request)) return say(http::status::upgrade_required, "a WebSocket\n");
      if (!own) return say(http::status::forbidden, "asked for by another site\n");
      stream_.expires_never();
      std::make_shared<Page>(std::move(stream_), server_, std::move(counted_))->accept(request);
      return;
    }
    const std::string_view path = target == "/" ? std::string_view("/index.html") : target;
    for (const BundledFile& file : bundle())
      if (path == file.path)
        return say(http::status::ok, {reinterpret_cast<const char*>(file.data), file.size}, mime(path));
    say(http::status::not_found, "there is no such file\n");
  }

  void let_in() {
    response_ = {};
    response_.result(http::status::see_other);
    response_.set(http::field::location, "/");
    response_.set(http::field::set_cookie,
                  server_.cookie_name + "=" + server_.secret + "; HttpOnly; SameSite=Strict; Path=/");
    write({});
  }

  void say(http::status status, std::string_view body, const char* type = "text/plain; charset=utf-8") {
    response_ = {};
    response_.result(status);
    response_.set(http::field::content_type, type);
    write(body);
  }

  // `body` lives as long as the program.
  void write(std::string_view body) {
    response_.version(11);
    response_.set(
        "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: "
        "blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Cross-Origin-Opener-Policy", "same-origin");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set(http::field::cache_control, "no-store");
    response_.keep_alive(parser_->get().keep_alive() && response_.result() == http::status::ok);
    response_.body() = {body.data(), body.size()};
    response_.prepare_payload();
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code failed, size_t) {
      if (failed || !self->response_.keep_alive()) return self->close();
      self->read();
    });
  }

  void close() {
    beast::error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.close();
  }

  beast::tcp_stream stream_;
  Server::State& server_;
  std::shared_ptr<Counted> counted_;
  beast::flat_buffer buffer_{16384};
  std::optional<http::request_parser<http::string_body>> parser_;
  Response response_;
};

Result<Tool> tool_of(const ChooseTool& chosen) {
  switch (chosen.shape) {
    case 0:
      return Tool(BallTool{chosen.size});
    case 1:
      return Tool(Finger{chosen.size, chosen.length});
    case 2:
      return Tool(Flat{chosen.size, chosen.length});
    case 3:
      return Tool(Capsule{chosen.size, chosen.length});
    default:
      return Error{"there is no such tool"};
  }
}

}  // namespace

void Server::State::accept() {
  acceptor.async_accept([this](beast::error_code failed, tcp::socket socket) {
    if (failed == asio::error::operation_aborted) return;
    // One too many is closed at once.
    if (!failed && connections < limits.connections) {
      beast::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Visit>(std::move(socket), *this)->read();
    }
    accept();
  });
}

void Server::State::hold(Page* page) {
  if (holder != page) studio.lift();
  holder = page;
  state_at = {};
}

void Server::State::hear(Page& page, const FromPage& message) {
  if (const auto* const got = std::get_if<Got>(&message)) return page.got(got->frame);
  if (std::holds_alternative<TakeTool>(message)) return hold(&page);
  if (holder != &page) return;  // it only watches
  Status done = Ok{};
  if (const auto* const aim = std::get_if<Aim>(&message)) {
    studio.aim(aim->tip, aim->axis, !studio.pressed());
  } else if (const auto* const press = std::get_if<Press>(&message)) {
    studio.press(press->tip, press->axis, press->mode == 1 ? Mode::deposit : Mode::cut);
  } else if (std::holds_alternative<Lift>(message)) {
    studio.lift();
  } else if (std::holds_alternative<Cancel>(message)) {
    studio.cancel();
  } else if (std::holds_alternative<Undo>(message)) {
    studio.undo();
  } else if (std::holds_alternative<Redo>(message)) {
    studio.redo();
  } else if (const auto* const chosen = std::get_if<ChooseTool>(&message)) {
    const Result<Tool> tool = tool_of(*chosen);
    done = tool ? studio.choose_tool(tool.value()) : Status(Error{tool.error()});
  } else if (const auto* const spring = std::get_if<ChooseSpring>(&message)) {
    done = studio.choose_stiffness(spring->stiffness);
  }
  if (!done) page.notice(done.error());
}

void Server::State::follow() {
  if (stop && stop()) return io.stop();
  const std::vector<Index3>& changed = studio.follow();
  const std::vector<LiveTick>& ticks = studio.ticks();
  std::vector<uint8_t> felt;
  if (!ticks.empty() && !pages.empty()) {
    std::vector<float> rows;
    rows.reserve(9 * ticks.size());
    for (const LiveTick& tick : ticks)
      for (const Vec3& v : {tick.tool.tip, tick.computed.force, tick.computed.moment})
        for (int i = 0; i < 3; i++) rows.push_back(static_cast<float>(v[i]));
    Ticks message;
    message.start = ticks_sent;
    const auto* const raw = reinterpret_cast<const uint8_t*>(rows.data());
    message.data.assign(raw, raw + rows.size() * sizeof(float));
    felt = encode(message);
  }
  ticks_sent += static_cast<double>(ticks.size());
  const auto now = Clock::now();
  const bool state_due = now - state_at >= kStateEvery;
  std::string notice;
  if (state_due) {
    state_at = now;
    notice = studio.notice();
  }
  // A page that is let go of leaves the set.
  const std::vector<Page*> all(pages.begin(), pages.end());
  for (Page* const page : all) {
    if (!pages.count(page)) continue;
    page->changed(changed);
    page->offer_chunks();
    if (!felt.empty() && page->waiting_bytes() < kTicksWait) page->send(felt);
    if (!state_due) continue;
    const Studio::Place& place = studio.place();
    kibori::studio::State state;
    state.volume = studio.volume_mm3();
    state.removed = studio.removed_mm3();
    state.step = static_cast<uint32_t>(place.step);
    state.steps = static_cast<uint32_t>(place.steps);
    state.undo = place.undo;
    state.redo = place.redo;
    state.holds = page == holder;
    state.hash = hash_text(place.hash);
    page->send(encode(state));
    if (!notice.empty()) page->notice(notice);
    if (!place.trouble.empty()) page->notice(place.trouble);
  }
  timer.expires_after(kFollowEvery);
  timer.async_wait([this](beast::error_code failed) {
    if (!failed) follow();
  });
}

Result<std::unique_ptr<Server>> Server::listen(Studio& studio, uint16_t port, const Limits& limits) {
  auto state = std::make_unique<State>(studio, limits);
  beast::error_code failed;
  const tcp::endpoint here(asio::ip::make_address_v4("127.0.0.1"), port);
  state->acceptor.open(here.protocol(), failed);
  if (!failed) state->acceptor.set_option(asio::socket_base::reuse_address(true), failed);
  if (!failed) state->acceptor.bind(here, failed);
  if (!failed) state->acceptor.listen(asio::socket_base::max_listen_connections, failed);
  if (failed)
    return Error{"port " + std::to_string(port) + " can't be listened on (" + failed.message() +
                 "); give another one with --port"};
  const std::string number = std::to_string(state->acceptor.local_endpoint().port());
  state->host = "127.0.0.1:" + number;
  state->local_host = "localhost:" + number;
  state->cookie_name = "kibori_" + number;
  state->accept();
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}
Server::~Server() = default;
uint16_t Server::port() const { return state_->acceptor.local_endpoint().port(); }
std::string Server::url() const { return "http://" + state_->host + "/?token=" + state_->token; }

void Server::run(const std::function<bool()>& stop) {
  state_->stop = stop;
  state_->follow();
  state_->io.run();
}

}  // namespace kibori::studio
