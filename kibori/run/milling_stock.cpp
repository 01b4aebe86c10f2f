// SPDX-License-Identifier: MIT
#include <kibori/formats/mesh_file.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling.h>
#include <kibori/scene/stock.h>

namespace kibori {
namespace {

using Made = Result<std::unique_ptr<TriDexel>>;

Made make_block(const Box& box, const MillStockOptions& options) {
  // One cell of room, so that the surface is complete at the block's faces.
  Result<Lattice> lattice = make_lattice(box.size(), options.pitch_mm, options.pitch_mm);
  if (!lattice) return Error{"stock: " + lattice.error()};
  lattice.value().origin_mm += box.min;
  if (const Status fits = check_memory(lattice.value(), false); !fits)
    return Error{"stock: " + fits.error()};
  auto model = std::make_unique<TriDexel>(lattice.value());
  model->fill_block(box, options.material);
  return model;
}

Made read_mesh_stock(const std::filesystem::path& path, const MillStockOptions& options) {
  std::vector<std::string> notes;
  const Result<TriangleMesh> mesh = read_mesh(path, &notes);
  if (!mesh) return Error{mesh.error()};
  Result<MeshStock> stock = stock_of_mesh(mesh.value(), options.pitch_mm, options.pitch_mm,
                                          options.material, options.threads, false);
  if (!stock) return Error{path.string() + ": " + stock.error()};
  if (const std::string warning = stock.value().warning(); !warning.empty())
    notes.push_back(warning);
  for (const std::string& note : notes)
    if (options.warning) options.warning(path.string() + ": " + note);
  return std::move(stock.value().model);
}

}  // namespace

Made make_mill_stock(const MillStock& stock, const MillStockOptions& options) {
  if (const Box* const box = std::get_if<Box>(&stock)) return make_block(*box, options);
  const auto& path = std::get<std::filesystem::path>(stock);
  return is_document(path) ? document_model(path) : read_mesh_stock(path, options);
}

}  // namespace kibori
