// SPDX-License-Identifier: MIT
#include <kibori/run/documents.h>
#include <kibori/body/body_surface.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/document/rescue.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include <nlohmann/json.hpp>

#include <kibori/base/file.h>
#include <kibori/body/bodies.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/picture/picture.h>
#include <kibori/scene/stock_codec.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

using Json = nlohmann::json;

Result<std::unique_ptr<TriDexel>> stock_again(const Document& document, const std::string& text,
                                              double pitch_mm, const CarveOptions& options) {
  Result<Stock> stock = stock_from_json(text);
  if (!stock) return Error{document.name() + ": " + stock.error()};
  stock.value().pitch_mm = pitch_mm;
  const StockOptions how{options.threads, options.force, options.warning};
  if (!has_file(stock.value())) return make_stock(stock.value(), document.name(), how);
  Result<Bytes> source = document.source();
  if (!source) return Error{source.error()};
  const auto folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const std::filesystem::path path =
      folder.value()->path() / ("stock" + ending_of(stock.value().mesh_path));
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(source.value().data()),
             static_cast<std::streamsize>(source.value().size()));
  file.close();
  if (!file)
    return Error{document.name() + ": its stock's file can't be put into the temporary folder"};
  stock.value().mesh_path = path;
  return make_stock(stock.value(), document.name(), how);
}

}  // namespace

bool is_document(const std::filesystem::path& path) { return ending_of(path) == ".kibori"; }

Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model) {
  Bytes source;
  if (has_file(scene.stock)) {
    const Result<std::vector<char>> file = read_file(scene.stock.mesh_path);
    if (!file) return Error{file.error()};
    source.assign(file.value().begin(), file.value().end());
  }
  return Document::create(
      path, model, stock_to_json(scene.stock, scene.moves.front().label, scene.materials), source);
}

Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const std::vector<Material>& materials,
                                               const TriDexel& model) {
  return Document::create(path, model, stock_to_json(materials));
}

uint8_t document_material(const Document& document) {
  const Result<std::string> text = document.stock();
  const Result<Stock> stock = stock_from_json(text ? text.value() : std::string());
  return stock ? stock.value().material : uint8_t{0};
}

Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path) {
  Result<std::unique_ptr<Document>> document = Document::open(path, Document::Access::read);
  if (!document) return Error{document.error()};
  return model_at_head(*document.value());
}

Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document) {
  Result<std::unique_ptr<TriDexel>> model = document.load_at(document.head());
  if (model) return model;
  const Result<StepId> whole = document.last_whole();
  if (!whole || whole.value() == document.head()) return model;
  return Error{model.error() + "; it is whole up to step " + std::to_string(whole.value()) +
               " of " + std::to_string(document.head()) + ": 'kibori history " + document.name() +
               " --salvage NEW.kibori' saves that"};
}

