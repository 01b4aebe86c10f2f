// SPDX-License-Identifier: MIT
#include <kibori/run/documents.h>

#include <utility>

#include <kibori/base/file.h>
#include <kibori/body/body_surface.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/picture/picture.h>
#include <kibori/scene/stock_codec.h>
#include <kibori/surface/surface.h>

namespace kibori {

bool is_document(const std::filesystem::path& path) { return ending_of(path) == ".kibori"; }

Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model) {
  Bytes source;
  if (const std::filesystem::path* const named = file_of(scene.stock)) {
    const Result<std::vector<char>> file = read_file(*named);
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

std::vector<std::string> document_notes(const Document& document) {
  std::vector<std::string> notes;
  if (!document.missing().empty()) notes.push_back(document.missing());
  if (const std::string damage = document.damage();
      !damage.empty() && document.check_rows(document.head()))
    notes.push_back(document.name() + ": is a damaged document: " + damage +
                    "; run 'kibori verify' for details");
  return notes;
}

Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path,
                                                 std::vector<std::string>* notes) {
  Result<std::unique_ptr<Document>> document = Document::open(path, Document::Access::read);
  if (!document) return Error{document.error()};
  if (notes) *notes = document_notes(*document.value());
  return model_at_head(*document.value());
}

Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document) {
  Result<std::unique_ptr<TriDexel>> model = document.load_at(document.head());
  if (model) return model;
  const Result<StepId> whole = document.last_whole();
  if (!whole) return model;
  return Error{model.error() + "; it is undamaged up to step " + std::to_string(whole.value()) +
               " of " + std::to_string(document.head_in_file()) + ": 'kibori history " +
               document.name() + " --salvage NEW.kibori' saves that part"};
}

Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads,
                                           std::vector<std::string>* notes) {
  if (!is_document(path)) return read_mesh(path, notes);
  Result<std::unique_ptr<TriDexel>> model = document_model(path, notes);
  if (!model) return Error{model.error()};
  const Surface surface = extract_surface(model.value()->snapshot(), threads);
  if (surface.triangles.empty())
    return Error{sanitize_message(path.string()) +
                 ": there is no material left; undo the last step or choose an earlier one"};
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

Status keep_thumbnail(Document& document, StepId step, const BodyList& bodies,
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
  options.log = log_cut_of(materials);
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

}  // namespace kibori
