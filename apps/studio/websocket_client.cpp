// SPDX-License-Identifier: MIT
#include "apps/studio/websocket_client.h"

#include <cstring>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include <kibori/base/hash.h>

#include "apps/studio/chunks.h"
#include "apps/studio/tool_message.h"

namespace kibori::studio {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr size_t kHelloBytes = 1024;    // the first message is no longer
constexpr size_t kFrameBytes = 400000;  // a frame of chunks is about this large
constexpr size_t kMaxLabelBytes = 200;  // of a step that a document may name as it likes

}  // namespace

WebSocketClient::WebSocketClient(beast::tcp_stream stream, Server::State& server,
                                 std::shared_ptr<Guest> guest)
    : socket_(std::move(stream)),
      server_(server),
      key_(random_hex()),
      guest_(std::move(guest)),
      first_(server.io) {
  guest_->leave_by([this] { drop(); });
}

WebSocketClient::~WebSocketClient() {
  server_.pages.erase(this);
  server_.imports.drop(this);
  if (server_.holder == this) server_.holder = nullptr;
}

void WebSocketClient::accept(const Request& request) {
  auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeout.idle_timeout = std::chrono::seconds(30);
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(kHelloBytes);
  socket_.binary(true);
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code failed) {
    if (failed) return;
    // Who says nothing has no place here.
    self->first_.expires_after(std::chrono::duration_cast<Server::State::Clock::duration>(
        std::chrono::duration<double>(self->server_.limits.header_s)));
    self->first_.async_wait([self](beast::error_code stopped) {
      if (!stopped && !self->greeted_) self->drop();
    });
    self->read();
  });
}

void WebSocketClient::send(std::vector<uint8_t> message) {
  if (closed_) return;
  waiting_bytes_ += message.size();
  if (waiting_bytes_ > server_.limits.waiting_bytes) return drop();
  queue_.push_back(std::move(message));
  if (queue_.size() == 1) write();
}

void WebSocketClient::restart() {
  dirty_.clear();
  sent_.clear();
  told_steps_ = 0;
  told_versions_.clear();
  method_.clear();
  if (!server_.session)
    return send(encode(Start{kProtocolVersion, server_.holder == this, server_.start_json(key_)}));
  Session& session = *server_.session;
  const Lattice& lattice = session.lattice();
  const nlohmann::json materials = materials_json(session.materials());
  send(encode(Welcome{kProtocolVersion, lattice.origin_mm, lattice.nodes.matrix().cast<double>(),
                      lattice.pitch_mm, session.rate_hz(),
                      std::filesystem::path(session.name()).filename().string(),
                      materials.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                      session.stock_material(),
                      static_cast<uint8_t>(session.experiment() ? 2
                                           : !session.live()    ? 1
                                                                : 0)}));
  server_.send_device(this);
  if (server_.shown) send(encode(*server_.shown));
  if (!server_.trace_sent.empty()) send(server_.trace_sent);
  const Index3 count = surface_chunks(lattice);
  for (int x = 0; x < count.x(); x++)
    for (int y = 0; y < count.y(); y++)
      for (int z = 0; z < count.z(); z++)
        if (!session.surface().chunk({x, y, z}).triangles.empty()) dirty_.insert(Index3(x, y, z));
  offer_history();
}

void WebSocketClient::offer_chunks() {
  if (dirty_.empty() || frame_ != got_) return;
  Chunks frame;
  while (!dirty_.empty() && frame.data.size() < kFrameBytes) {
    const Index3 at = *dirty_.begin();
    dirty_.erase(dirty_.begin());
    const size_t begin = frame.data.size();
    put_chunk(frame.data, server_.session->surface().chunk(at), at, server_.session->lattice());
    // What changed beneath may look the same.
    Hash hash;
    hash.add(frame.data.data() + begin, frame.data.size() - begin);
    if (std::exchange(sent_[at], hash.value()) == hash.value()) frame.data.resize(begin);
  }
  if (frame.data.empty() && !more_) return;
  frame.frame = ++frame_;
  frame.more = more_ = !dirty_.empty();
  send(encode(frame));
}

void WebSocketClient::offer_history() {
  const std::vector<PastStep>& steps = server_.session->steps();
  if (told_steps_ < steps.size()) {
    Steps message;
    Writer rows;
    for (; told_steps_ < steps.size(); told_steps_++) {
      const PastStep& step = steps[told_steps_];
      rows.put(static_cast<uint32_t>(step.id));
      rows.put(static_cast<uint32_t>(step.parent));
      rows.put(static_cast<float>(step.removed_mm3));
      rows.put(static_cast<double>(step.made_s));
      rows.put(tool_message(step.tool));
      rows.put(step.mode);
      rows.put(static_cast<uint8_t>(step.pictured ? 1 : 0));
      rows.put(step.label.substr(0, kMaxLabelBytes));
    }
    message.data = rows.take();
    send(encode(message));
  }
  if (told_versions_ == server_.session->versions()) return;
  told_versions_ = server_.session->versions();
  send(encode(Versions{nlohmann::json(told_versions_)
                           .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}));
}

void WebSocketClient::offer_method(MethodView::Clock::time_point now) {
  if (const std::optional<Method> said = method_.answer(server_.session->snapshot(), now))
    send(encode(*said));
}

void WebSocketClient::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code failed, size_t) {
    if (failed) return self->leave();
    const auto data = self->buffer_.cdata();
    const std::optional<FromPage> message =
        self->socket_.got_binary()
            ? decode<FromPage>(static_cast<const uint8_t*>(data.data()), data.size())
            : std::nullopt;
    self->buffer_.consume(self->buffer_.size());
    if (!message) return self->drop();
    if (!self->greeted_) {
      const auto* const hello = std::get_if<Hello>(&*message);
      if (!hello) return self->drop();
      if (!self->server_.door.is_key(hello->key))
        return self->refuse(websocket::close_code::policy_error);
      if (!self->guest_->welcome()) return self->refuse(websocket::close_code::try_again_later);
      if (hello->version != kProtocolVersion) {
        self->notify("this page is of another version of Kibori; reload it");
      } else {
        self->greet();
      }
    } else {
      self->server_.on_message(*self, *message);
    }
    if (!self->closed_) self->read();
  });
}

void WebSocketClient::greet() {
  greeted_ = true;
  first_.cancel();
  socket_.read_message_max(server_.limits.message_bytes);
  server_.pages.insert(this);
  server_.trouble_told.clear();
  if (!server_.holder) server_.hold(this);
  restart();
  send(encode(Work{server_.job.what(), server_.job.share(), server_.job.cancellable()}));
}

void WebSocketClient::write() {
  socket_.async_write(asio::buffer(queue_.front()),
                      [self = shared_from_this()](beast::error_code failed, size_t) {
                        if (failed) return self->leave();
                        self->waiting_bytes_ -= self->queue_.front().size();
                        self->queue_.pop_front();
                        if (!self->queue_.empty() && !self->closed_) self->write();
                      });
}

void WebSocketClient::refuse(websocket::close_code why) {
  leave();
  socket_.async_close(why, [self = shared_from_this()](beast::error_code) {});
}

void WebSocketClient::drop() {
  leave();
  beast::get_lowest_layer(socket_).close();
}
void WebSocketClient::leave() {
  closed_ = true;
  first_.cancel();
  server_.pages.erase(this);
  server_.imports.drop(this);
  if (server_.holder == this) server_.hold(nullptr);
}

}  // namespace kibori::studio
