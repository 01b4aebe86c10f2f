// SPDX-License-Identifier: MIT
// Documents for scenes, models and pictures.
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

// True if the path ends in .kibori.
bool is_document(const std::filesystem::path& path);

// Creates a document of the stock, before the first move. The stock's own file is stored in it.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model);
// The same for a model from another source. That document cannot be carved at another pitch.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const std::vector<Material>& materials,
                                               const TriDexel& model);
// The material number of the document's stock; 0 if the document does not state it.
uint8_t document_material(const Document& document);

// Sentences about missing or damaged parts, although the rows of the head are intact.
std::vector<std::string> document_notes(const Document& document);
// The model at a document's head. Errors: damage. The message names the last intact step, and how
// to save up to it. `notes` receives document_notes.
Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path,
                                                 std::vector<std::string>* notes = nullptr);
Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document);
// A mesh file, or the surface of a document at its head. `notes` receives sentences about what was
// left out or may be missing.
Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads,
                                           std::vector<std::string>* notes = nullptr);

// The document's materials, from the last stroke or else from its stock. Empty if neither states
// them (before version 11). document_colors returns their colours.
std::vector<Material> document_materials(const Document& document);
std::vector<Rgb> document_colors(const Document& document);
// Draws a small picture of a step and stores it with the step. `bodies` is the step's state.
Status keep_thumbnail(Document& document, StepId step, const BodyList& bodies,
                      const std::vector<Material>& materials, int threads);
}  // namespace kibori
