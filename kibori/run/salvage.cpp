// SPDX-License-Identifier: MIT
#include <kibori/run/salvage.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <kibori/body/workbench.h>
#include <kibori/document/rescue.h>

namespace kibori {

namespace {

// The data of an intact stroke of the damaged document.
struct WholeStroke {
  StrokeSettings settings;
  Pose start;
  std::vector<RecordedTick> ticks;
  std::vector<Wrench> computed, given;
};

// Reads a stroke and plays it on the bench. Errors: the stroke is damaged.
Result<WholeStroke> read_stroke(const Document& document, StepId step, Workbench& bench) {
  WholeStroke whole;
  const Result<StrokeSettings> settings = document.settings(step);
  if (!settings) return Error{settings.error()};
  whole.settings = settings.value();
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
  if (done) done = document.for_forces(step, gather(whole.computed));
  if (done) done = document.for_given(step, gather(whole.given));
  if (done) done = document.replay(step, bench, std::nullopt, {});
  if (!done) return Error{done.error()};
  const Step& was = document.steps().at(step);
  if ((was.finished || was.hash != 0) && bench.bodies().content_hash() != was.hash)
    return Error{"it does not replay to its recorded state"};
  return whole;
}

// `bodies_before` is the number of bodies before the stroke. The severed pieces are at the end of
// the list.
Status write_stroke(Document& into, const WholeStroke& stroke, const Step& was, Workbench& bench,
                    size_t bodies_before) {
  if (Status begun = into.begin(stroke.settings, stroke.start, was.label); !begun) return begun;
  const size_t count = stroke.ticks.size();
  for (size_t k = 0; k < count; k++)
    into.add(stroke.ticks[k], stroke.computed.size() == count ? &stroke.computed[k] : nullptr,
             stroke.given.size() == count ? &stroke.given[k] : nullptr);
  std::vector<Portion> severed;
  for (size_t k = bodies_before; k < bench.bodies().all.size(); k++)
    severed.push_back({bench.bodies().all[k].model, bench.bodies().all[k].material_bounds});
  return into.finish(bench.model(), was.removed_mm3, severed);
}

// Copies a step if it is intact. Returns false if it is not. Errors: it cannot be written.
Result<bool> copy_step(const Document& document, StepId step, Document& into, Workbench& bench) {
  const Step& was = document.steps().at(step);
  if (was.action) {
    const Result<BodyAction> what = document.action(step);
    const Result<BodyChange> done = what ? bench.act(what.value()) : Error{what.error()};
    if (!done || bench.bodies().content_hash() != was.hash) return false;
    const Result<BodyChange> again = into.act(what.value());
    return again ? Result<bool>(true) : Result<bool>(Error{again.error()});
  }
  const size_t bodies_before = bench.bodies().all.size();
  const Result<WholeStroke> stroke = read_stroke(document, step, bench);
  if (!stroke) return false;
  if (Status written = write_stroke(into, stroke.value(), was, bench, bodies_before); !written)
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
    const Result<bool> copied = copy_step(document, path.value()[i], *made.value(), bench);
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

}  // namespace kibori
