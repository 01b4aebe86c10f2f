// SPDX-License-Identifier: MIT
#include "apps/studio/websocket_client.h"

#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include <kibori/base/hash.h>

#include "apps/studio/chunks.h"
#include "apps/studio/tool_message.h"

namespace kibori::studio {
namespace {

constexpr size_t kHelloBytes = 1024;    // max size of the first message
constexpr size_t kFrameBytes = 400000;  // approximate size of a frame of chunks
constexpr size_t kMaxLabelBytes = 200;  // of a step's label; documents set no limit

}  // namespace

WebSocketClient::WebSocketClient(std::unique_ptr<net::WebSocket> socket, Server::State& server,
                                 std::shared_ptr<Guest> guest,
                                 std::function<bool(std::string_view key)> admits)
    : socket_(std::move(socket)),
      first_(server.loop),
      server_(server),
      key_(random_hex()),
      guest_(std::move(guest)),
      admits_(std::move(admits)) {
  guest_->leave_by([this] { drop(); });
}

WebSocketClient::~WebSocketClient() {
  server_.pages.erase(this);
  server_.imports.drop(this);
  if (server_.holder == this) server_.holder = nullptr;
}

void WebSocketClient::accept() {
  socket_->max_message(kHelloBytes);
  socket_->accept([self = shared_from_this()](bool accepted) {
    if (!accepted) return;
    // Drop a connection that sends no Hello in time.
    self->first_.start(std::chrono::duration_cast<Server::State::Clock::duration>(
                           std::chrono::duration<double>(self->server_.limits.header_s)),
                       [self] {
                         if (!self->greeted_) self->drop();
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
  sent_bodies_ = 0;
  sent_list_.clear();
  wants_ = Map::none;
  map_.reset();
  shown_bodies_.clear();
  sent_steps_ = 0;
  sent_versions_.clear();
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
                      session.stock_material(), key_,
                      static_cast<uint8_t>(session.playback()     ? 3
                                           : session.experiment() ? 2
                                           : !session.live()      ? 1
                                                                  : 0)}));
  server_.send_device(this);
  if (server_.stamp) send(encode(*server_.stamp));
  if (server_.shown) send(encode(*server_.shown));
  for (const auto* const message :
       {&server_.trace_sent, &server_.playback_sent, &server_.played_sent})
    if (!message->empty()) send(*message);
  offer_bodies();
  offer_history();
}

void WebSocketClient::forget(BodyId body) {
  const auto mine = [body](const auto& all) {
    return std::pair{all.lower_bound({body, Index3::Constant(std::numeric_limits<int>::min())}),
                     all.upper_bound({body, Index3::Constant(std::numeric_limits<int>::max())})};
  };
  const auto [dirty, dirty_end] = mine(dirty_);
  dirty_.erase(dirty, dirty_end);
  const auto [sent, sent_end] = mine(sent_);
  sent_.erase(sent, sent_end);
}

void WebSocketClient::show(BodyId body) {
  const LiveSurface& surface = *server_.session->surface(body);
  const ChunkRange range = surface_chunks(server_.session->bodies().find(body)->model.lattice);
  for (int x = range.low.x(); x < range.high.x(); x++)
    for (int y = range.low.y(); y < range.high.y(); y++)
      for (int z = range.low.z(); z < range.high.z(); z++)
        if (!surface.chunk({x, y, z}).triangles.empty()) dirty_.insert({body, Index3(x, y, z)});
}

void WebSocketClient::offer_bodies() {
  const Session& session = *server_.session;
  if (std::exchange(sent_bodies_, session.bodies_revision()) == session.bodies_revision()) return;
  nlohmann::json list = nlohmann::json::array();
  for (const Body& body : session.bodies().all) {
    nlohmann::json pose = nlohmann::json::array();
    for (const double x : body.pose.tip) pose.push_back(x);
    for (const double x : body.pose.frame.reshaped()) pose.push_back(x);
    list.push_back({{"id", body.id},
                    {"name", body.name},
                    {"pose", std::move(pose)},
                    {"visible", body.visible},
                    {"locked", body.locked},
                    {"no_go", body.no_go},
                    {"volume_mm3", session.volume_mm3(body.id)}});
  }
  const std::string json = list.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  follow_map();
  std::string list_text = std::to_string(session.active()) + json;
  if (list_text == sent_list_) return;
  sent_list_ = std::move(list_text);
  send(encode(kibori::studio::Bodies{static_cast<uint32_t>(session.active()), json}));
  std::map<BodyId, Pose> shown;
  for (const Body& body : session.bodies().all)
    if (body.visible) shown[body.id] = body.pose;
  const auto has = [](const std::map<BodyId, Pose>& all, BodyId id, const Pose& pose) {
    const auto found = all.find(id);
    return found != all.end() && found->second.tip == pose.tip && found->second.frame == pose.frame;
  };
  for (const auto& [id, pose] : shown_bodies_)
    if (!has(shown, id, pose)) forget(id);
  for (const auto& [id, pose] : shown)
    if (!has(shown_bodies_, id, pose)) show(id);
  shown_bodies_ = std::move(shown);
}

void WebSocketClient::offer_chunks() {
  if (dirty_.empty() || frame_ != got_) return;
  Chunks frame;
  frame.body = static_cast<uint32_t>(dirty_.begin()->body);
  while (!dirty_.empty() && frame.data.size() < kFrameBytes) {
    const Session::ChunkPlace at = *dirty_.begin();
    if (!frame.data.empty() && static_cast<uint32_t>(at.body) != frame.body) break;
    frame.body = static_cast<uint32_t>(at.body);
    dirty_.erase(dirty_.begin());
    const LiveSurface* const surface = server_.session->surface(at.body);
    if (!surface || !shown_bodies_.count(at.body)) continue;
    const size_t begin = frame.data.size();
    const SurfaceChunk& chunk = surface->chunk(at.at);
    const Lattice& lattice = server_.session->lattice();
    if (map_ && map_->body() == at.body)
      put_chunk(frame.data, map_->paint(chunk, at.at), at.at, lattice);
    else
      put_chunk(frame.data, chunk, at.at, lattice);
    // A changed chunk may look the same. Send only visible changes.
    Hash hash;
    hash.add(frame.data.data() + begin, frame.data.size() - begin);
    if (std::exchange(sent_[at], hash.value()) == hash.value()) frame.data.resize(begin);
  }
  if (frame.data.empty() && !more_) return;
  frame.frame = ++frame_;
  frame.more = more_ = !dirty_.empty();
  send(encode(frame));
  if (!map_ || more_) return;
  std::vector<uint8_t> message = map_->message(active_volume_mm3());
  if (message == sent_map_) return;
  sent_map_ = message;
  send(std::move(message));
}

void WebSocketClient::show_remains(bool shown) {
  wants_ = shown ? Map::remains : Map::none;
  repaint();
}

void WebSocketClient::show_faults(bool shown, const PrintCheckOptions& options) {
  wants_ = shown ? Map::faults : Map::none;
  print_ = options;
  repaint();
}

double WebSocketClient::active_volume_mm3() const {
  const Session& session = *server_.session;
  double volume = session.volume_mm3();
  for (const Body& body : session.bodies().all)
    if (body.id != session.active()) volume -= session.volume_mm3(body.id);
  return volume;
}

void WebSocketClient::follow_map() {
  Session& session = *server_.session;
  if (!map_ && wants_ == Map::none) return;
  if (map_ && map_->is_of(session.bodies(), session.active(), session.history().step)) return;
  repaint();
}

void WebSocketClient::repaint() {
  if (!server_.session) return;
  Session& session = *server_.session;
  const std::unique_ptr<SurfaceMap> before = std::move(map_);
  if (wants_ == Map::remains)
    map_ = RemainsMap::make(session.bodies(), session.active(), *session.surface(session.active()),
                            active_volume_mm3());
  else if (wants_ == Map::faults)
    map_ = std::make_unique<PrintMap>(session.active_body(), print_, session.history().step);
  sent_map_.clear();
  if (wants_ == Map::remains && !map_) send(encode(Remains{}));
  for (const SurfaceMap* const map : {before.get(), map_.get()})
    if (map && session.surface(map->body()) && shown_bodies_.count(map->body())) show(map->body());
}

void WebSocketClient::offer_history() {
  const std::vector<PastStep>& steps = server_.session->steps();
  if (sent_steps_ < steps.size()) {
    Steps message;
    Writer rows;
    for (; sent_steps_ < steps.size(); sent_steps_++) {
      const PastStep& step = steps[sent_steps_];
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
  if (sent_versions_ == server_.session->versions()) return;
  sent_versions_ = server_.session->versions();
  send(encode(Versions{nlohmann::json(sent_versions_)
                           .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}));
}

void WebSocketClient::offer_method(MethodView::Clock::time_point now) {
  if (const std::optional<Method> message = method_.answer(server_.session->snapshot(), now))
    send(encode(*message));
}

void WebSocketClient::read() {
  socket_->read([self = shared_from_this()](std::optional<net::WebSocketMessage> frame) {
    if (!frame) return self->leave();
    const std::optional<FromPage> message =
        frame->binary ? decode<FromPage>(frame->bytes.data(), frame->bytes.size()) : std::nullopt;
    if (!message) return self->drop();
    if (!self->greeted_) {
      const auto* const hello = std::get_if<Hello>(&*message);
      if (!hello) return self->drop();
      if (!self->admits_(hello->key)) return self->refuse(net::kClosePolicy);
      if (!self->guest_->welcome()) return self->refuse(net::kCloseTryLater);
      if (hello->version != kProtocolVersion) {
        self->notify("this page belongs to another version of Kibori; reload it");
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
  socket_->max_message(server_.limits.message_bytes);
  server_.pages.insert(this);
  server_.sent_error.clear();
  if (!server_.holder) server_.hold(this);
  restart();
  send(encode(Work{server_.job.what(), server_.job.share(), server_.job.cancellable()}));
}

void WebSocketClient::write() {
  socket_->write(queue_.front(), [self = shared_from_this()](bool sent) {
    if (!sent) return self->leave();
    self->waiting_bytes_ -= self->queue_.front().size();
    self->queue_.pop_front();
    if (!self->queue_.empty() && !self->closed_) self->write();
  });
}

void WebSocketClient::refuse(uint16_t why) {
  leave();
  socket_->close(why, [self = shared_from_this()] {});
}

void WebSocketClient::drop() {
  leave();
  socket_->drop();
}
void WebSocketClient::leave() {
  closed_ = true;
  first_.cancel();
  server_.pages.erase(this);
  server_.imports.drop(this);
  if (server_.holder == this) server_.hold(nullptr);
}

}  // namespace kibori::studio
