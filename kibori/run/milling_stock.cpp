// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/formats/mesh_file.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling.h>
#include <kibori/scene/stock.h>

namespace kibori {
namespace {

using Made = Result<std::unique_ptr<TriDexel>>;

// A box that reaches beyond a cell by less than this counts as within it [cells].
constexpr double kRounding = 1e-6;

// Extends a lattice by whole cells, so that it contains the box and one cell of space around it.
Status extend(Lattice& lattice, const std::optional<Box>& box) {
  if (!box) return Ok{};
  const Box at = lattice.to_lattice(*box).units;
  for (int axis = 0; axis < 3; axis++) {
    const double below = std::max(0.0, std::ceil(1 - at.min[axis] - kRounding));
    const double above =
        std::max(0.0, std::ceil(at.max[axis] + 1 - lattice.nodes[axis] - kRounding));
    const double nodes = lattice.nodes[axis] + below + above;
    if (!(nodes <= kMaxNodesPerAxis)) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "the stock with its fixtures and target needs %.0f cells along %c, and the "
                    "limit is %d; use a coarser pitch",
                    nodes, "xyz"[axis], kMaxNodesPerAxis);
      return Error{text};
    }
    lattice.origin_mm[axis] -= below * lattice.pitch_mm;
    lattice.nodes[axis] = static_cast<int>(nodes);
  }
  return check_memory(lattice, false);
}

Made make_block(const Box& box, const MillStockOptions& options) {
  // One cell of space around the block, so that the surface at its faces is complete.
  Result<Lattice> lattice = make_lattice(box.size(), options.pitch_mm, options.pitch_mm);
  if (!lattice) return Error{"stock: " + lattice.error()};
  lattice.value().origin_mm += box.min;
  if (const Status fits = check_memory(lattice.value(), false); !fits)
    return Error{"stock: " + fits.error()};
  if (const Status fits = extend(lattice.value(), options.holds); !fits) return Error{fits.error()};
  auto model = std::make_unique<TriDexel>(lattice.value());
  model->fill_block(box, options.material);
  return model;
}

Made read_mesh_stock(const std::filesystem::path& path, const MillStockOptions& options) {
  std::vector<std::string> notes;
  const Result<TriangleMesh> mesh = read_mesh(path, &notes);
  if (!mesh) return Error{mesh.error()};
  const Box box = mesh.value().bounds();
  Result<Lattice> lattice = make_lattice(box.size(), options.pitch_mm, options.pitch_mm);
  if (!lattice) return Error{path.string() + ": " + lattice.error()};
  lattice.value().origin_mm += box.min;
  if (const Status fits = extend(lattice.value(), options.holds); !fits) return Error{fits.error()};
  Result<MeshStock> stock =
      stock_of_mesh(mesh.value(), lattice.value(), options.material, options.threads, false);
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
  if (!is_document(path)) return read_mesh_stock(path, options);
  Made model = document_model(path);
  if (!model || !options.holds) return model;
  const Lattice& lattice = model.value()->lattice();
  const Box at = lattice.to_lattice(*options.holds).units.grown(1 - kRounding),
            room = lattice.whole().units;
  if ((at.min.array() < room.min.array()).any() || (at.max.array() > room.max.array()).any())
    return Error{path.string() +
                 ": the fixtures or the target reach beyond the document's lattice; give the stock "
                 "as a mesh (kibori convert makes one)"};
  return model;
}

}  // namespace kibori
