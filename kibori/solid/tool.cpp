// SPDX-License-Identifier: MIT
#include <kibori/solid/tool.h>

#include <atomic>
#include <type_traits>
#include <utility>

#include <kibori/solid/part_spans.h>

namespace kibori {

const char* shape_note(const Tool& tool) {
  return std::visit([](const auto& shape) { return shape.kAbout; }, tool);
}

bool is_convex(const Tool& tool) {
  return std::visit([](const auto& shape) { return shape.kIsConvex; }, tool);
}

double reach_mm(const Tool& tool) {
  return std::visit([](const auto& shape) { return shape.reach_mm(); }, tool);
}

std::optional<Tool> default_tool(std::string_view shape) {
  std::optional<Tool> tool;
  const auto take = [&]<size_t... I>(std::index_sequence<I...>) {
    static_cast<void>(((shape == kToolShapes[I] && (tool.emplace().emplace<I>(), true)) || ...));
  };
  take(std::make_index_sequence<std::variant_size_v<Tool>>());
  return tool;
}

Status check_tool(const Tool& tool) {
  ToolCheck checks;
  for_tool_numbers(tool, [&](const char* name, const auto& number) {
    if constexpr (std::is_same_v<decltype(number), const double&>)
      checks.positive(name, number);
    else
      for (int i = 0; i < 3; i++) checks.positive(name, number[i]);
  });
  std::visit([&](const auto& shape) { shape.check(checks); }, tool);
  if (!checks.fault().empty()) return Error{checks.fault()};
  return Ok{};
}

SweptTool::SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm,
                     const Lattice& lattice, bool start_is_clear)
    : parts_(start, motion_mm, lattice, start_is_clear), convex_(is_convex(tool)) {
  static std::atomic<uint64_t> next{1};
  id_ = next.fetch_add(1, std::memory_order_relaxed);
  std::visit([&](const auto& shape) { shape.add_parts(parts_); }, tool);
}

LatticeBox SweptTool::bounds() const {
  LatticeBox box;
  for (size_t i = 0; i < parts_.count(); i++) box.include(parts_[i].bounds());
  return box;
}

SweptTool::Layers& SweptTool::layers_of(const RayTile& rays, bool flip) const {
  struct LastQuery {
    uint64_t id = 0;
    RayTile rays{Axis::x, -1, -1};
    bool flip = false;
    Layers layers;
  };
  thread_local LastQuery last;
  if (last.id == id_ && last.rays == rays && last.flip == flip) return last.layers;
  last.id = id_;
  last.rays = rays;
  last.flip = flip;
  const int d = depth_index(rays.axis);
  for (size_t i = 0; i < parts_.count(); i++) {
    SpanLayer& part = last.layers[i];
    part.flip = flip;
    part.normals_ready = 0;
    part.last = false;
    const Box box = parts_[i].bounds().units;
    if (box.min[d] > rays.far + kBoundsSlack || box.max[d] < rays.near - kBoundsSlack ||
        !parts_[i].spans(rays, 0, part))
      part.rows = 0;
  }
  return last.layers;
}

bool SweptTool::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (parts_.count() == 1) return parts_[0].spans(rays, layer, out);
  if (convex_ && layer != 0) return false;
  static_assert(SweptParts::kMaxParts <= kMaxUnionParts);
  const Layers& parts = layers_of(rays, out.flip);
  out.normals_ready = 0;
  if (convex_) {
    out.last = true;
    hull_spans(parts.data(), parts_.count(), out);
  } else {
    union_spans(parts.data(), parts_.count(), layer, out);
  }
  return out.rows != 0;
}

void SweptTool::normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const {
  if (parts_.count() == 1) return parts_[0].normals(rays, layer, ends, of);
  // The part that made an end has exactly the same number there.
  Layers& parts = layers_of(rays, of.flip);
  for (size_t i = 0; i < parts_.count(); i++) {
    SpanLayer& own = parts[i];
    if (!own.rows) continue;
    const EndMasks mine = ends_made_by(own, of, ends);
    if (!mine.rows) continue;
    parts_[i].normals(rays, 0, mine, own);
    take_normals(own, mine, of);
  }
}

}  // namespace kibori
