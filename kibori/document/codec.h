// SPDX-License-Identifier: MIT
// What a document holds, as bytes and back: tiles, ticks of a stroke, settings. Everything read is
// checked, as files are hostile until parsed. docs/documents.md describes the formats. Internal:
// not installed; the studio sends tools to its pages in the same form.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

// A tool as it stands in settings, and in the studio's messages: {"shape":"ball","radius":3}.
// Errors: what is no JSON, no tool, or refused by check_tool.
std::string tool_to_json(const Tool& tool);
Result<Tool> tool_from_json(const std::string& text);

std::string settings_to_json(const StrokeSettings& settings);
Result<StrokeSettings> settings_from_json(const std::string& text);

// Materials as settings have them.
std::string materials_to_json(const std::vector<Material>& materials);
Result<std::vector<Material>> materials_from_json(const std::string& text);

// Where the rays are, and a box; both as JSON.
std::string lattice_to_json(const Lattice& lattice);
Result<Lattice> lattice_from_json(const std::string& text);
std::string box_to_json(const LatticeBox& box);
Result<LatticeBox> box_from_json(const std::string& text);
// Of a tile's bytes, as it stands in documents.
int64_t hash_of(const Bytes& bytes);

// zstd over columns: each coordinate's doubles XORed with the one before, byte by byte of
// significance.
Bytes encode_ticks(const StrokeTick* ticks, size_t count);
Result<std::vector<StrokeTick>> decode_ticks(const Bytes& bytes);

// As ticks.
Bytes encode_forces(const Wrench* felt, size_t count);
Result<std::vector<Wrench>> decode_forces(const Bytes& bytes);

Bytes encode_pose(const Pose& pose);
Result<Pose> decode_pose(const Bytes& bytes);

// zstd over planes. Of a tile's storage only the content is kept.
Bytes encode_tile(const Tile& tile);
// Into an empty place of a field.
Status decode_tile(const Bytes& bytes, Field& field, int tu, int tv);

}  // namespace kibori
