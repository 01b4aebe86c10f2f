// SPDX-License-Identifier: MIT
#include "apps/studio/session/session.h"

#include <utility>

#include <kibori/base/file.h>
#include <kibori/run/documents.h>
#include <kibori/document/rescue.h>
#include <kibori/haptics/materials.h>
#include "apps/studio/session/history_viewer.h"
#include "apps/studio/session/live_session.h"

namespace kibori {
namespace {

constexpr int kSurfaceThreads = 2;

// The studio's woods and wax of early 2026 were 160 to 430 times too soft. New strokes use the
// built-in material of the same name. Older strokes keep the material that they were carved with.
void replace_soft_wood(Material& material) {
  constexpr struct {
    const char* name;
    double u;
  } kSoft[] = {{"limewood", 0.03}, {"oak", 0.06}, {"walnut", 0.05}, {"wax", 0.012}};
  for (const auto& soft : kSoft)
    if (material.name == soft.name && material.u == soft.u) {
      const auto color = material.color;
      material = *known_material(material.name);
      material.color = color;
    }
}

// Labels of body actions in the user interface.
struct Label {
  std::string operator()(const BodyCut&) const { return "Cut"; }
  std::string operator()(const BodyJoin&) const { return "Join"; }
  std::string operator()(const BodySubtract&) const { return "Subtract"; }
  std::string operator()(const BodyIntersect&) const { return "Intersect"; }
  std::string operator()(const BodySeparate&) const { return "Separate"; }
  std::string operator()(const BodyDuplicate&) const { return "Duplicate"; }
  std::string operator()(const BodyMirror&) const { return "Mirror"; }
  std::string operator()(const BodyMove&) const { return "Move"; }
  std::string operator()(const BodyBake&) const { return "Bake"; }
  std::string operator()(const BodyRemove&) const { return "Delete"; }
  std::string operator()(const BodyAdd&) const { return "Add"; }
  std::string operator()(const BodyProtect& verb) const {
    return verb.operation == SplineOperation::cut ? "Unmask" : "Mask";
  }
  std::string operator()(const BodySpline&) const { return "Spline"; }
  std::string operator()(const BodySet& verb) const {
    const BodyProperties& set = verb.properties;
    if (set.no_go) return *set.no_go ? "Protect" : "Unprotect";
    if (set.name) return "Name";
    if (set.visible) return *set.visible ? "Show" : "Hide";
    return set.locked.value_or(false) ? "Lock" : "Unlock";
  }
};

std::string label_of(const BodyAction& action) { return std::visit(Label{}, action.verb); }

}  // namespace

void Session::begin(Shown first, double removed_mm3) {
  shown_ = std::move(first);
  lattice_ = snapshot().lattice;
  volume_mm3_ = 0;
  for (const Body& body : shown_.bodies.all) {
    const double volume = body.model.volume_mm3();
    volume_mm3_ += volume;
    seen_.insert_or_assign(body.id, Seen{LiveSurface(body.model, kSurfaceThreads), volume});
  }
  stock_mm3_ = volume_mm3_ + removed_mm3;
}

const std::vector<Session::ChunkPlace>& Session::follow() {
  changed_.clear();
  if (!latest(shown_)) return changed_;
  volume_known_ = false;
  bodies_revision_++;
  for (auto at = seen_.begin(); at != seen_.end();)
    at = shown_.bodies.find(at->first) ? std::next(at) : seen_.erase(at);
  for (const Body& body : shown_.bodies.all) {
    const auto found = seen_.find(body.id);
    if (found == seen_.end()) {
      seen_.insert_or_assign(
          body.id, Seen{LiveSurface(body.model, kSurfaceThreads), body.model.volume_mm3()});
      continue;
    }
    const std::vector<Index3>& chunks = found->second.surface.update(body.model);
    for (const Index3& chunk : chunks) changed_.push_back({body.id, chunk});
    if (!chunks.empty() && body.id != shown_.active)
      found->second.volume_mm3 = body.model.volume_mm3();
  }
  return changed_;
}

const LiveSurface* Session::surface(BodyId body) const {
  const auto found = seen_.find(body);
  return found == seen_.end() ? nullptr : &found->second.surface;
}

double Session::volume_mm3(BodyId body) const {
  const auto found = seen_.find(body);
  return found == seen_.end() ? 0 : found->second.volume_mm3;
}

const std::vector<LiveTick>& Session::ticks() {
  ticks_.clear();
  LiveTick tick;
  bool cut = false;
  while (next_tick(tick)) {
    volume_mm3_ -= tick.removed_mm3 + tick.fallen_mm3;
    cut |= tick.removed_mm3 != 0;
    ticks_.push_back(tick);
  }
  if (!ticks_.empty()) cutting_ = cut;
  return ticks_;
}

const HistoryState& Session::history() {
  update_history();
  count_volume();
  return history_;
}

void Session::count_volume() {
  if (volume_known_ || busy()) return;
  seen_.at(shown_.active).volume_mm3 = snapshot().volume_mm3();
  volume_mm3_ = 0;
  for (const auto& [id, seen] : seen_) volume_mm3_ += seen.volume_mm3;
  volume_known_ = true;
  bodies_revision_++;
}

void Session::name_version(const std::string&) {
  notify(Error{"the document is open read-only, so its versions cannot be named"});
}

Result<std::unique_ptr<Session>> open_session(const std::filesystem::path& file,
                                              const SessionOptions& options) {
  auto document =
      Document::open(file, options.read_only ? Document::Access::read : Document::Access::write);
  if (!document) {
    // A damaged document is shown, and not written.
    auto damaged = Document::open(file, Document::Access::read);
    if (!damaged || damaged.value()->damage().empty()) return Error{document.error()};
    return HistoryViewer::at_last_whole(file, std::move(damaged).value(), document.error());
  }
  std::string missing;
  for (const std::string& note : document_notes(*document.value()))
    missing += (missing.empty() ? "" : "; ") + note;
  if (options.read_only) {
    auto at_head = document.value()->load_bodies(document.value()->head());
    if (!at_head)
      return HistoryViewer::at_last_whole(file, std::move(document).value(), at_head.error());
    return HistoryViewer::make(std::move(document).value(), std::move(at_head).value(), missing);
  }
  auto model = document.value()->load();
  if (!model) return HistoryViewer::at_last_whole(file, std::move(document).value(), model.error());
  Scene scene;
  scene.materials = document_materials(*document.value());
  if (scene.materials.empty()) scene.materials = known_materials();
  for (Material& material : scene.materials) replace_soft_wood(material);
  scene.tools = {BallTool{4}};
  if (const auto last = document.value()->settings(document.value()->head()))
    scene.tools = {last.value().tool};
  scene.stock.material = document_material(*document.value());
  return LiveSession::make(std::move(document).value(), std::move(model).value(), scene, options,
                           missing);
}

Result<std::unique_ptr<Session>> create_session(const std::filesystem::path& file,
                                                const Scene& scene, const SessionOptions& options) {
  if (options.read_only)
    return Error{
        sanitize_message(file.string()) +
        ": there is no such document, and this studio is read-only; start it without --read-only"};
  auto model = make_stock(scene.stock, scene.file, {});
  if (!model) return Error{model.error()};
  auto document = new_document(file, scene, *model.value());
  if (!document) return Error{document.error()};
  auto session =
      LiveSession::make(std::move(document).value(), std::move(model).value(), scene, options, {});
  if (!session) remove_document(file);
  return session;
}

PastStep PastSteps::of(const Document& document, const Step& step) {
  const auto [seen, fresh] = settings_.try_emplace(step.setting);
  auto& [tool, mode] = seen->second;
  if (fresh && !step.stock) {
    if (const auto settings = document.settings(step.id)) {
      // If the first hand only moved, the step has the second hand's tool and mode.
      const StrokeSettings& s = settings.value();
      const bool second = s.mode == Mode::off && s.second;
      tool = second ? s.second->tool : s.tool;
      mode = second ? s.second->mode : s.mode;
    }
  }
  std::string label = step.label;
  if (step.action && label.empty())
    if (const auto action = document.action(step.id)) label = label_of(action.value());
  return {step.id, step.parent, step.removed_mm3, step.made_s, tool, mode, step.pictured, label};
}

double removed_until(const Document& document, StepId step) {
  double sum = 0;
  if (const auto path = document.path_to(step))
    for (const StepId id : path.value()) sum += document.steps().at(id).removed_mm3;
  return sum;
}

}  // namespace kibori
