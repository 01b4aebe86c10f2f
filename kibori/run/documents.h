// SPDX-License-Identifier: MIT
// Documents as scenes, models and pictures see them.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/scene/scene.h>
#include <kibori/document/document.h>
#include <kibori/formats/surface_file.h>

namespace kibori {

// By its ending, .kibori.
bool is_document(const std::filesystem::path& path);

// A document of the stock, before the first move; the stock's own file goes in with it.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model);
// The same of a model that came otherwise: it can't be carved at another pitch.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const std::vector<Material>& materials,
                                               const TriDexel& model);
// What the document's stock is of: a number of its materials; 0 where it does not say.
uint8_t document_material(const Document& document);

// The model at a document's head. Errors: damage, with the last step that is whole and how to save
// up to it.
Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path);
Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document);
// A mesh file, or the surface of a document at its head.
Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads);

// Its materials, by the last stroke, or else by its stock; none where that does not say (before
// version 11). Their colours.
std::vector<Material> document_materials(const Document& document);
std::vector<Rgb> document_colors(const Document& document);
// A small picture of a step, kept with it. `bodies`: its state.
Status keep_thumbnail(Document& document, StepId step, const Bodies& bodies,
                      const std::vector<Material>& materials, int threads);
}  // namespace kibori