Result<StepId> salvage(const Document& document, const std::filesystem::path& into) {
  Result<StepId> end = document.last_whole();
  if (!end) return end;
  const Result<std::vector<StepId>> way = document.path_to(end.value());
  if (!way) return Error{way.error()};
  Result<std::unique_ptr<TriDexel>> loaded = document.load_at(way.value().front());
  if (!loaded) return Error{loaded.error()};
  TriDexel& model = *loaded.value();
  Workbench bench(model);
  const Result<std::string> stock = document.stock();
  const Result<Bytes> source = document.source();
  if (!stock) return Error{stock.error()};
  if (!source) return Error{source.error()};
  Result<std::unique_ptr<Document>> made =
      Document::create(into, model, stock.value(), source.value());
  if (!made) return Error{made.error()};
  // A step of the damaged one, if all of it is whole; the model is then as it was after it.
  struct Kept {
    StrokeSettings settings;
    Pose start;
    std::vector<StrokeTick> ticks;
    std::vector<Wrench> felt, given;
  };
  const auto read = [&](StepId step) -> Result<Kept> {
    Kept kept;
    const Result<StrokeSettings> settings = document.settings(step);
    if (!settings) return Error{settings.error()};
    kept.settings = settings.value();
    const Result<Pose> start = document.start(step);
    if (!start) return Error{start.error()};
    kept.start = start.value();
    Status done = document.for_ticks(step, [&](const std::vector<StrokeTick>& ticks) -> Status {
      kept.ticks.insert(kept.ticks.end(), ticks.begin(), ticks.end());
      return Ok{};
    });
    const auto gather = [](std::vector<Wrench>& all) {
      return [&all](const std::vector<Wrench>& some) -> Status {
        all.insert(all.end(), some.begin(), some.end());
        return Ok{};
      };
    };
    if (done) done = document.for_forces(step, gather(kept.felt));
    if (done) done = document.for_given(step, gather(kept.given));
    if (done) done = document.replay(step, bench, std::nullopt, {});
    const Step& was = document.steps().at(step);
    if (done && was.finished && bench.bodies().content_hash() != was.hash)
      done = Error{"it is not what it was"};
    return done ? Result<Kept>(std::move(kept)) : Result<Kept>(Error{done.error()});
  };
  StepId saved = way.value().front();
  for (size_t i = 1; i < way.value().size(); i++) {
    const StepId step = way.value()[i];
    const Step& was = document.steps().at(step);
    const size_t bodies_before = bench.bodies().all.size();
    if (was.action) {
      const Result<BodyAction> what = document.action(step);
      const Result<BodyChange> done = what ? bench.act(what.value()) : Error{what.error()};
      if (!done || bench.bodies().content_hash() != was.hash) break;
      if (const Result<BodyChange> again = made.value()->act(what.value()); !again) {
        made.value().reset();
        remove_document(into);
        return Error{again.error()};
      }
      saved = step;
      continue;
    }
    const Result<Kept> kept = read(step);
    if (!kept) break;  // up to here
    const auto& [settings_then, start_then, ticks, felt, given] = kept.value();
    Status written = made.value()->begin(settings_then, start_then, was.label);
    for (size_t k = 0; k < ticks.size(); k++)
      made.value()->add(ticks[k], felt.size() == ticks.size() ? &felt[k] : nullptr,
                        given.size() == ticks.size() ? &given[k] : nullptr);
    // What the stroke severed stands at the end of the list.
    std::vector<Portion> severed;
    for (size_t k = bodies_before; k < bench.bodies().all.size(); k++)
      severed.push_back({bench.bodies().all[k].model, bench.bodies().all[k].material_bounds});
    if (written) written = made.value()->finish(model, was.removed_mm3, severed);
    if (!written) {
      made.value().reset();
      remove_document(into);
      return Error{written.error()};
    }
    saved = step;
    for (const auto& [name, named] : document.versions())
      if (named == step) static_cast<void>(made.value()->name_version(name, made.value()->head()));
  }
  if (const std::string where = settle(*made.value()); !where.empty()) return Error{where};
  return saved;
}

Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads) {
  if (!is_document(path)) return read_mesh(path);
  Result<std::unique_ptr<TriDexel>> model = document_model(path);
  if (!model) return Error{model.error()};
  const Surface surface = extract_surface(model.value()->snapshot(), threads);
  if (surface.triangles.empty())
    return Error{sanitize_message(path.string()) + ": there is no material left"};
  TriangleMesh mesh;
  mesh.vertices.reserve(surface.vertices.size());
  for (const SurfaceVertex& v : surface.vertices)
    mesh.vertices.emplace_back(v.position[0], v.position[1], v.position[2]);
  mesh.triangles.assign(surface.triangles.begin(), surface.triangles.end());
  return mesh;
}

std::vector<Material> document_materials(const Document& document) {
  for (StepId at = document.head(); at != 0; at = document.steps().at(at).parent)
    if (const Result<StrokeSettings> settings = document.settings(at))
      return settings.value().materials;
  const Result<std::string> text = document.stock();
  return text ? stock_materials(text.value()) : std::vector<Material>();
}

std::vector<Rgb> document_colors(const Document& document) {
  std::vector<Rgb> colors;
  for (const Material& material : document_materials(document)) colors.push_back(material.color);
  return colors;
}

Status keep_thumbnail(Document& document, StepId step, const Bodies& bodies,
                      const std::vector<Material>& materials, int threads) {
  const Surface surface = surface_of(bodies.all, threads);
  if (surface.triangles.empty()) return Ok{};
  std::vector<std::array<uint8_t, 3>> colors;
  colors.reserve(materials.size());
  PictureOptions options;
  for (const Material& m : materials) {
    colors.push_back(m.color);
    options.contrasts.push_back(ring_contrast(m.name));
  }
  options.width = 256;
  options.height = 192;
  options.samples = 16;
  options.threads = threads;
  const Result<Image> image = draw_picture(surface, colors, options);
  if (!image) return Error{image.error()};
  const Result<Bytes> png =
      png_rgb(image.value().width, image.value().height, image.value().pixels);
  if (!png) return Error{png.error()};
  return document.set_thumbnail(step, png.value());
}

