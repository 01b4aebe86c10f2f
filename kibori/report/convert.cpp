// SPDX-License-Identifier: MIT
#include <kibori/report/convert.h>

#include <algorithm>

#include <kibori/body/body_surface.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/scene/stock.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/surface/simplify.h>
#include <kibori/surface/surface.h>

namespace kibori {

namespace {

// The model at a document's head. If `options` sets a pitch other than the document's, all strokes
// are carved again at that pitch.
Result<Converted> of_document(const std::filesystem::path& in, const ConvertOptions& options) {
  const Result<std::unique_ptr<Document>> document = Document::open(in, Document::Access::read);
  if (!document) return Error{document.error()};
  if (options.warning)
    for (const std::string& note : document_notes(*document.value())) options.warning(note);
  ReplayOptions replay;
  replay.pitch_mm = options.pitch_mm;
  replay.carve.threads = options.threads;
  replay.carve.warning = options.warning;
  Converted converted;
  if (options.pitch_mm && *options.pitch_mm != document.value()->lattice().pitch_mm) {
    Result<Replay> carved = replay_document(*document.value(), replay);
    if (!carved) return Error{carved.error()};
    converted.model = std::move(carved.value().carving.model);
  } else {
    Result<std::unique_ptr<TriDexel>> model = model_at_head(*document.value());
    if (!model) return Error{model.error()};
    converted.model = std::move(model).value();
  }
  converted.pitch_mm = converted.model->lattice().pitch_mm;
  return converted;
}

}  // namespace

Result<Converted> into_dexels(const std::filesystem::path& in, const ConvertOptions& options) {
  if (is_document(in)) return of_document(in, options);
  Result<TriangleMesh> mesh = Error{};
  std::vector<std::string> notes;
  if (options.relief) {
    const double pitch = options.pitch_mm.value_or(options.relief->width_mm / 256);
    mesh = read_relief(in, *options.relief, pitch);
  } else {
    mesh = read_mesh(in, &notes);
  }
  if (!mesh) return Error{mesh.error()};
  if (options.warning)
    for (const std::string& note : notes) options.warning(note);
  const double longest = mesh.value().bounds().size().maxCoeff();
  if (!(longest > 0)) return Error{in.string() + ": has no extent"};
  Converted converted;
  converted.pitch_mm = options.pitch_mm.value_or(longest / 256);
  converted.triangles_in = mesh.value().triangles.size();
  Result<MeshStock> stock = stock_of_mesh(mesh.value(), converted.pitch_mm, 2 * converted.pitch_mm,
                                          0, options.threads, options.force);
  if (!stock) return Error{in.string() + ": " + stock.error()};
  const std::string warning = stock.value().warning();
  if (!warning.empty() && options.warning) options.warning(in.string() + ": " + warning);
  converted.model = std::move(stock.value().model);
  if (converted.model->empty())
    return Error{in.string() + ": has no material at this pitch; use a finer one"};
  return converted;
}

namespace {

// Sends the surface of a model and counts its triangles.
void send_model(const Snapshot& model, double tolerance_mm, int threads, const SurfaceSink& sink,
                size_t& triangles) {
  const SurfaceSink counting = [&](const SurfacePart& part) {
    triangles += part.triangles.size();
    sink(part);
  };
  if (tolerance_mm > 0)
    send_surface(simplify(extract_surface(model, threads), tolerance_mm), counting);
  else
    stream_surface(model, threads, counting);
}

}  // namespace

Result<size_t> write_model(const std::filesystem::path& out, const Snapshot& model,
                           std::span<const Rgb> colors, double tolerance_mm, int threads) {
  size_t triangles = 0;
  const SurfaceSource source = [&](const SurfaceSink& sink) {
    send_model(model, tolerance_mm, threads, sink, triangles);
  };
  if (const Status written = write_surface(out, source, colors); !written)
    return Error{written.error()};
  return triangles;
}

Result<size_t> write_bodies(const std::filesystem::path& out, std::span<const Body> bodies,
                            std::span<const Rgb> colors, double tolerance_mm, int threads) {
  size_t triangles = 0;
  std::vector<SurfaceObject> objects;
  for (const Body& body : bodies) {
    if (!is_shown(body, bodies)) continue;
    objects.push_back({body.name, body.pose, [&, model = body.model](const SurfaceSink& sink) {
                         send_model(model, tolerance_mm, threads, sink, triangles);
                       }});
  }
  if (const Status written = write_objects(out, objects, colors); !written)
    return Error{written.error()};
  return triangles;
}

}  // namespace kibori
