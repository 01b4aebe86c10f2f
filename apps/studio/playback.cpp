// SPDX-License-Identifier: MIT
// Milling jobs on pages: the messages of a PlaybackSession, the document that it becomes, and its
// answers to HTTP requests.
#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include <kibori/document/rescue.h>

#include "apps/studio/playback.h"
#include "apps/studio/server_state.h"
#include "apps/studio/websocket_client.h"

namespace kibori::studio {
namespace {

// Pages get a moment about once per frame.
constexpr auto kPlayedEvery = std::chrono::milliseconds(30);
// Maximum number of lines and parts of one answer.
constexpr size_t kMaxLines = 2000, kMaxParts = 4000;

std::string text_of(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string playback_json(const PlaybackSession& playback) {
  nlohmann::json programs = nlohmann::json::array(), collisions = programs;
  for (size_t i = 0; i < playback.programs().size(); i++)
    programs.push_back({{"name", playback.programs()[i]}, {"lines", playback.texts()[i].lines()}});
  for (const MillTape::Collision& collision : playback.collisions())
    collisions.push_back({{"kind", name_of(collision.met.kind)},
                          {"program", collision.met.program},
                          {"line", collision.met.line},
                          {"tool", collision.met.tool},
                          {"time", playback.time_of(collision)},
                          {"volume_mm3", collision.met.volume_mm3}});
  return text_of({{"programs", programs},
                  {"collisions", collisions},
                  {"warnings", playback.warnings()},
                  {"error", playback.error()}});
}

Played played(const PlaybackStatus& status) {
  Played message;
  message.time = status.time_s;
  message.computed = status.computed_s;
  message.done = status.done;
  message.share = status.share;
  message.playing = status.playing;
  message.speed = status.speed;
  message.stops = status.stops;
  message.program = static_cast<uint32_t>(status.program);
  message.line = static_cast<uint32_t>(status.line);
  message.tool = static_cast<uint32_t>(status.tool);
  message.rapid = status.rapid;
  message.force = status.force_n;
  message.power = status.power_w;
  message.stopped = status.stopped_at;
  return message;
}

}  // namespace

void Server::State::follow_playback() {
  PlaybackSession& playback = *session->playback();
  if (Tool now; playback.next_tool(now)) show_tool(now);
  if (Clock::now() - played_at < kPlayedEvery) return;
  played_at = Clock::now();
  const PlaybackStatus status = playback.status();
  const auto problems = std::tuple{status.problems, status.done, playback.warnings().size()};
  if (playback_sent.empty() || problems != problems_sent) {
    problems_sent = problems;
    playback_sent = encode(Playback{playback_json(playback)});
    send(playback_sent);
  }
  if (status == last_status && !played_sent.empty()) return;
  last_status = status;
  played_sent = encode(played(status));
  send(played_sent);
}

// Runs the job again, into a temporary file, so that a job that is stopped leaves no document.
void Server::State::keep_program(WebSocketClient& page, const std::string& name) {
  PlaybackSession* const playback = session ? session->playback() : nullptr;
  if (!playback) return;
  if (how.read_only)
    return page.notify(
        "this studio is read-only; to keep the job as a document, start it without --read-only");
  if (job.busy()) return page.notify("another job is running; wait for it, or cancel it");
  const std::string usual = std::filesystem::path(playback->name()).stem().string();
  const Result<std::filesystem::path> place = library.place_for(name.empty() ? usual : name);
  if (!place) return page.notify(place.error());
  work("Keeping the job as a document",
       [this, files = playback->files(), request = playback->request(), to = place.value(),
        options = how](std::atomic<double>&) -> Job::Then {
         const auto kept = std::make_shared<Result<std::unique_ptr<Session>>>(
             keep_playback(files, request, to, options));
         return [this, kept, to](bool wanted) {
           if (wanted && *kept && session && session->playback())
             return show(std::move(*kept).value());
           if (wanted && !*kept) return notify(kept->error());
           const bool made = kept->ok();
           *kept = Error{""};  // closes it before removing it
           if (made) remove_document(to);
         };
       });
}

Result<std::unique_ptr<Session>> keep_playback(const PlaybackFiles& files,
                                               const MillRequest& request,
                                               const std::filesystem::path& to,
                                               const SessionOptions& how) {
  const auto wrong = [&](const std::string& why) { return Error{without_folder(files, why)}; };
  const auto folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const std::filesystem::path made = folder.value()->path() / "job.kibori";
  Result<MillPlan> plan = plan_milling(request);
  if (!plan) return wrong(plan.error());
  for (MillSetup& setup : plan.value().setups) setup.target_file.clear();
  if (const Status models = make_models(plan.value()); !models) return wrong(models.error());
  MillPlanOptions options;
  options.document = made;
  // After an error the document holds the moves before it, as the playback does.
  const Status done = run_plan(plan.value(), options);
  if (!done && !std::filesystem::exists(made)) return wrong(done.error());
  return open_copy(made, to, how);
}

std::optional<std::string> program_lines(const PlaybackSession& playback, double program,
                                         double from) {
  if (!(program >= 0 && program < static_cast<double>(playback.texts().size()) && from >= 0))
    return std::nullopt;
  const ProgramText& text = playback.texts()[static_cast<size_t>(program)];
  nlohmann::json lines = nlohmann::json::array();
  const double count = static_cast<double>(text.lines());
  for (auto i = static_cast<size_t>(std::min(from, count));
       i < text.lines() && lines.size() < kMaxLines; i++)
    lines.push_back(text.line(i));
  return text_of(lines);
}

std::optional<std::string> force_curve(const PlaybackSession& playback, double parts) {
  if (!(parts >= 1 && parts <= static_cast<double>(kMaxParts))) return std::nullopt;
  const MillTape::Curve curve = playback.curve(static_cast<size_t>(parts));
  return text_of({{"seconds", curve.seconds}, {"force", curve.force_n}, {"power", curve.power_w}});
}

std::string needs_json(const PlaybackNeeds& needs, const std::string& import) {
  const Box& stock = needs.suggested_stock;
  nlohmann::json box = nlohmann::json::array();
  if (needs.stock)
    for (const Vec3& corner : {stock.min, stock.max})
      for (const double x : corner) box.push_back(x);
  return text_of({{"kind", "program"},
                  {"import", import},
                  {"name", needs.name},
                  {"programs", needs.programs},
                  {"asks", {{"stock", needs.stock}, {"tool", needs.tool}, {"pitch", needs.pitch}}},
                  {"stock", box},
                  {"longest_mm", needs.longest_mm},
                  {"diameter_mm", kUsualDiameter},
                  {"materials", machining_materials()},
                  {"material", kMillMaterial}});
}

}  // namespace kibori::studio