Result<Replay> replay_document(const Document& document, const ReplayOptions& options) {
  Replay replay;
  replay.to = document.head();
  if (!options.to.empty()) {
    const Result<StepId> to = document.find(options.to);
    if (!to) return Error{to.error()};
    replay.to = to.value();
  }
  const Result<std::vector<StepId>> path = document.path_to(replay.to);
  if (!path) return Error{path.error()};
  Result<std::string> text = document.stock();
  if (!text) return Error{text.error()};
  const bool as_recorded = !options.pitch_mm || *options.pitch_mm == document.lattice().pitch_mm;
  Carving& carving = replay.carving;
  Result<std::unique_ptr<TriDexel>> model =
      as_recorded ? document.load_at(path.value().front())
                  : stock_again(document, text.value(), *options.pitch_mm, options.carve);
  if (!model) return Error{model.error()};
  carving.model = std::move(model).value();
  if (std::string label = stock_label(text.value()); !label.empty())
    carving.marks.push_back({std::move(label), 0});

  Workbench bench(*carving.model);
  int64_t total = 0, of_rate = 0;
  for (const StepId id : path.value()) total += document.steps().at(id).ticks;
  double rate_hz = 0, base_s = 0;  // ticks are counted since the rate last changed
  std::vector<double> step_us;
  CarveSummary& summary = carving.summary;
  for (const StepId id : path.value()) {
    const Step& step = document.steps().at(id);
    if (step.stock) continue;
    if (step.action) {
      if (const Status done = document.replay(id, bench, std::nullopt, {}); !done)
        return Error{done.error()};
      summary.removed_mm3 += as_recorded ? step.removed_mm3 : 0;
      if (as_recorded && replay.differs == 0 && bench.bodies().content_hash() != step.hash)
        replay.differs = id;
      continue;
    }
    const Result<StrokeSettings> settings = document.settings(id);
    if (!settings) return Error{settings.error()};
    const StrokeSettings& s = settings.value();
    if (s.rate_hz != rate_hz) {
      if (rate_hz > 0) base_s += static_cast<double>(std::exchange(of_rate, 0)) / rate_hz;
      rate_hz = s.rate_hz;
    }
    const auto time = [&] { return base_s + static_cast<double>(of_rate) / rate_hz; };
    const ForceLaw law = options.law.value_or(s.force.law);
    replay.law = law;
    auto last = std::chrono::steady_clock::now();
    const Status done = document.replay(id, bench, options.law, [&](const ReplayedTick& tick) {
      const auto now = std::chrono::steady_clock::now();
      step_us.push_back(std::chrono::duration<double, std::micro>(now - last).count());
      ToolTick result = tick.result;
      if (tick.recorded->put) return;
      if (tick.recorded->second) {
        add_tick(summary, s.second->mode, result);
        // Beside the first hand's, which came before.
        if (!carving.trace.empty())
          carving.trace.back().second = std::make_shared<ToolTick>(result);
        return;
      }
      of_rate++;
      summary.ticks++;
      add_tick(summary, s.mode, result);
      carving.trace.push_back({time(), result});
      if (options.carve.progress && summary.ticks % 64 == 0)
        options.carve.progress(static_cast<double>(summary.ticks) / static_cast<double>(total));
      last = std::chrono::steady_clock::now();
    });
    if (!done) return Error{done.error()};
    if (!step.label.empty()) carving.marks.push_back({step.label, time()});
    if (as_recorded && replay.differs == 0 && step.finished &&
        bench.bodies().content_hash() != step.hash)
      replay.differs = id;
  }
  carving.bodies = bench.bodies();
  summarize(carving, std::move(step_us));
  if (options.carve.progress) options.carve.progress(1);
  return replay;
}

namespace {

std::string what_was_done(const Document& document, StepId step) {
  const Result<BodyAction> action = document.action(step);
  if (!action) return "bodies";
  std::string text(verb_of(action.value()));
  if (action.value().bodies.empty()) return text;
  text += action.value().bodies.size() > 1 ? " bodies" : " body";
  for (const BodyId id : action.value().bodies) text.append(" ").append(std::to_string(id));
  return text;
}

}  // namespace

std::string history_text(const Document& document) {
  std::string text = "   step  after      ticks  removed mm3  label\n";
  for (const auto& [id, step] : document.steps()) {
    char line[200];
    std::snprintf(line, sizeof line, "%c %5lld  %5s %10lld %12.6g  ",
                  id == document.head() ? '*' : ' ', static_cast<long long>(id),
                  step.stock ? "-" : std::to_string(step.parent).c_str(),
                  static_cast<long long>(step.ticks), step.removed_mm3);
    text += line + sanitize_message(step.stock    ? "the stock"
                                    : step.action ? what_was_done(document, id)
                                                  : step.label);
    for (const auto& [name, at] : document.versions())
      if (at == id) text += "  [" + sanitize_message(name) + "]";
    if (!step.finished) text += "  (still being made)";
    text += "\n";
  }
  return text;
}

std::string history_json(const Document& document) {
  Json steps = Json::array(), versions = Json::object();
  for (const auto& [id, step] : document.steps()) {
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(step.hash));
    steps.push_back({{"step", id},
                     {"after", step.stock ? Json() : Json(step.parent)},
                     {"ticks", step.ticks},
                     {"removed_mm3", step.removed_mm3},
                     {"label", step.action ? what_was_done(document, id) : step.label},
                     {"kind", step.stock    ? "stock"
                              : step.action ? "bodies"
                                            : "stroke"},
                     {"finished", step.finished},
                     {"state_hash", hash}});
    if (!step.action) continue;
    if (const Result<BodyAction> action = document.action(id))
      steps.back()["action"] = Json::parse(action_to_json(action.value()));
  }
  for (const auto& [name, at] : document.versions()) versions[name] = at;
  return Json{{"head", document.head()}, {"steps", steps}, {"versions", versions}}.dump(
             2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace kibori
