// SPDX-License-Identifier: MIT
#include "apps/studio/server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <vector>

#include <nlohmann/json.hpp>

#include <kibori/base/hash.h>
#include <kibori/run/carving.h>
#include <kibori/document/document.h>
#include <kibori/document/rescue.h>
#include <kibori/haptics/materials.h>
#include <kibori/picture/picture.h>
#include <kibori/run/salvage.h>
#include "apps/studio/session/stock_scene.h"

#include "apps/studio/certificate.h"
#include "apps/studio/examples.h"
#include "apps/studio/websocket_client.h"
#include "apps/studio/tool_message.h"
#include "apps/studio/trace.h"
#include "apps/studio/http_connection.h"

namespace kibori::studio {
namespace {

constexpr size_t kTickNumbers = 15;  // tip, force, moment, axis, side
constexpr auto kFollowEvery = std::chrono::milliseconds(2);
constexpr auto kStateEvery = std::chrono::milliseconds(50);
// Ticks are sent in batches, about once per frame of the display.
constexpr auto kTicksEvery = std::chrono::milliseconds(15);
constexpr auto kWorkEvery = std::chrono::milliseconds(200);
constexpr double kPendingNotice = 0.01;  // [mm^3]; for pressed clay that found no room
// Threshold for reporting loose material [mm^3].
constexpr double kFallenNotice = 1;
constexpr auto kErrorInterval = std::chrono::seconds(15);  // leaves time to read other notices
// A page that has more unread bytes gets no ticks.
constexpr size_t kTicksWait = 400000;

// Returns a sentence on why a brush's stroke of this mode changed nothing.
std::string idle_notice(Mode mode) {
  switch (mode) {
    case Mode::fill:
      return "There is no hollow under the brush, so Fill changed nothing. Inflate raises any "
             "place.";
    case Mode::rasp:
      return "There is no peak under the brush, so Rasp changed nothing. Inflate with a negative "
             "strength lowers any place.";
    case Mode::trim:
      return "Trim changed nothing: nothing is above the plane there, or the strength is 0.";
    case Mode::flatten:
      return "Flatten changed nothing: it is flat there, or the strength is 0.";
    default:
      return "Smooth changed nothing: it is smooth there, or the strength is 0.";
  }
}

}  // namespace

// Ends the session first, because it uses the other members. Pending results are dropped.
Server::State::~State() { session.reset(); }

void Server::State::send(const std::vector<uint8_t>& message) {
  // A copy, because send() removes disconnected pages from `pages`.
  const std::vector<WebSocketClient*> all(pages.begin(), pages.end());
  for (WebSocketClient* const page : all)
    if (pages.count(page)) page->send(message);
}

void Server::State::notify(const std::string& text) { send(encode(Notice{text})); }

void Server::State::hold(WebSocketClient* page) {
  if (holder != page && live()) live()->lift();
  holder = page;
  state_at = {};
}

// ---- Documents

void Server::State::show(std::unique_ptr<Session> opened) {
  session = std::move(opened);
  if (session) imports.drop_all();
  update_publisher();
  ticks_sent = 0;
  tick_rows.clear();
  second_tick.reset();
  second_hand_sent = false;
  traced = false;
  shown.reset();
  stamp.reset();
  trace_sent.clear();
  playback_sent.clear();
  played_sent.clear();
  state_at = {};
  const std::vector<WebSocketClient*> all(pages.begin(), pages.end());
  for (WebSocketClient* const page : all)
    if (pages.count(page)) page->restart();
}

void Server::State::update_publisher() {
  if (!publisher) return;
  if (!live()) return publisher->about({"", "", 0, {}, {}});
  const HapticDeviceState* const device = haptic_device();
  publisher->about({std::filesystem::path(session->name()).filename().string(),
                    device ? device->name : "a pointer", session->rate_hz(), session->lattice(),
                    session->materials()});
}

void Server::State::work(const std::string& what,
                         std::function<Job::Then(std::atomic<double>&)> work, bool cancellable) {
  job.start(what, cancellable,
            [this, work = std::move(work)](std::atomic<double>& share) -> Job::Then {
              return [this, then = work(share)](bool wanted) {
                if (wanted) send_work();
                then(wanted);
              };
            });
  send_work();
}

void Server::State::send_work() {
  work_at = Clock::now();
  send(encode(Work{job.what(), job.share(), job.cancellable()}));
}

Status Server::State::open(
    const std::string& what, const std::filesystem::path& fresh,
    std::function<Result<std::unique_ptr<Session>>(std::atomic<double>&)> make,
    std::function<void(const Status&)> done) {
  if (session) return Error{"a document is already open; close it first"};
  if (how.read_only && !fresh.empty())
    return Error{"this studio is read-only; to begin a new document, start it without --read-only"};
  if (job.busy()) return Error{"another job is running; wait for it, or cancel it"};
  work(what,
       [this, fresh, make = std::move(make),
        done = std::move(done)](std::atomic<double>& share) -> Job::Then {
         // Shared, because a std::function must be copyable.
         const auto made = std::make_shared<Result<std::unique_ptr<Session>>>(make(share));
         return [this, made, fresh, done](bool wanted) {
           if (wanted && *made) {
             show(std::move(*made).value());
             if (done) done(Ok{});
             return;
           }
           if (done)
             done(Error{wanted ? made->error() : ""});
           else if (wanted)
             notify(made->error());
           const bool ours = made->ok();  // else the file may be older, and stays
           *made = Error{""};             // close it before removing it
           if (ours && !fresh.empty()) remove_document(fresh);
         };
       });
  return Ok{};
}

void Server::State::begin(WebSocketClient& page, const Begin& begin) {
  const Vec3& size = begin.size;
  const StockShape shapes[] = {StockBlock{size}, StockCylinder{size.x(), size.z()},
                               StockSphere{size.x()}};
  if (begin.shape >= std::size(shapes))
    return page.notify("this stock is unknown; reload the page");
  Result<Scene> scene = stock_scene(shapes[begin.shape], begin.pitch, begin.material);
  if (!scene) return page.notify(scene.error());
  const Result<std::filesystem::path> place = library.place_for(begin.name);
  if (!place) return page.notify(place.error());
  const Status opened =
      open("Making the stock", place.value(),
           [scene = std::move(scene).value(), to = place.value(),
            options = how](std::atomic<double>&) { return create_session(to, scene, options); });
  if (!opened) page.notify(opened.error());
}

void Server::State::open_named(WebSocketClient& page, const std::string& name) {
  const Result<std::filesystem::path> path = library.find(name);
  if (!path) return page.notify(path.error());
  const Status opened = open(
      "Opening " + sanitize_message(name), {},
      [from = path.value(), how = how](std::atomic<double>&) { return open_session(from, how); });
  if (!opened) page.notify(opened.error());
}

void Server::State::carve_example(WebSocketClient& page, const std::string& name) {
  for (const Example& example : examples()) {
    if (example.name != name) continue;
    Result<Scene> scene = parse_scene(example.scene, name, std::nullopt);
    if (!scene) return page.notify(scene.error());
    const Result<std::filesystem::path> place = library.place_for(name);
    if (!place) return page.notify(place.error());
    const Status opened = open("Carving the example", place.value(),
                               [scene = std::move(scene).value(), to = place.value(), how = how](
                                   std::atomic<double>& share) -> Result<std::unique_ptr<Session>> {
                                 CarveOptions options;
                                 options.document = to;
                                 options.progress = [&share](double done) { share = done; };
                                 const Result<Carving> carved = carve(scene, options);
                                 if (!carved) return Error{carved.error()};
                                 if (!carved.value().unsaved.empty())
                                   return Error{carved.value().unsaved};
                                 return open_session(to, how);
                               });
    if (!opened) page.notify(opened.error());
    return;
  }
  page.notify("this example is unknown; reload the page");
}

void Server::State::change_detail(WebSocketClient& page, const ChangeDetail& change) {
  const Result<std::filesystem::path> from = library.find(change.document);
  if (!from) return page.notify(from.error());
  const Result<std::filesystem::path> place = library.place_for(change.document);
  if (!place) return page.notify(place.error());
  const Status opened =
      open("Carving it with another pitch", place.value(),
           [from = from.value(), to = place.value(), pitch = change.pitch,
            how = how](std::atomic<double>& share) -> Result<std::unique_ptr<Session>> {
             const auto document = Document::open(from, Document::Access::read);
             if (!document) return Error{document.error()};
             const Index3 nodes = document.value()->lattice().nodes;
             const double finer = document.value()->lattice().pitch_mm / pitch;
             if (!(finer * nodes.maxCoeff() <= 1.25 * kMaxRays))
               return Error{"this is too fine: the longest side may have at most " +
                            std::to_string(static_cast<int>(1.25 * kMaxRays)) + " rays"};
             if (!(finer * nodes.minCoeff() >= 8))
               return Error{"this is too coarse: the shortest side needs at least 8 rays"};
             CarveOptions options;
             options.progress = [&share](double done) { share = done; };
             const Result<StepId> carved = carve_again(*document.value(), to, pitch, options);
             if (!carved) return Error{carved.error()};
             return open_session(to, how);
           });
  if (!opened) page.notify(opened.error());
}

void Server::State::run_experiment(WebSocketClient& page, const RunExperiment& run) {
  Result<Scene> scene = parse_scene(run.scene, sanitize_message(run.name), std::nullopt);
  if (!scene) return page.notify(scene.error());
  Scene& s = scene.value();
  const double longest = size_mm(s.stock.shape).maxCoeff(),
               room = s.stock.room_mm.value_or(0.1 * longest);
  if (!((longest + 2 * room) / s.stock.pitch_mm <= 1.25 * kMaxRays))
    return page.notify(
        "the studio cannot show a scene this fine: its longest side may have at most " +
        std::to_string(static_cast<int>(kMaxRays)) + " rays; use a coarser pitch or less room");
  if (!run.model.empty()) {
    const std::optional<ForceModel> model = value_of<ForceModel>(run.model);
    if (!model) return page.notify("this force model is unknown; reload the page");
    if (*model == ForceModel::series && !s.force.series()) s.force.spring = spring_of_hand();
    s.force.spring.tick_s = 1 / s.rate_hz;
    s.force.law.model = *model;
  }
  const double pace = run.pace > 0 ? std::clamp(run.pace, 0.01, 100.0) : 0;
  const Status opened =
      open("Making the stock", {}, [scene = std::move(s), pace](std::atomic<double>&) {
        return ExperimentSession::start(scene, pace);
      });
  if (!opened) page.notify(opened.error());
}

void Server::State::show_tool(const Tool& tool) {
  stamp = stamp_message(tool);
  if (stamp) send(encode(*stamp));
  send(encode(shown.emplace(ShowTool{tool_message(tool)})));
}

void Server::State::follow_experiment() {
  ExperimentSession& run = *session->experiment();
  if (Tool now; run.next_tool(now)) show_tool(now);
  if (traced) return;
  const Result<Carving>* const outcome = run.outcome();
  if (!outcome) {
    if (!job.busy() && Clock::now() - work_at >= kWorkEvery) {
      work_at = Clock::now();
      send(encode(Work{"Carving", run.share(), 1}));
    }
    return;
  }
  traced = true;
  if (!job.busy()) send(encode(Work{}));
  if (!*outcome) return notify(outcome->error());
  trace_sent = encode(trace_of(run, outcome->value()));
  send(trace_sent);
}

void Server::State::leave(WebSocketClient& page) {
  if (job.busy()) return page.notify("another job is running; wait for it, or cancel it");
  const auto closing = std::make_shared<std::unique_ptr<Session>>(std::move(session));
  work(
      "Saving",
      [this, closing, left = left_unsaved](std::atomic<double>&) -> Job::Then {
        const std::string where = (*closing)->close();
        closing->reset();
        // Server::close() reports it again, because no page may be open when this job ends.
        if (!where.empty()) *left += (left->empty() ? "" : "\n") + where;
        return [this, where](bool) {
          show(nullptr);
          if (!where.empty()) notify(where);
        };
      },
      false);
}

WebSocketClient* Server::State::page_of(const std::string& key) const {
  for (WebSocketClient* const page : pages)
    if (page->key() == key) return page;
  return nullptr;
}

nlohmann::json materials_json(const std::vector<Material>& materials) {
  nlohmann::json json = nlohmann::json::array();
  for (const Material& m : materials)
    json.push_back({{"name", m.name},
                    {"color", m.color},
                    {"rings", ring_contrast(m.name)},
                    {"log",
                     {{"ring", m.log.ring_mm},
                      {"axis", {m.log.axis.x(), m.log.axis.y(), m.log.axis.z()}},
                      {"pith", {m.log.pith.x(), m.log.pith.y(), m.log.pith.z()}}}},
                    {"grain", has_grain(m)},
                    {"law", law_text(m)}});
  return json;
}

std::string Server::State::start_json(const std::string& key) const {
  nlohmann::json documents = nlohmann::json::array(), scenes = documents;
  for (const Library::Entry& entry : library.list())
    documents.push_back(
        {{"name", entry.name}, {"changed", entry.changed_s}, {"bytes", entry.bytes}});
  for (const Example& example : examples())
    scenes.push_back({{"name", example.name}, {"about", example.about}});
  return nlohmann::json{{"documents", documents},
                        {"materials", materials_json(known_materials())},
                        {"examples", scenes},
                        {"page", key}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// ---- Messages to pages

void Server::State::send_ticks() {
  // Ticks have the device's share of the wood's force. Pages get the whole force.
  const HapticDeviceState* const device = haptic_device();
  const double wood = device ? 1 / device->share : 1;
  double pending = 0, fallen = 0;
  int parted = 0;
  bool gave_up = false, clipped = false;
  std::optional<Mode> idle;
  std::vector<MethodView*> views;
  for (WebSocketClient* const page : pages)
    if (page->method().watching()) views.push_back(&page->method());
  const bool publishes = publisher && live();
  for (const LiveTick& tick : session->ticks()) {
    if (publishes) publisher->add(tick);
    for (MethodView* const view : views) view->add(tick, wood);
    pending += tick.pending_mm3;
    fallen += tick.fallen_mm3;
    parted += tick.parted;
    gave_up |= tick.gave_up;
    if (tick.idle_brush) idle = tick.idle_brush;
    clipped |= tick.clipped || (tick.second && tick.second->clipped);
    if (tick.second) second_tick = tick.second;
    for (const Vec3& v :
         {tick.tool.tip, Vec3(wood * tick.computed.force), Vec3(wood * tick.computed.moment),
          tick.tool.axis(), Vec3(tick.tool.frame.col(0))})
      for (int i = 0; i < 3; i++) tick_rows.push_back(static_cast<float>(v[i]));
  }
  if (publishes) publisher->flush();
  if (gave_up)
    notify(
        "The stroke ended early: this machine has too little memory or is too slow for this brush. "
        "Use a smaller one.");
  // No notice for a force device, because its hand often moves over the piece without touching it.
  if (idle && !device) notify(idle_notice(*idle));
  if (clipped && Clock::now() - clipped_at > kErrorInterval) {
    clipped_at = Clock::now();
    notify(
        "Material reached the largest size of a model, 8192 cells along an axis. The part beyond "
        "it "
        "is left out. Use a coarser pitch for a larger piece.");
  }
  if (pending > kPendingNotice) {
    char text[120];
    std::snprintf(
        text, sizeof text,
        "There was no room for %.3g mm³ of pressed clay, which is lost. Undo reverts the stroke.",
        pending);
    notify(text);
  }
  if (parted > 0)
    notify(parted == 1 ? "A piece came off. It is now a separate body; Undo restores it."
                       : std::to_string(parted) +
                             " pieces came off. They are now separate bodies; Undo restores them.");
  if (fallen > kFallenNotice) {
    char text[120];
    std::snprintf(text, sizeof text, "%.3g mm³ came loose and fell away. Undo restores it.",
                  fallen);
    notify(text);
  }
  const auto now = Clock::now();
  if (tick_rows.empty() || now - ticks_at < kTicksEvery) return;
  ticks_at = now;
  Ticks message;
  message.start = ticks_sent;
  const size_t ticks = tick_rows.size() / kTickNumbers;
  ticks_sent += static_cast<double>(ticks);
  const auto* const raw = reinterpret_cast<const uint8_t*>(tick_rows.data());
  message.data.assign(raw, raw + tick_rows.size() * sizeof(float));
  tick_rows.clear();
  const std::vector<uint8_t> ticks_message = encode(message), second = second_message();
  const std::vector<WebSocketClient*> all(pages.begin(), pages.end());
  for (WebSocketClient* const page : all) {
    if (pages.count(page) && page->waiting_bytes() < kTicksWait) page->send(ticks_message);
    if (pages.count(page) && !second.empty()) page->send(second);
  }
}

// The message about the second hand. Empty if there is no second hand and the last message said so.
std::vector<uint8_t> Server::State::second_message() {
  const Tool* const tool = session->second_tool();
  const bool there = tool && second_tick;
  if (!std::exchange(second_hand_sent, there) && !there) return {};
  SecondHand message;
  message.there = there;
  message.tool = tool_message(there ? std::optional<Tool>(*tool) : std::nullopt);
  if (!there) return encode(message);
  const HapticDeviceState* const device = live() ? live()->second_held() : nullptr;
  message.tip = second_tick->tool.tip;
  message.axis = second_tick->tool.axis();
  message.side = second_tick->tool.frame.col(0);
  message.force = second_tick->computed.force / (device ? device->share : 1);
  return encode(message);
}

void Server::State::send_state() {
  const HistoryState& place = session->history();
  const std::string notice = session->notice();
  kibori::studio::State state;
  state.volume = session->volume_mm3();
  state.removed = session->removed_mm3();
  state.step = static_cast<uint32_t>(place.step);
  state.steps = static_cast<uint32_t>(place.steps);
  state.undo = place.undo;
  state.redo = place.redo;
  state.hash = hash_text(place.hash);
  state.blocked = live() && live()->blocked();
  state.pending = live() ? live()->pending_s() : 0;
  if (const HapticDeviceState* const held = haptic_device()) {
    state.safety = static_cast<uint8_t>(held->safety);
    if (held->trip != Trip::none) state.trip = trip_text(held->trip);
    state.given = held->given_n;
  }
  const std::vector<WebSocketClient*> all(pages.begin(), pages.end());
  for (WebSocketClient* const page : all) {
    if (!pages.count(page)) continue;
    page->offer_history();
    state.holds = page == holder;
    page->send(encode(state));
  }
  if (!notice.empty()) notify(notice);
  if (place.write_error != sent_error || Clock::now() - error_sent_at > kErrorInterval) {
    sent_error = place.write_error;
    error_sent_at = Clock::now();
    if (!sent_error.empty()) notify(sent_error);
  }
}

void Server::State::send_device(WebSocketClient* page) {
  const HapticDeviceState* const held = haptic_device();
  if (!held) return;
  const std::vector<uint8_t> message = encode(Device{
      held->name, held->force_n, held->stiffness_n_mm, held->max_n_mm, held->scale, held->share});
  if (page)
    page->send(message);
  else
    send(message);
}

void Server::State::follow() {
  if (stop && stop()) return loop.stop();
  if (session) {
    const std::vector<Session::ChunkPlace>& changed = session->follow();
    const std::vector<WebSocketClient*> all(pages.begin(), pages.end());
    for (WebSocketClient* const page : all) {
      if (!pages.count(page)) continue;
      page->changed(changed);
      page->offer_bodies();
      page->offer_chunks();
    }
    send_ticks();
    if (session->experiment()) follow_experiment();
    if (session->playback()) follow_playback();
    const auto now = Clock::now();
    for (WebSocketClient* const page : all)
      if (pages.count(page)) page->offer_method(now);
    if (now - state_at >= kStateEvery) {
      state_at = now;
      send_state();
    }
  }
  if (job.busy() && Clock::now() - work_at >= kWorkEvery) send_work();
  imports.drop_old(Clock::now());
  timer.start(kFollowEvery, [this] { follow(); });
}

Result<std::unique_ptr<Server>> Server::listen(Library library, uint16_t port,
                                               const SessionOptions& how, const Limits& limits) {
  auto state = std::make_unique<State>(std::move(library), how, limits);
  if (const Status listening = state->listener.listen("127.0.0.1", port); !listening)
    return Error{"cannot listen on port " + std::to_string(port) + " (" + listening.error() +
                 "); choose another one with --port"};
  const std::string number = std::to_string(state->listener.port());
  state->local.hosts = {"127.0.0.1:" + number, "localhost:" + number};
  state->listener.start([here = state.get()](net::Socket socket) {
    serve_http(std::move(socket), *here, here->local);
  });
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}
Server::~Server() = default;
uint16_t Server::port() const { return state_->listener.port(); }
std::string Server::url() const {
  return "http://" + state_->local.hosts.front() + "/?token=" + state_->door.token();
}
void Server::on_new_address(std::function<void(const std::string&)> notify) {
  state_->door.on_new_token = [this, notify = std::move(notify)](const std::string&) {
    notify(url());
  };
}

Result<LanPlace> Server::serve_lan(const LanOptions& how,
                                   std::function<void(const std::string&)> on_code) {
  const Result<Certificate> kept = keep_certificate(how.certificate, how.addresses);
  if (!kept) return Error{kept.error()};
  State& s = *state_;
  auto listener = TlsListener::listen(
      s.loop, how.addresses, how.port, kept.value().pem, s.network.guests,
      std::chrono::duration_cast<net::Duration>(std::chrono::duration<double>(s.limits.header_s)),
      [&s](net::Socket socket) { serve_http(std::move(socket), s, s.network); });
  if (!listener) return Error{listener.error()};
  s.tls_listener = std::move(listener).value();
  const std::string port = std::to_string(s.tls_listener->port());
  // With the port, because a browser sends a cookie to every port of an address.
  s.network.cookie = "__Host-kibori-" + port;
  LanPlace place{{}, kept.value().fingerprint, kept.value().made};
  for (const std::string& address : how.addresses) {
    const bool v6 = address.find(':') != address.npos;
    std::string host = v6 ? "[" + address + "]" : address;
    s.network.hosts.push_back(host.append(":").append(port));
    place.urls.push_back("https://" + s.network.hosts.back() + "/");
  }
  s.pairing.on_code = std::move(on_code);
  return place;
}

void Server::offer_code() { state_->pairing.offer(Pairing::Clock::now()); }

void Server::publish_by(std::unique_ptr<Publisher> publisher) {
  state_->publisher = std::move(publisher);
  state_->update_publisher();
}
void Server::show(std::unique_ptr<Session> session) { state_->show(std::move(session)); }

bool Server::shows(const std::string& file) const {
  return state_->session && !state_->job.busy() && state_->session->name() == file;
}
void Server::notify(const std::string& text) { state_->notify(text); }

void Server::run(const std::function<bool()>& stop) {
  state_->stop = stop;
  state_->follow();
  state_->loop.run();
}

bool Server::idle() const { return state_->all_ended; }

std::string Server::close() {
  const std::string last = state_->session ? state_->session->close() : std::string();
  constexpr auto kPatience = std::chrono::milliseconds(500);
  state_->all_ended = state_->job.end_within(kPatience);
  const std::string& before = *state_->left_unsaved;
  return before.empty() || last.empty() ? before + last : before + "\n" + last;
}

}  // namespace kibori::studio
