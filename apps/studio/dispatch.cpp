// SPDX-License-Identifier: MIT
// Executes each message of a page. A message without a function here does not compile.
#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>

#include <nlohmann/json.hpp>

#include <kibori/base/file.h>
#include <kibori/scene/stamp.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/haptics/materials.h>
#include <kibori/measure/mass.h>

#include "apps/studio/server_state.h"
#include "apps/studio/tool_message.h"
#include "apps/studio/websocket_client.h"

namespace kibori::studio {
namespace {

constexpr size_t kMaxThumbnailBytes = 65536;
constexpr size_t kMaxNameBytes = 400;

bool is_png(const Bytes& bytes) {
  constexpr std::array<uint8_t, 8> kBegin{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() <= kMaxThumbnailBytes && bytes.size() > kBegin.size() &&
         std::equal(kBegin.begin(), kBegin.end(), bytes.begin());
}

Result<Tool> stamp_of(const ChooseStamp& m, double pitch_mm) {
  if (m.what == 0) {
    // Accepts only a family: a page must not name files here.
    if (m.font.find('/') != std::string::npos)
      return Error{"the font must be the name of a family, not a file"};
    return text_stamp({m.text, m.font, m.size, m.depth, 0}, pitch_mm);
  }
  // The readers of pictures and meshes need a file.
  const auto folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const std::string ending = ending_of(m.name);
  if (m.what == 1 ? ending != ".png" : !is_one_of(kMeshesRead, ending))
    return Error{m.what == 1
                     ? "a picture must be a PNG file"
                     : "a mesh must be a file of type " + list_of(kMeshesRead, ", ", " or ")};
  const std::filesystem::path path = folder.value()->path() / ("stamp" + ending);
  NewFile file(path);
  file.write(m.data.data(), m.data.size());
  if (const Status written = file.commit(); !written) return Error{written.error()};
  PictureStamp picture;
  picture.width_mm = m.size;
  picture.depth_mm = m.depth;
  picture.invert = m.invert != 0;
  Result<Tool> tool =
      m.what == 1 ? picture_stamp(path, picture, pitch_mm) : mesh_stamp(path, m.size);
  // Replaces the temporary path by the file's name that the user knows.
  if (!tool) {
    std::string error = tool.error();
    if (const size_t at = error.find(path.string()); at != error.npos)
      error.replace(at, path.string().size(), sanitize_message(m.name));
    return Error{error};
  }
  return tool;
}

struct Dispatch {
  Server::State& server;
  WebSocketClient& page;

  // Messages of any page.
  void operator()(const Hello&) const {}  // a second Hello has no effect
  void operator()(const Got& m) const { page.got(m.frame); }
  void operator()(const TakeTool&) const { server.hold(&page); }
  void operator()(const AskMethod& m) const {
    if (server.session) page.method().ask(m, MethodView::Clock::now());
  }

  void operator()(const ShowRemains& m) const { page.show_remains(m.shown != 0); }
  void operator()(const ShowFaults& m) const {
    page.show_faults(m.shown != 0, {m.wall, m.overhang, Vec3::UnitZ()});
  }

  // Messages of the page that holds the tool, with or without a document.
  void operator()(const CancelWork&) const {
    ExperimentSession* const run = server.session ? server.session->experiment() : nullptr;
    if (run && !run->outcome() && !server.job.busy()) return run->cancel();
    server.job.cancel();
    server.send_work();
  }
  void operator()(const Begin& m) const { server.begin(page, m); }
  void operator()(const Open& m) const { server.open_named(page, m.name); }
  void operator()(const CarveExample& m) const { server.carve_example(page, m.name); }
  void operator()(const ChangeDetail& m) const { server.change_detail(page, m); }
  void operator()(const RunExperiment& m) const { server.run_experiment(page, m); }

  // Messages of the page that holds the tool, for a milling job.
  void operator()(const PlayProgram& m) const {
    play([&](PlaybackSession& s) { s.play(m.playing != 0, m.speed, m.stops != 0); });
  }
  void operator()(const SeekProgram& m) const {
    play([&](PlaybackSession& s) { s.seek(m.time); });
  }
  void operator()(const StepProgram& m) const {
    play([&](PlaybackSession& s) { s.step_line(m.forward != 0); });
  }
  void operator()(const GoToLine& m) const {
    constexpr uint32_t kMax = std::numeric_limits<int>::max();
    play([&](PlaybackSession& s) {
      s.go_to_line(static_cast<int>(std::min(m.program, kMax)),
                   static_cast<int>(std::min(m.line, kMax)));
    });
  }
  void operator()(const KeepProgram& m) const { server.keep_program(page, m.name); }

  // Messages of the page that holds the tool, for the open document.
  void operator()(const Aim& m) const {
    carve([&](LiveSession& s) { s.aim(m.tip, m.axis, m.time, m.pressure); });
  }
  void operator()(const Press& m) const {
    carve([&](LiveSession& s) { s.press(m.tip, m.axis, m.mode, m.time, m.pressure); });
  }
  void operator()(const Lift&) const { carve(&LiveSession::lift); }
  void operator()(const PressSecond& m) const {
    carve([&](LiveSession& s) { s.press_second(m.tip, m.axis, m.time); });
  }
  void operator()(const AimSecond& m) const {
    carve([&](LiveSession& s) { s.aim_second(m.tip, m.axis, m.time); });
  }
  void operator()(const LiftSecond&) const { carve(&LiveSession::lift_second); }
  void operator()(const Cancel&) const { edit(&Session::cancel); }
  void operator()(const Undo&) const { edit(&Session::undo); }
  void operator()(const Redo&) const { edit(&Session::redo); }
  void operator()(const Strike&) const { carve(&LiveSession::strike); }
  void operator()(const Go& m) const {
    edit([&](Session& s) { s.go(m.step); });
  }
  void operator()(const Leave&) const {
    if (server.session) server.leave(page);
  }
  void operator()(const ChooseTurn& m) const {
    carve([&](LiveSession& s) { s.turn(m.turn); });
  }
  void operator()(const ChooseWork& m) const {
    carve([&](LiveSession& s) { s.work(m.mode); });
  }
  void operator()(const Arm& m) const {
    carve([&](LiveSession& s) { s.arm(m.armed != 0); });
  }
  void operator()(const BringTool& m) const {
    carve([&](LiveSession& s) { s.bring(m.tip); });
  }
  void operator()(const KeepThumbnail& m) const {
    if (is_png(m.png)) edit([&](Session& s) { s.keep_thumbnail(m.step, m.png); });
  }
  void operator()(const NameVersion& m) const {
    if (m.name.size() > kMaxNameBytes) return respond(Error{"that name is too long"});
    edit([&](Session& s) { s.name_version(m.name); });
  }
  void operator()(const ChooseSymmetry& m) const {
    const unsigned planes = m.planes;
    choose([&](LiveSession& s) {
      return s.choose_symmetry({(planes & 1) != 0, (planes & 2) != 0, (planes & 4) != 0}, m.fold,
                               kAxes[m.axis]);
    });
  }
  void operator()(const ChooseBrush& m) const {
    Brush brush;
    brush.radius_mm = m.radius;
    brush.strength = m.strength;
    brush.falloff = static_cast<Falloff>(m.falloff);
    brush.keep_volume = m.keep != 0;
    brush.color = {m.red, m.green, m.blue};
    brush.flatten_to = static_cast<FlattenTo>(m.plane);
    brush.plane = {m.point, m.normal};
    brush.wall_mm = m.wall;
    brush.mask = static_cast<MaskVerb>(m.mask);
    brush.mask_material = m.mask_material;
    brush.alpha = static_cast<Alpha>(m.alpha);
    brush.pressure = static_cast<PressureUse>(m.pressure);
    choose([&](LiveSession& s) { return s.choose_brush(brush); });
  }
  void operator()(const ChooseTexture& m) const {
    choose([&](LiveSession& s) -> Status {
      const auto* const data = reinterpret_cast<const char*>(m.data.data());
      auto picture = parse_alpha_picture({data, m.data.size()}, sanitize_message(m.name));
      if (!picture) return Error{picture.error()};
      s.choose_texture(std::move(picture).value());
      return Ok{};
    });
  }
  void operator()(const ChooseMaterial& m) const {
    choose([&](LiveSession& s) { return s.choose_material(m.material); });
  }
  void operator()(const ChooseModel& m) const {
    choose([&](LiveSession& s) { return s.choose_model(m.model); });
  }
  void operator()(const ChooseGuide& m) const {
    choose([&](LiveSession& s) -> Status {
      StrokeGuideSettings guide;
      guide.guide = static_cast<Guide>(m.guide);
      guide.snap_deg = m.snap;
      guide.centre_mm = m.centre;
      guide.steady_mm = m.steady;
      guide.lead = m.lead != 0;
      guide.entry_mm = m.entry;
      guide.lift_mm = m.lift;
      guide.stamp = m.stamp != 0;
      guide.every_mm = m.every;
      guide.closed = m.closed != 0;
      constexpr size_t kPoint = 3 * sizeof(double);
      if (m.curve.size() % kPoint != 0) return Error{"the curve of the guide is incomplete"};
      guide.curve_mm.resize(m.curve.size() / kPoint);
      for (size_t i = 0; i < guide.curve_mm.size(); i++)
        std::memcpy(guide.curve_mm[i].data(), m.curve.data() + i * kPoint, kPoint);
      return s.choose_guide(guide);
    });
  }
  void operator()(const ChooseCrumbs& m) const {
    choose([&](LiveSession& s) { return s.choose_crumbs(static_cast<Crumbs>(m.rule)); });
  }
  void operator()(const ChooseBody& m) const {
    carve([&](LiveSession& s) { s.choose_body(static_cast<BodyId>(m.body)); });
  }
  void operator()(const ActOnBodies& m) const {
    choose([&](LiveSession& s) -> Status {
      const Result<BodyAction> action = action_from_json(m.action);
      if (!action) return Error{action.error()};
      s.act(action.value());
      return Ok{};
    });
  }
  void operator()(const ReviseStep& m) const {
    choose([&](LiveSession& s) -> Status {
      const Result<BodyAction> action = action_from_json(m.action);
      if (!action) return Error{action.error()};
      s.revise(m.step, m.head, action.value());
      return Ok{};
    });
  }
  void operator()(const AskMass&) const {
    if (!server.session) return;
    const Body& body = server.session->active_body();
    std::vector<double> densities;
    densities.reserve(server.session->materials().size() + 1);
    for (const Material& m : server.session->materials()) densities.push_back(m.density_kg_m3);
    if (densities.empty()) densities.push_back(0);
    const MassProperties mass = mass_of(body.model, densities);
    Mass reply;
    reply.body = static_cast<uint32_t>(body.id);
    for (const double volume : mass.volume_mm3) reply.volume += volume;
    reply.mass = mass.mass_g;
    for (const Body& each : server.session->bodies().all)
      reply.memory += static_cast<double>(each.model.memory_bytes());
    if (reply.volume > 0) reply.centre = body.pose.to_world(mass.centre_mm);
    page.send(encode(reply));
  }
  void operator()(const PreviewAction& m) const {
    LiveSession* const live = server.live();
    if (!live) return;
    Previewed reply;
    if (m.action.empty()) {
      live->end_preview();
    } else if (const Result<BodyAction> action = action_from_json(m.action); !action) {
      reply.error = action.error();
    } else if (const auto forces = live->preview(action.value()); !forces) {
      reply.error = forces.error();
    } else {
      nlohmann::json list = nlohmann::json::array();
      for (const Vec3& f : forces.value()) list.push_back({f.x(), f.y(), f.z()});
      reply.forces = list.dump();
    }
    page.send(encode(reply));
  }
  void operator()(const ChooseReach& m) const {
    choose([&](LiveSession& s) {
      Status done = s.choose_reach(m.scale);
      server.send_device(done ? nullptr : &page);
      return done;
    });
  }
  void operator()(const ChooseHand& m) const {
    choose([&](LiveSession& s) {
      constexpr std::array kShares{1.0, kPoweredShare, kPressShare};
      Status done = s.choose_hand({m.strength, m.stiffness, kShares[m.powered]});
      server.send_device(done ? nullptr : &page);
      return done;
    });
  }
  void operator()(const ChooseSecond& m) const {
    choose([&](LiveSession& s) -> Status {
      const Result<Tool> tool = tool_from_json(m.tool);
      if (!tool) return Error{tool.error()};
      return s.choose_second(tool.value(), m.mode, {m.lead != 0, m.entry, m.lift});
    });
  }
  void operator()(const ChooseTool& m) const {
    choose([&](LiveSession& s) -> Status {
      const Result<Tool> tool = tool_from_json(m.tool);
      if (!tool) return Error{tool.error()};
      // A page cannot send a mesh as a tool. ChooseStamp makes mesh tools.
      if (std::holds_alternative<MeshTool>(tool.value())) return Error{"choose a stamp"};
      return hold(s, tool.value());
    });
  }
  void operator()(const ChooseStamp& m) const {
    choose([&](LiveSession& s) -> Status {
      const Result<Tool> tool = stamp_of(m, s.lattice().pitch_mm);
      if (!tool) return Error{tool.error()};
      return hold(s, tool.value());
    });
  }
  void operator()(const AskFonts&) const {
    page.send(encode(Fonts{nlohmann::json(font_families())
                               .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}));
  }

 private:
  Status hold(LiveSession& live, const Tool& tool) const {
    Status done = live.choose_tool(tool);
    if (done) server.show_tool(tool);
    return done;
  }
  void respond(const Status& done) const {
    if (!done && server.session) page.notify(done.error());
  }
  template <class F>
  void edit(F&& f) const {
    if (server.session) std::invoke(f, *server.session);
  }
  template <class F>
  void play(F&& f) const {
    if (PlaybackSession* const playback = server.session ? server.session->playback() : nullptr)
      std::invoke(f, *playback);
  }
  template <class F>
  void carve(F&& f) const {
    if (LiveSession* const live = server.live()) std::invoke(f, *live);
  }
  template <class F>
  void choose(F&& f) const {
    if (!server.session) return;
    LiveSession* const live = server.live();
    respond(live ? f(*live) : Error{"the document is open read-only"});
  }
};

}  // namespace

void Server::State::on_message(WebSocketClient& page, const FromPage& message) {
  const bool of_any_page =
      std::holds_alternative<Hello>(message) || std::holds_alternative<Got>(message) ||
      std::holds_alternative<TakeTool>(message) || std::holds_alternative<AskMethod>(message) ||
      std::holds_alternative<ShowRemains>(message) || std::holds_alternative<ShowFaults>(message);
  if (!of_any_page) {
    // If no document is open, the page that opens one gets the tool.
    if (!session && holder != &page) hold(&page);
    if (holder != &page) return;  // this page only watches
  }
  std::visit(Dispatch{*this, page}, message);
}

}  // namespace kibori::studio
