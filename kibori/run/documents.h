// SPDX-License-Identifier: MIT
// Creates documents of scenes and models. Reads models, materials and meshes from documents.
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

// Returns true if the path ends in .kibori.
bool is_document(const std::filesystem::path& path);

// Creates a document that has the stock and no strokes. If the stock comes from a file, the
// document stores the content of the file. Errors: the file cannot be read; those of
// Document::create.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model);
// Like above, for a model without a description of its stock. The document cannot be carved again
// at another pitch.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const std::vector<Material>& materials,
                                               const TriDexel& model);
// Returns the material number of the document's stock. Returns 0 if the document does not have it.
uint8_t document_material(const Document& document);

// Returns sentences about missing steps of a document, and about damage that is not on the path to
// its head. (Damage on this path is an error of the functions that read the model.)
std::vector<std::string> document_notes(const Document& document);
// Returns the model at a document's head. `notes` receives document_notes(). Errors: those of
// Document::open; the document is damaged. The message about damage names the last undamaged step,
// and the command that saves the steps up to it.
Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path,
                                                 std::vector<std::string>* notes = nullptr);
// Like above, for an open document.
Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document);
// Reads a mesh file, or the surface of a document at its head. `notes` receives sentences about
// parts that were left out or may be missing. Errors: those of read_mesh and document_model; the
// document has no material left.
Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads,
                                           std::vector<std::string>* notes = nullptr);

// Returns the materials of the last stroke on the path to the head. If there is no stroke, returns
// the materials of the stock, or nothing. document_colors() returns the colours of these materials.
std::vector<Material> document_materials(const Document& document);
std::vector<Rgb> document_colors(const Document& document);
// Draws a small picture of a step, and stores it with the step. `bodies` is the state after the
// step.
Status keep_thumbnail(Document& document, StepId step, const BodyList& bodies,
                      const std::vector<Material>& materials, int threads);
}  // namespace kibori
