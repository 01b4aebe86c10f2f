// SPDX-License-Identifier: MIT
#include <kibori/report/tick_row.h>

#include <cstddef>

#include <Eigen/Geometry>

#include <kibori/base/json.h>
#include <kibori/base/names.h>
#include <kibori/document/codec.h>

namespace kibori {
namespace {

std::array<double, 3> force_row(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

TickRow row_of(const HandTick& tick, const LiveTick& of, uint8_t hand) {
  TickRow row;
  row.tick = of.number;
  row.time_s = of.time_s;
  row.tool_pose = numbers_of(tick.tool);
  row.hand_pose = numbers_of(tick.hand);
  row.force_n = force_row(tick.computed.force / tick.force_scale);
  row.moment_nmm = force_row(tick.computed.moment / tick.force_scale);
  row.given_force_n = force_row(tick.given.force);
  row.given_moment_nmm = force_row(tick.given.moment);
  row.removed_mm3 = tick.removed_mm3;
  row.points = tick.points;
  row.hand = hand;
  row.mode = static_cast<uint8_t>(tick.mode);
  row.touching = tick.touching;
  row.cutting = tick.cutting;
  row.inside = tick.inside;
  row.clipped = tick.clipped;
  row.safety = static_cast<uint8_t>(tick.safety);
  row.trip = static_cast<uint8_t>(tick.trip);
  return row;
}

nlohmann::json tick_columns() {
  nlohmann::json columns = nlohmann::json::array();
  const auto add = [&](const char* name, const char* type, size_t offset, size_t count = 1) {
    columns.push_back({{"name", name}, {"type", type}, {"offset", offset}, {"count", count}});
  };
  add("tick", "u64", offsetof(TickRow, tick));
  add("time_s", "f64", offsetof(TickRow, time_s));
  add("tool_pose", "f64", offsetof(TickRow, tool_pose), 7);
  add("hand_pose", "f64", offsetof(TickRow, hand_pose), 7);
  add("force_N", "f64", offsetof(TickRow, force_n), 3);
  add("moment_Nmm", "f64", offsetof(TickRow, moment_nmm), 3);
  add("given_force_N", "f64", offsetof(TickRow, given_force_n), 3);
  add("given_moment_Nmm", "f64", offsetof(TickRow, given_moment_nmm), 3);
  add("removed_mm3", "f64", offsetof(TickRow, removed_mm3));
  add("fallen_mm3", "f64", offsetof(TickRow, fallen_mm3));
  add("points", "i64", offsetof(TickRow, points));
  add("hand", "u8", offsetof(TickRow, hand));
  add("mode", "u8", offsetof(TickRow, mode));
  add("touching", "u8", offsetof(TickRow, touching));
  add("cutting", "u8", offsetof(TickRow, cutting));
  add("inside", "u8", offsetof(TickRow, inside));
  add("clipped", "u8", offsetof(TickRow, clipped));
  add("safety", "u8", offsetof(TickRow, safety));
  add("trip", "u8", offsetof(TickRow, trip));
  return columns;
}

}  // namespace

std::array<double, 7> numbers_of(const Pose& pose) {
  const Eigen::Quaterniond turn(pose.frame);
  return {pose.tip.x(), pose.tip.y(), pose.tip.z(), turn.x(), turn.y(), turn.z(), turn.w()};
}

void append_rows(const LiveTick& tick, std::vector<TickRow>& rows) {
  rows.push_back(row_of(tick, tick, 1));
  rows.back().fallen_mm3 = tick.fallen_mm3;
  if (tick.second) rows.push_back(row_of(*tick.second, tick, 2));
}

std::string about_rows(const Published& published) {
  nlohmann::json materials = nlohmann::json::array(), modes = materials, trips = materials;
  for (const Material& material : published.materials) materials.push_back(material.name);
  for (const std::string_view name : names_of(Mode())) modes.push_back(name);
  for (auto trip = Trip::none; trip <= Trip::not_finite;
       trip = static_cast<Trip>(static_cast<int>(trip) + 1))
    trips.push_back(trip == Trip::none ? "" : trip_text(trip));
  const nlohmann::json about{
      {"program", "kibori"},
      {"version", KIBORI_VERSION},
      {"format", 1},
      {"document", published.document},
      {"device", published.device},
      {"rate_hz", published.rate_hz},
      {"lattice", parse_json(lattice_to_json(published.lattice))},
      {"materials", std::move(materials)},
      {"units", "mm, s, N, N mm, mm3; quaternions x, y, z, w"},
      {"clock", "time_s counts from the servo thread's beginning, by its monotonic clock"},
      {"modes", std::move(modes)},
      {"trips", std::move(trips)},
      {"row_bytes", sizeof(TickRow)},
      {"columns", tick_columns()}};
  return about.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace kibori
