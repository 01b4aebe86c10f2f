// SPDX-License-Identifier: MIT
#include <kibori/surface/cell_table.h>

#include <kibori/base/check.h>

namespace kibori {
namespace {

constexpr std::array<CellEdge, kCellEdges> make_edges() {
  std::array<CellEdge, kCellEdges> edges{};
  size_t at = 0;
  for (int axis = 0; axis < 3; axis++)
    for (int corner = 0; corner < 8; corner++)
      if (!((corner >> axis) & 1))
        edges[at++] = {static_cast<uint8_t>(corner), static_cast<uint8_t>(axis)};
  return edges;
}

// The corners of a face, in cyclic order.
std::array<int, 4> face_corners(int face) {
  const int axis = face / 2, side = face % 2, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3,
            base = side << axis;
  return {base, base | u, base | u | v, base | v};
}

int edge_between(int a, int b) {
  const int bit = a ^ b, axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
  return edge_at(axis, a & b);
}

}  // namespace

constinit const std::array<CellEdge, kCellEdges> kEdges = make_edges();

CellSheets sheets_of(uint8_t inside, uint8_t flipped) {
  const auto is_in = [&](int corner) { return ((inside >> corner) & 1) != 0; };
  // The neighbours of an edge in its ring: one through each of the edge's two faces.
  std::array<std::array<int, 2>, kCellEdges> links;
  std::array<int, kCellEdges> link_count{};
  // For an ambiguous face: one edge of each pair.
  std::array<std::array<int, 2>, kCellFaces> pair_of{};
  std::array<bool, kCellFaces> ambiguous{};
  const auto link = [&](int a, int b) {
    links[static_cast<size_t>(a)][static_cast<size_t>(link_count[static_cast<size_t>(a)]++)] = b;
    links[static_cast<size_t>(b)][static_cast<size_t>(link_count[static_cast<size_t>(b)]++)] = a;
  };
  for (int face = 0; face < kCellFaces; face++) {
    const auto ring = face_corners(face);
    int edges[4], crossed[4], count = 0;
    for (int i = 0; i < 4; i++) {
      const int next = ring[static_cast<size_t>((i + 1) % 4)], here = ring[static_cast<size_t>(i)];
      edges[i] = edge_between(here, next);
      if (is_in(here) != is_in(next)) crossed[count++] = edges[i];
    }
    if (count == 2) link(crossed[0], crossed[1]);
    if (count != 4) continue;
    // Link the two edges at each inside corner, or at each outside corner if the face is flipped.
    const bool around_inside = !((flipped >> face) & 1);
    int pairs = 0;
    ambiguous[static_cast<size_t>(face)] = true;
    for (int i = 0; i < 4; i++) {
      if (is_in(ring[static_cast<size_t>(i)]) != around_inside) continue;
      link(edges[(i + 3) % 4], edges[i]);
      pair_of[static_cast<size_t>(face)][static_cast<size_t>(pairs++)] = edges[i];
    }
  }
  CellSheets sheets{};
  sheets.of_edge.fill(kNoSheet);
  for (int start = 0; start < kCellEdges; start++) {
    if (link_count[static_cast<size_t>(start)] == 0 ||
        sheets.of_edge[static_cast<size_t>(start)] != kNoSheet)
      continue;
    int edge = start, from = -1;
    do {
      sheets.of_edge[static_cast<size_t>(edge)] = sheets.count;
      const auto& next = links[static_cast<size_t>(edge)];
      const int to = next[0] != from ? next[0] : next[1];
      from = edge;
      edge = to;
    } while (edge != start && sheets.of_edge[static_cast<size_t>(edge)] == kNoSheet);
    sheets.count++;
  }
  KIBORI_CHECK(sheets.count <= kMaxSheets);
  uint8_t listed = 0;
  for (uint8_t sheet = 0; sheet < sheets.count; sheet++) {
    sheets.begin[sheet] = listed;
    for (uint8_t edge = 0; edge < kCellEdges; edge++)
      if (sheets.of_edge[edge] == sheet) sheets.edges[listed++] = edge;
  }
  sheets.begin[sheets.count] = listed;
  for (size_t face = 0; face < kCellFaces; face++)
    if (ambiguous[face] && sheets.of_edge[static_cast<size_t>(pair_of[face][0])] ==
                               sheets.of_edge[static_cast<size_t>(pair_of[face][1])])
      sheets.twice |= static_cast<uint8_t>(1u << face);
  return sheets;
}

const CellSheets& sheets_of(uint8_t inside) {
  static const std::array<CellSheets, 256> table = [] {
    std::array<CellSheets, 256> all;
    for (size_t i = 0; i < 256; i++) all[i] = sheets_of(static_cast<uint8_t>(i), 0);
    return all;
  }();
  return table[inside];
}

}  // namespace kibori
