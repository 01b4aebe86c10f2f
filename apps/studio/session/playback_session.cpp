// SPDX-License-Identifier: MIT
#include "apps/studio/session/playback_session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/studio/session/stock_scene.h"

namespace kibori {
namespace {

// A page draws 60 states per second at most.
constexpr auto kShowEvery = std::chrono::milliseconds(15);
// While nothing moves, the computed time changes.
constexpr auto kIdle = std::chrono::milliseconds(40);
// A state is shown so often on a long way.
constexpr auto kShowLongWay = std::chrono::milliseconds(150);
// Moves per state if it plays as fast as possible. A long program takes about ten seconds.
constexpr size_t kFastMoves = 256, kFastStates = 600;

// If a state takes longer, the clock slows down [s].
constexpr double kMaxFrame = 0.25;

// The run leaves processors for the player and the server.
int run_threads() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()) - 1, 1, 8);
}

Status check_size(const Lattice& lattice) {
  if (lattice.nodes.maxCoeff() <= 1.25 * kMaxRays) return Ok{};
  return Error{"the studio cannot show a stock this fine: its longest side may have at most " +
               std::to_string(static_cast<int>(kMaxRays)) +
               " cells; use a coarser pitch, or run the job with 'kibori mill'"};
}

}  // namespace

Result<std::unique_ptr<Session>> PlaybackSession::start(PlaybackFiles files,
                                                        const PlaybackChoice& choice) {
  Result<MillRequest> request = playback_request(files, choice);
  if (!request) return Error{request.error()};
  const auto wrong = [&](const std::string& why) { return Error{without_folder(files, why)}; };
  std::vector<std::string> notes;
  request.value().threads = run_threads();
  request.value().warning = [&](const std::string& note) {
    notes.push_back(without_folder(files, note));
  };
  Result<MillPlan> plan = plan_milling(request.value());
  if (!plan) return wrong(plan.error());
  // The studio shows no comparison with a target.
  for (MillSetup& setup : plan.value().setups) setup.target_file.clear();
  if (const Status made = make_models(plan.value()); !made) return wrong(made.error());
  if (const Status fits = check_size(plan.value().model->lattice()); !fits)
    return Error{fits.error()};
  request.value().warning = nullptr;
  plan.value().warning = nullptr;
  std::unique_ptr<PlaybackSession> session(
      new PlaybackSession(std::move(files), std::move(plan).value()));
  PlaybackSession& s = *session;
  s.request_ = std::move(request).value();
  s.warnings_ = std::move(notes);
  uint64_t room = kMaxPlaybackText;
  for (const MillSetup& setup : s.plan_.setups)
    for (const std::filesystem::path& program : setup.programs) {
      Result<ProgramText> text = ProgramText::read(program, room);
      if (!text) return Error{without_folder(s.files_, text.error())};
      s.all_lines_ += text.value().lines();
      s.program_names_.push_back(program.filename().string());
      s.texts_.push_back(std::move(text).value());
    }
  s.name_ = s.request_.programs.front().filename().string();
  s.run_thread_ = std::thread([&s] { s.run(); });
  s.play_thread_ = std::thread([&s] { s.loop(); });
  return std::unique_ptr<Session>(std::move(session));
}

PlaybackSession::PlaybackSession(PlaybackFiles files, MillPlan plan)
    : files_(std::move(files)), plan_(std::move(plan)) {
  materials_ = plan_.materials;
  tape_.begin(*plan_.model);
  begin({BodyList::of(*plan_.model), 1}, 0);
}

PlaybackSession::~PlaybackSession() {
  stopping_ = true;
  changed_.notify_all();
  for (std::thread* const thread : {&run_thread_, &play_thread_})
    if (thread->joinable()) thread->join();
}

// ---- The user's wishes

void PlaybackSession::play(bool playing, double speed, bool stops) {
  const std::scoped_lock lock(mutex_);
  status_.playing = playing;
  status_.speed = speed;
  status_.stops = stops;
  if (playing) {
    wish_ = {};
    status_.stopped_at = -1;
    breakpoint_s_.reset();
    // At the end it begins again.
    if (status_.done && status_.time_s >= status_.computed_s) wish_.time_s = 0;
  }
  changed_.notify_all();
}

