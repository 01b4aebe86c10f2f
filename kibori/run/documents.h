// SPDX-License-Identifier: MIT
// Creates documents for scenes and models, and reads models, materials and meshes from documents.
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

// Creates a document of the stock, before the first move. If the stock comes from a file, the
// document stores the file's content. Errors: those of reading that file and of Document::create.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const Scene& scene, const TriDexel& model);
// The same for a model without a description of its stock. The document cannot be carved at another
// pitch.
Result<std::unique_ptr<Document>> new_document(const std::filesystem::path& path,
                                               const std::vector<Material>& materials,
                                               const TriDexel& model);
// The material number of the document's stock; 0 if the document does not state it.
uint8_t document_material(const Document& document);

// Sentences about missing steps of a document, and about damage that the path to its head does not
// contain. Damage on that path is an error of the functions that read the model.
std::vector<std::string> document_notes(const Document& document);
// The model at a document's head. `notes` receives document_notes. Errors: those of Document::open;
// damage. The message about damage names the last undamaged step and the command that saves it.
Result<std::unique_ptr<TriDexel>> document_model(const std::filesystem::path& path,
                                                 std::vector<std::string>* notes = nullptr);
// The same for an open document.
Result<std::unique_ptr<TriDexel>> model_at_head(const Document& document);
// Reads a mesh file, or the surface of a document at its head. `notes` receives sentences about
// parts that were left out or may be missing.
Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads,
                                           std::vector<std::string>* notes = nullptr);

// The materials of the last stroke on the path to the head, or else those of the stock. Empty if
// neither states them. document_colors returns their colours.
std::vector<Material> document_materials(const Document& document);
std::vector<Rgb> document_colors(const Document& document);
// Draws a small picture of a step and stores it with the step. `bodies` is the state after the
// step.
Status keep_thumbnail(Document& document, StepId step, const BodyList& bodies,
                      const std::vector<Material>& materials, int threads);
}  // namespace kibori
