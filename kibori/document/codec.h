// SPDX-License-Identifier: MIT
// What a document holds, as bytes and back: tiles, ticks of a stroke, settings. Everything read is checked,
// as files are hostile until parsed. docs/documents.md describes the formats.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/document/database.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/series_tool.h>
#include <kibori/motion/stroke.h>
#include <kibori/solid/tool.h>

namespace kibori {

// One tick of a stroke: the tool's own path, and where the hand was by then.
struct StrokeTick {
  Vec3 tip = Vec3::Zero();   // [mm] of the tool, at the end of the tick
  Vec3 turn = Vec3::Zero();  // [rad] by which the tool turned: rotation vector
  bool edits = false;        // the way was cut or filled; else the tool only went there
  // Model `series`: the hand, from the tool, which is what stretches the springs.
  Vec3 hand = Vec3::Zero();       // [mm]
  Vec3 hand_turn = Vec3::Zero();  // [rad]
};

// How motion becomes force.
struct StrokeForce {
  bool series = false;
  ForceLaw law;         // the other models
  SeriesSpring spring;  // series
};

// All that ticks mean the same under.
struct StrokeSettings {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  std::vector<Material> materials{Material{}};
  StrokeForce force;
  double rate_hz = 1000;
  Symmetry symmetry;
};

std::string settings_to_json(const StrokeSettings& settings);
Result<StrokeSettings> settings_from_json(const std::string& text);

// Where the rays are, and a box; both as JSON.
std::string lattice_to_json(const Lattice& lattice);
Result<Lattice> lattice_from_json(const std::string& text);
std::string box_to_json(const Box& box);
Result<Box> box_from_json(const std::string& text);
// Hashes as they stand in documents: of a model as text, of a tile's bytes.
std::string hash_text(uint64_t hash);
int64_t hash_of(const Bytes& bytes);

// zstd over columns: each coordinate's doubles XORed with the one before, byte by byte of significance.
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
