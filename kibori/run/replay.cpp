// SPDX-License-Identifier: MIT
#include <kibori/run/replay.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/body/workbench.h>
#include <kibori/scene/stock_codec.h>

namespace kibori {

Result<std::unique_ptr<TriDexel>> stock_again(const Document& document, const std::string& text,
                                              double pitch_mm, const CarveOptions& options) {
  Result<Stock> stock = stock_from_json(text);
  if (!stock) return Error{document.name() + ": " + stock.error()};
  stock.value().pitch_mm = pitch_mm;
  const StockOptions how{options.threads, options.force, options.warning};
  std::filesystem::path* const named = file_of(stock.value());
  if (!named) return make_stock(stock.value(), document.name(), how);
  Result<Bytes> source = document.source();
  if (!source) return Error{source.error()};
  const auto folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const std::filesystem::path path = folder.value()->path() / ("stock" + ending_of(*named));
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(source.value().data()),
             static_cast<std::streamsize>(source.value().size()));
  file.close();
  if (!file)
    return Error{document.name() +
                 ": the file of its stock cannot be written to the temporary folder"};
  *named = path;
  return make_stock(stock.value(), document.name(), how);
}

namespace {

// Plays the steps of a document one after the other, on one Workbench.
class StepPlayer {
 public:
  StepPlayer(const Document& document, const ReplayOptions& options, bool as_recorded,
             int64_t total_ticks, Replay& replay)
      : document_(document),
        options_(options),
        as_recorded_(as_recorded),
        total_ticks_(total_ticks),
        replay_(replay),
        bench_(*replay.carving.model) {}

  Status play(StepId id);
  void finish();

 private:
  Status play_stroke(StepId id, const StrokeSettings& settings);
  void take(const ReplayedTick& tick, const StrokeSettings& settings);
  double time_s() const { return base_s_ + static_cast<double>(ticks_of_rate_) / rate_hz_; }

  const Document& document_;
  const ReplayOptions& options_;
  const bool as_recorded_;  // true: at the recorded pitch, so states can be compared
  const int64_t total_ticks_;
  Replay& replay_;
  Workbench bench_;
  std::vector<double> step_us_;
  // The time is base_s_ at the last change of the rate. ticks_of_rate_ counts the ticks since then.
  double rate_hz_ = 0, base_s_ = 0;
  int64_t ticks_of_rate_ = 0;
};

Status StepPlayer::play(StepId id) {
  const Step& step = document_.steps().at(id);
  if (step.stock) return Ok{};
  Status done = Ok{};
  if (step.action) {
    done = document_.replay(id, bench_, std::nullopt, {});
    if (as_recorded_) replay_.carving.summary.removed_mm3 += step.removed_mm3;
  } else {
    const Result<StrokeSettings> settings = document_.settings(id);
    if (!settings) return Error{settings.error()};
    done = play_stroke(id, settings.value());
    if (done && !step.label.empty()) replay_.carving.marks.push_back({step.label, time_s()});
  }
  if (!done) return done;
  if (as_recorded_ && replay_.differs == 0 && step.finished &&
      bench_.bodies().content_hash() != step.hash)
    replay_.differs = id;
  return Ok{};
}

Status StepPlayer::play_stroke(StepId id, const StrokeSettings& settings) {
  if (settings.rate_hz != rate_hz_) {
    if (rate_hz_ > 0) base_s_ = time_s();
    ticks_of_rate_ = 0;
    rate_hz_ = settings.rate_hz;
  }
  replay_.law = options_.law.value_or(settings.force.law);
  auto last = std::chrono::steady_clock::now();
  return document_.replay(id, bench_, options_.law, [&](const ReplayedTick& tick) {
    const auto now = std::chrono::steady_clock::now();
    step_us_.push_back(std::chrono::duration<double, std::micro>(now - last).count());
    take(tick, settings);
    last = std::chrono::steady_clock::now();
  });
}

void StepPlayer::take(const ReplayedTick& tick, const StrokeSettings& settings) {
  if (std::holds_alternative<PutTick>(tick.recorded->what)) return;
  Carving& carving = replay_.carving;
  CarveSummary& summary = carving.summary;
  const bool second = tick.recorded->second;
  ToolTick result = tick.result;
  add_tick(summary, second ? settings.second->mode : settings.mode, result);
  if (std::holds_alternative<EndTick>(tick.recorded->what)) return;
  if (second) {
    // The first hand's tick came before. Both share a row.
    if (!carving.trace.empty()) carving.trace.back().second = std::make_shared<ToolTick>(result);
    return;
  }
  ticks_of_rate_++;
  summary.ticks++;
  carving.trace.push_back({time_s(), result});
  if (options_.carve.progress && summary.ticks % 64 == 0)
    options_.carve.progress(static_cast<double>(summary.ticks) / static_cast<double>(total_ticks_));
}

void StepPlayer::finish() {
  replay_.carving.bodies = bench_.bodies();
  summarize(replay_.carving, std::move(step_us_));
  if (options_.carve.progress) options_.carve.progress(1);
}

}  // namespace

Result<Replay> replay_document(const Document& document, const ReplayOptions& options) {
  Replay replay;
  replay.to = document.head();
  if (!options.to.empty()) {
    const Result<StepId> to = document.find(options.to);
    if (!to) return Error{to.error()};
    replay.to = to.value();
  }
  if (Status rows = document.check_rows(replay.to); !rows) return Error{rows.error()};
  const Result<std::vector<StepId>> path = document.path_to(replay.to);
  if (!path) return Error{path.error()};
  const Result<std::string> text = document.stock();
  if (!text) return Error{text.error()};
  const bool as_recorded = !options.pitch_mm || *options.pitch_mm == document.lattice().pitch_mm;
  Result<std::unique_ptr<TriDexel>> model =
      as_recorded ? document.load_at(path.value().front())
                  : stock_again(document, text.value(), *options.pitch_mm, options.carve);
  if (!model) return Error{model.error()};
  replay.carving.model = std::move(model).value();
  if (std::string label = stock_label(text.value()); !label.empty())
    replay.carving.marks.push_back({std::move(label), 0});
  int64_t total_ticks = 0;
  for (const StepId id : path.value()) total_ticks += document.steps().at(id).ticks;
  StepPlayer player(document, options, as_recorded, total_ticks, replay);
  for (const StepId id : path.value())
    if (const Status played = player.play(id); !played) return Error{played.error()};
  player.finish();
  return replay;
}

}  // namespace kibori
