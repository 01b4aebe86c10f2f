// SPDX-License-Identifier: MIT
// Converts the contents of a document (tiles, ticks, settings) to bytes or JSON and back. The
// functions check everything that they read, because a file may be malicious. docs/documents.md
// describes the formats. The studio sends tools to its pages in the same form. Internal: not
// installed.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/hash.h>
#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

// Convert a tool to JSON and back: {"shape":"ball","radius":3}. Settings and the studio's messages
// use this form. Errors: the text is not JSON, or not a tool that check_tool accepts.
std::string tool_to_json(const Tool& tool);
Result<Tool> tool_from_json(const std::string& text);

// Convert the settings of a stroke to JSON and back. Errors: the text is not JSON, or the settings
// are invalid.
std::string settings_to_json(const StrokeSettings& settings);
Result<StrokeSettings> settings_from_json(const std::string& text);

// Convert materials to JSON and back, in the form that settings use.
std::string materials_to_json(const std::vector<Material>& materials);
Result<std::vector<Material>> materials_from_json(const std::string& text);

// Convert a lattice and a box to JSON and back.
std::string lattice_to_json(const Lattice& lattice);
Result<Lattice> lattice_from_json(const std::string& text);
std::string box_to_json(const LatticeBox& box);
Result<LatticeBox> box_from_json(const std::string& text);
// Returns the hash of a tile's bytes, as documents store it.
int64_t hash_of(const Bytes& bytes);
// The tables with one row for each flush of a stroke. A seal has their hashes in this order.
enum class BlockTable { tick, force, given };
constexpr Names<3> names_of(BlockTable) { return {"tick", "force", "given"}; }
// Adds a row of such a table to the hash of a step's rows.
void add_block(Hash& hash, int64_t sequence, int64_t count, const Bytes& data);

// Convert ticks to bytes and back. The ticks are stored as columns, compressed by zstd. In a
// column, each double is XORed with the one before. The column has the lowest bytes of all values
// first, then the next higher bytes, and so on.
Bytes encode_ticks(const RecordedTick* ticks, size_t count);
Result<std::vector<RecordedTick>> decode_ticks(const Bytes& bytes);

// Convert forces to bytes and back, with the same encoding.
Bytes encode_forces(const Wrench* computed, size_t count);
Result<std::vector<Wrench>> decode_forces(const Bytes& bytes);

// Convert a pose to bytes and back. Errors: the data has the wrong size, or the pose is invalid.
Bytes encode_pose(const Pose& pose);
Result<Pose> decode_pose(const Bytes& bytes);

// Returns the planes of a tile, compressed by zstd. The bytes depend only on the content, not on
// the memory layout.
Bytes encode_tile(const Tile& tile);
// Decodes a tile into a place of a field that must be empty. Errors: the data is not a valid tile.
Status decode_tile(const Bytes& bytes, Field& field, int tu, int tv);

}  // namespace kibori