void PlaybackSession::seek(double time_s) {
  const std::scoped_lock lock(mutex_);
  wish_ = {time_s, {}, {}};
  changed_.notify_all();
}

void PlaybackSession::step_line(bool forward) {
  const std::scoped_lock lock(mutex_);
  wish_ = {{}, forward, {}};
  status_.playing = false;
  changed_.notify_all();
}

void PlaybackSession::go_to_line(int program, int line) {
  const std::scoped_lock lock(mutex_);
  wish_ = {{}, {}, std::pair{program, line}};
  status_.playing = false;
  changed_.notify_all();
}

// ---- What to show

PlaybackStatus PlaybackSession::status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

double PlaybackSession::time_of(const MillTape::Collision& collision) const {
  const std::vector<MillTapeMove> move = tape_.moves(collision.move, 1);
  return move.empty() ? 0 : move.front().end_s();
}

std::vector<std::string> PlaybackSession::warnings() const {
  const std::scoped_lock lock(mutex_);
  return warnings_;
}

std::string PlaybackSession::error() const { return without_folder(files_, tape_.state().error); }

bool PlaybackSession::latest(Shown& shown) {
  const bool newer = states_.take(shown);
  hashed_ = hashed_ && !newer;
  return newer;
}

// The hash takes time, so it is computed only at rest.
void PlaybackSession::update_history() {
  if (hashed_ || busy()) return;
  history_.hash = snapshot().content_hash();
  hashed_ = true;
}

void PlaybackSession::thumbnail(StepId, std::function<void(Bytes)> use) { use({}); }

void PlaybackSession::save_copy(const std::filesystem::path&, std::function<void(Status)> done) {
  done(Error{"a playback has no document; keep it as a document first"});
}

// ---- The run thread

void PlaybackSession::run() {
  MillPlanOptions options;
  options.tape = &tape_;
  options.stop = &stopping_;
  const Status done = run_plan(plan_, options);
  {
    const std::scoped_lock lock(mutex_);
    for (const MillSetup& setup : plan_.setups)
      for (const MillWarning& warning : setup.summary.warnings)
        warnings_.push_back((warning.program < setup.programs.size()
                                 ? setup.programs[warning.program].filename().string() + ":"
                                 : std::string()) +
                            std::to_string(warning.line) + ": " + warning.text);
  }
  tape_.finish(done ? "" : done.error());
  changed_.notify_all();
}

// ---- The play thread

void PlaybackSession::loop() {
  MillPlayer player(tape_, 1);
  auto last = Clock::now(), shown_at = last;
  uint64_t shown = player.model().generation();
  int in_spindle = -1;
  bool there = true;
  while (!stopping_) {
    {
      std::unique_lock lock(mutex_);
      const bool wished = wish_.time_s || wish_.step_forward || wish_.line;
      if (there && !wished) changed_.wait_for(lock, status_.playing ? kShowEvery : kIdle);
      aim(player, last);
      moving_ = status_.playing || player.at() != goal_;
    }
    const Result<bool> arrived = player.go(goal_);
    there = !arrived || arrived.value();
    if (!arrived) {
      const std::scoped_lock lock(mutex_);
      warnings_.push_back(arrived.error());
      status_.playing = false;
      goal_ = player.at();
    }
    // During a long way, only some states are shown.
    const uint64_t now = player.model().generation();
    if (now != shown && (there || Clock::now() - shown_at > kShowLongWay)) {
      shown = now;
      shown_at = Clock::now();
      states_.put({BodyList::of(player.model()), 1});
    }
    if (const int tool = player.tool(); tool >= 0 && std::exchange(in_spindle, tool) != tool)
      tools_.put(tape_.tool(tool).cutter);
    // Also at rest, because a page that is busy with chunks misses ticks.
    if (const auto pose = player.pose()) {
      LiveTick tick;
      tick.tool = *pose;
      ticks_.push(tick);
    }
    show(player);
  }
}

