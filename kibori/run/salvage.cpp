// SPDX-License-Identifier: MIT
#include <kibori/run/salvage.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <kibori/body/workbench.h>
#include <kibori/document/rescue.h>
#include <kibori/run/replay.h>
#include <kibori/scene/stock_codec.h>

namespace kibori {

namespace {

// The data of an intact stroke of the old document.
struct WholeStroke {
  StrokeSettings settings;
  Pose start;
  std::vector<RecordedTick> ticks;
  std::vector<Wrench> computed, given;
};

// Reads a stroke and plays it on the bench. `as_recorded`: the result must be the recorded state,
// and forces are read. Errors: the stroke is damaged, or its result differs.
Result<WholeStroke> read_stroke(const Document& document, StepId step, Workbench& bench,
                                bool as_recorded) {
  WholeStroke whole;
  const Result<StrokeSettings> settings = document.settings(step);
  if (!settings) return Error{settings.error()};
  whole.settings = settings.value();
  if (!as_recorded) {
    whole.settings.grown_below = bench.model().lattice().below;
    whole.settings.grown_above = bench.model().lattice().above;
  }
  const Result<Pose> start = document.start(step);
  if (!start) return Error{start.error()};
  whole.start = start.value();
  const auto gather = [](auto& all) {
    return [&all](const auto& some) -> Status {
      all.insert(all.end(), some.begin(), some.end());
      return Ok{};
    };
  };
  Status done = document.for_ticks(step, gather(whole.ticks));
  if (done && as_recorded) done = document.for_forces(step, gather(whole.computed));
  if (done && as_recorded) done = document.for_given(step, gather(whole.given));
  if (done) done = document.replay(step, bench, std::nullopt, {});
  if (!done) return Error{done.error()};
  const Step& was = document.steps().at(step);
  if (as_recorded && (was.finished || was.hash != 0) && bench.bodies().content_hash() != was.hash)
    return Error{"it does not replay to its recorded state"};
  return whole;
}

// Writes a stroke that was played on `bench`. `bodies_before`: number of bodies before the stroke.
// The bodies after these are the severed pieces.
Status write_stroke(Document& into, const WholeStroke& stroke, const Step& was, double removed_mm3,
                    Workbench& bench, size_t bodies_before) {
  if (Status begun = into.begin(stroke.settings, stroke.start, was.label); !begun) return begun;
  const size_t count = stroke.ticks.size();
  for (size_t k = 0; k < count; k++)
    into.add(stroke.ticks[k], stroke.computed.size() == count ? &stroke.computed[k] : nullptr,
             stroke.given.size() == count ? &stroke.given[k] : nullptr);
  std::vector<Portion> severed;
  for (size_t k = bodies_before; k < bench.bodies().all.size(); k++)
    severed.push_back({bench.bodies().all[k].model, bench.bodies().all[k].material_bounds});
  return into.finish(bench.model(), removed_mm3, severed);
}

// Carves a step again and writes it into `into`. Returns false if the step is damaged or cannot be
// carved. `as_recorded`: as in read_stroke. Errors: it cannot be written.
Result<bool> copy_step(const Document& document, StepId step, Document& into, Workbench& bench,
                       bool as_recorded) {
  const Step& was = document.steps().at(step);
  if (was.action) {
    const Result<BodyAction> what = document.action(step);
    const Result<BodyChange> done = what ? bench.act(what.value()) : Error{what.error()};
    if (!done || (as_recorded && bench.bodies().content_hash() != was.hash)) return false;
    const Result<BodyChange> again = into.act(what.value());
    return again ? Result<bool>(true) : Result<bool>(Error{again.error()});
  }
  const size_t bodies_before = bench.bodies().all.size();
  const double before_mm3 = bench.model().volume_mm3();
  const Result<WholeStroke> stroke = read_stroke(document, step, bench, as_recorded);
  if (!stroke) return false;
  double removed_mm3 = was.removed_mm3;
  if (!as_recorded) {
    removed_mm3 = before_mm3 - bench.model().volume_mm3();
    for (size_t k = bodies_before; k < bench.bodies().all.size(); k++)
      removed_mm3 -= bench.bodies().all[k].model.volume_mm3();
  }
  if (Status written = write_stroke(into, stroke.value(), was, removed_mm3, bench, bodies_before);
      !written)
    return Error{written.error()};
  for (const auto& [name, named] : document.versions())
    if (named == step) static_cast<void>(into.name_version(name, into.head()));
  return true;
}

}  // namespace

Result<StepId> salvage(const Document& document, const std::filesystem::path& into) {
  const Result<std::vector<StepId>> path = document.path_to(document.head());
  if (!path) return Error{path.error()};
  Result<std::unique_ptr<TriDexel>> model = document.load_stock();
  if (!model) return Error{model.error() + "; no step of it is intact"};
  const Result<std::string> stock = document.stock();
  const Result<Bytes> source = document.source();
  if (!stock) return Error{stock.error()};
  if (!source) return Error{source.error()};
  Result<std::unique_ptr<Document>> made =
      Document::create(into, *model.value(), stock.value(), source.value());
  if (!made) return Error{made.error()};
  Workbench bench(*model.value());
  StepId saved = path.value().front();
  for (size_t i = 1; i < path.value().size(); i++) {
    const Result<bool> copied = copy_step(document, path.value()[i], *made.value(), bench, true);
    if (!copied) {
      made.value().reset();
      remove_document(into);
      return Error{copied.error()};
    }
    if (!copied.value()) break;  // the rest is damaged
    saved = path.value()[i];
  }
  if (const std::string where = settle(*made.value()); !where.empty()) return Error{where};
  return saved;
}

Result<StepId> carve_again(const Document& document, const std::filesystem::path& into,
                           double pitch_mm, const CarveOptions& options) {
  const Result<std::vector<StepId>> path = document.path_to(document.head());
  if (!path) return Error{path.error()};
  if (Status rows = document.check_rows(document.head()); !rows) return Error{rows.error()};
  const Result<std::string> text = document.stock();
  if (!text) return Error{text.error()};
  Result<std::unique_ptr<TriDexel>> model = stock_again(document, text.value(), pitch_mm, options);
  if (!model) return Error{model.error()};
  const Result<Bytes> source = document.source();
  if (!source) return Error{source.error()};
  Result<Stock> stock = stock_from_json(text.value());
  if (!stock) return Error{stock.error()};
  stock.value().pitch_mm = pitch_mm;
  Result<std::unique_ptr<Document>> made = Document::create(
      into, *model.value(),
      stock_to_json(stock.value(), stock_label(text.value()), stock_materials(text.value())),
      source.value());
  if (!made) return Error{made.error()};
  const auto fail = [&](const std::string& why) {
    made.value().reset();
    remove_document(into);
    return Error{why};
  };
  Workbench bench(*model.value());
  const size_t count = path.value().size();
  for (size_t i = 1; i < count; i++) {
    const StepId step = path.value()[i];
    const Result<bool> copied = copy_step(document, step, *made.value(), bench, false);
    if (!copied) return fail(copied.error());
    if (!copied.value())
      return fail(document.name() + ": step " + std::to_string(step) +
                  " cannot be carved at another pitch");
    if (options.progress) options.progress(static_cast<double>(i) / static_cast<double>(count));
  }
  const StepId head = made.value()->head();
  if (const std::string where = settle(*made.value()); !where.empty()) return Error{where};
  return head;
}

}  // namespace kibori
