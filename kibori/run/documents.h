// SPDX-License-Identifier: MIT
// Scenes and documents: what a scene carves written as one, and a document carved again.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/run/carving.h>
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
// Carves what is whole on the way to a document's head again, as a new one, with forces and
// versions; without pictures. Up to which step: the last whose stroke, and all before it, are
// whole. Errors: the path; not even the stock is whole.
Result<StepId> salvage(const Document& document, const std::filesystem::path& into);
// A mesh file, or the surface of a document at its head.
Result<TriangleMesh> read_mesh_or_document(const std::filesystem::path& path, int threads);

// Its materials, by the last stroke, or else by its stock; none where that does not say (before
// version 11). Their colours.
std::vector<Material> document_materials(const Document& document);
std::vector<Rgb> document_colors(const Document& document);
// A small picture of a step, kept with it. `bodies`: its state.
Status keep_thumbnail(Document& document, StepId step, const Bodies& bodies,
                      const std::vector<Material>& materials, int threads);
struct ReplayOptions {
  std::string to;                  // a version or step; by default the head
  std::optional<double> pitch_mm;  // of the model; by default as recorded
  std::optional<ForceLaw> law;     // by default as recorded
  CarveOptions carve;              // threads, progress, warnings
};

struct Replay {
  Carving carving;
  ForceLaw law;  // of the last stroke
  StepId to = 0;
  // The first step whose model is not what it was; only looked for at the recorded pitch.
  StepId differs = 0;
};

// Errors: those of the document; a stock that can't be made at another pitch.
Result<Replay> replay_document(const Document& document, const ReplayOptions& options);

// The steps and versions, one a line; the head is marked.
std::string history_text(const Document& document);
std::string history_json(const Document& document);

}  // namespace kibori