// Sets the goal. Call it with the lock.
void PlaybackSession::aim(MillPlayer& player, Clock::time_point& last) {
  const auto now = Clock::now();
  const double elapsed_s = std::chrono::duration<double>(now - std::exchange(last, now)).count();
  const MillTape::State tape = tape_.state();
  if (wish_.time_s) {
    clock_s_ = std::clamp(*wish_.time_s, 0.0, tape.seconds);
    goal_ = player.moment(clock_s_);
    breakpoint_s_.reset();
    status_.stopped_at = -1;
    wish_ = {};
  } else if (wish_.step_forward || wish_.line) {
    aim_at_line(player);
  } else if (status_.playing && player.at() == goal_) {
    goal_ = play_on(player, elapsed_s);
    if (tape.done && player.at() == goal_ && goal_.moves == tape.moves) status_.playing = false;
  }
}

void PlaybackSession::aim_at_line(MillPlayer& player) {
  const MillTape::State tape = tape_.state();
  const MillMoment at = player.at();
  if (wish_.line) {
    const auto found = tape_.find_line(wish_.line->first, wish_.line->second);
    if (!found && !tape.done) return;  // it is not computed yet
    // The last line of moves may still grow.
    if (found && found->end == tape.moves && !tape.done) return;
    goal_ = {found ? found->end : tape.moves, 0};
  } else if (*wish_.step_forward) {
    const MillTape::Range next = tape_.line_of(at.moves);
    if (next.end == tape.moves && !tape.done) return;
    goal_ = {next.end, 0};
  } else if (at.share > 0 || at.moves > 0) {
    goal_ = {tape_.line_of(at.share > 0 ? at.moves : at.moves - 1).begin, 0};
  }
  status_.stopped_at = -1;
  breakpoint_s_.reset();
  wish_ = {};
}

MillMoment PlaybackSession::play_on(MillPlayer& player, double elapsed_s) {
  const MillTape::State tape = tape_.state();
  MillMoment to;
  if (status_.speed > 0) {
    // While the tool waits, only the clock knows the time. It waits for what is not computed yet.
    if (player.moment(clock_s_) != player.at()) clock_s_ = player.seconds();
    clock_s_ = std::min(clock_s_ + std::min(elapsed_s, kMaxFrame) * status_.speed, tape.seconds);
    to = player.moment(clock_s_);
  } else {
    const size_t count = std::max(kFastMoves, tape.moves / kFastStates);
    to = {std::min(player.at().moves + count, tape.moves), 0};
  }
  if (!status_.stops) return to;
  const std::vector<MillTape::Collision> all = tape_.collisions();
  for (size_t i = 0; i < all.size(); i++) {
    const MillMoment end{all[i].move + 1, 0};
    if (end.moves <= player.at().moves) continue;
    if (end.moves > to.moves) break;
    status_.playing = false;
    status_.stopped_at = static_cast<int>(i);
    return end;
  }
  return to;
}

void PlaybackSession::show(const MillPlayer& player) {
  const MillTape::State tape = tape_.state();
  const std::scoped_lock lock(mutex_);
  PlaybackStatus& s = status_;
  s.time_s = player.moment(clock_s_) == player.at() ? clock_s_ : player.seconds();
  s.computed_s = tape.seconds;
  s.done = tape.done;
  s.problems = tape.collisions;
  s.share = tape.done ? 1 : 0;
  if (!tape.done && tape.moves > 0) {
    const std::vector<MillTapeMove> last = tape_.moves(tape.moves - 1, 1);
    size_t lines = 0;
    for (int i = 0; i < last.front().program; i++) lines += texts_[static_cast<size_t>(i)].lines();
    lines += static_cast<size_t>(std::max(0, last.front().line));
    s.share = std::min(0.99, static_cast<double>(lines) / static_cast<double>(all_lines_ + 1));
  }
  const std::optional<MillTapeMove>& move = player.move();
  s.program = move ? move->program : 0;
  s.line = move ? move->line : 0;
  s.tool = move && move->tool >= 0 ? tape_.tool(move->tool).number : 0;
  s.rapid = move && move->rapid;
  s.force_n = move ? move->force_n : 0;
  s.power_w = move ? move->power_w : 0;
}

}  // namespace kibori
