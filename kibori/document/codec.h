// SPDX-License-Identifier: MIT
// Converts the contents of a document to bytes and back: tiles, ticks of a stroke, settings.
// Everything that is read is checked, because a file may be malicious.
// docs/documents.md describes the formats. Internal: not installed. The studio sends tools to its
// pages in the same form.
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

// A tool as JSON in settings and in the studio's messages: {"shape":"ball","radius":3}. Errors:
// text that is not JSON, not a tool, or a tool that check_tool rejects.
std::string tool_to_json(const Tool& tool);
Result<Tool> tool_from_json(const std::string& text);

// A stroke's settings as JSON. Errors: text that is not JSON, or invalid settings.
std::string settings_to_json(const StrokeSettings& settings);
Result<StrokeSettings> settings_from_json(const std::string& text);

// Materials in the form of settings.
std::string materials_to_json(const std::vector<Material>& materials);
Result<std::vector<Material>> materials_from_json(const std::string& text);

// The lattice, and a box, as JSON.
std::string lattice_to_json(const Lattice& lattice);
Result<Lattice> lattice_from_json(const std::string& text);
std::string box_to_json(const LatticeBox& box);
Result<LatticeBox> box_from_json(const std::string& text);
// Hash of a tile's bytes, as documents store it.
int64_t hash_of(const Bytes& bytes);
// The tables that hold one row for each flush of a stroke, in the order of a seal's hashes.
enum class BlockTable { tick, force, given };
constexpr Names<3> names_of(BlockTable) { return {"tick", "force", "given"}; }
// Adds a row of such a table to the hash of a step's rows.
void add_block(Hash& hash, int64_t sequence, int64_t count, const Bytes& data);

// Columns, compressed by zstd. In a column, each double is XORed with the one before. Then come the
// lowest bytes of all values, the next higher bytes, and so on.
Bytes encode_ticks(const RecordedTick* ticks, size_t count);
Result<std::vector<RecordedTick>> decode_ticks(const Bytes& bytes);

// The same encoding as for ticks.
Bytes encode_forces(const Wrench* computed, size_t count);
Result<std::vector<Wrench>> decode_forces(const Bytes& bytes);

// A pose as bytes. Errors: data of the wrong size, or an invalid pose.
Bytes encode_pose(const Pose& pose);
Result<Pose> decode_pose(const Bytes& bytes);

// The planes of a tile, compressed by zstd. Only the content is stored, not the memory layout.
Bytes encode_tile(const Tile& tile);
// Decodes into an empty tile of a field.
Status decode_tile(const Bytes& bytes, Field& field, int tu, int tv);

}  // namespace kibori
