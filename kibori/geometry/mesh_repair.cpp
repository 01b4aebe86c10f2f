// SPDX-License-Identifier: MIT
#include <kibori/geometry/mesh_repair.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace kibori {
namespace {

using Triangle = std::array<uint32_t, 3>;

// An index for each vertex; vertices with the same position have the same one.
std::vector<uint32_t> welded(const std::vector<Vec3>& vertices) {
  std::vector<uint32_t> order(vertices.size()), ids(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto less = [&](uint32_t a, uint32_t b) {
    const Vec3 &p = vertices[a], &q = vertices[b];
    return std::tie(p.x(), p.y(), p.z()) < std::tie(q.x(), q.y(), q.z());
  };
  std::sort(order.begin(), order.end(), less);
  for (size_t i = 0; i < order.size(); i++)
    ids[order[i]] = i > 0 && !less(order[i - 1], order[i]) ? ids[order[i - 1]] : order[i];
  return ids;
}

uint64_t edge_key(uint32_t a, uint32_t b) {
  return uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

// All triangles at one place.
struct Place {
  size_t first;      // the first of its triangles, which may face either way
  Triangle corners;  // of welded vertices
  int forward = 0, backward = 0;
  int net() const { return forward - backward; }
};

// For each edge, the number of triangles that use it forwards minus those that use it backwards. It
// is 0 at all edges of a closed mesh.
class EdgeBalance {
 public:
  void add(const Triangle& t, int times) {
    for (size_t k = 0; k < 3; k++) {
      const uint32_t a = t[k], b = t[(k + 1) % 3];
      const int by = a < b ? times : -times;
      int& sum = sums_[edge_key(a, b)];
      open_ += static_cast<size_t>(std::abs(sum + by));
      open_ -= static_cast<size_t>(std::abs(sum));
      sum += by;
    }
  }
  // Decrease of the number of open edges if the triangle is added.
  int gain(const Triangle& t, int times) const {
    int gain = 0;
    for (size_t k = 0; k < 3; k++) {
      const uint32_t a = t[k], b = t[(k + 1) % 3];
      const auto there = sums_.find(edge_key(a, b));
      const int sum = there == sums_.end() ? 0 : there->second;
      gain += std::abs(sum) - std::abs(sum + (a < b ? times : -times));
    }
    return gain;
  }
  size_t open() const { return open_; }

 private:
  std::unordered_map<uint64_t, int> sums_;
  size_t open_ = 0;
};

class Repair {
 public:
  explicit Repair(const TriangleMesh& mesh) : mesh_(mesh), ids_(welded(mesh.vertices)) {}

  std::optional<MeshRepair> run() {
    find_places();
    MeshRepair result;
    if (places_.size() < proper_) result.copies = leave_out_copies();
    if (result.copies == 0) keep_all();
    result.inverted = turn_inverted();
    if (result.copies == 0 && result.inverted == 0) return std::nullopt;
    result.triangles = std::move(kept_);
    return result;
  }

 private:
  Triangle corners(const Triangle& t) const { return {ids_[t[0]], ids_[t[1]], ids_[t[2]]}; }
  static bool is_proper(const Triangle& c) { return c[0] != c[1] && c[1] != c[2] && c[2] != c[0]; }
  Triangle reversed(const Triangle& t) const { return {t[0], t[2], t[1]}; }

  void find_places() {
    struct Sorted {
      Triangle key;
      uint32_t triangle;
      bool forward;
    };
    std::vector<Sorted> all;
    all.reserve(mesh_.triangles.size());
    for (size_t i = 0; i < mesh_.triangles.size(); i++) {
      Triangle c = corners(mesh_.triangles[i]);
      if (!is_proper(c)) continue;
      std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
      const bool forward = c[1] < c[2];
      if (!forward) std::swap(c[1], c[2]);
      all.push_back({c, static_cast<uint32_t>(i), forward});
    }
    proper_ = all.size();
    std::sort(all.begin(), all.end(), [](const Sorted& a, const Sorted& b) {
      return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
    });
    for (size_t i = 0; i < all.size(); i++) {
      if (i == 0 || all[i].key != all[i - 1].key) places_.push_back({all[i].triangle, all[i].key});
      (all[i].forward ? places_.back().forward : places_.back().backward)++;
    }
  }

  // The mesh's triangle at a place, facing forward or backward.
  Triangle triangle_at(const Place& place, bool forward) const {
    const Triangle& t = mesh_.triangles[place.first];
    Triangle c = corners(t);
    std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
    return (c[1] < c[2]) == forward ? t : reversed(t);
  }

  // Keeps one triangle of each place if that reduces the number of open edges. Returns the number
  // of omitted triangles. If it does not help, it returns 0, and kept_ is undefined.
  size_t leave_out_copies() {
    EdgeBalance before, after;
    std::vector<int> chosen(places_.size());  // 1: forward, -1: backward, 0: none
    for (size_t i = 0; i < places_.size(); i++) {
      const Place& place = places_[i];
      chosen[i] = place.net() > 0 ? 1 : place.net() < 0 ? -1 : 0;
      if (place.net() != 0) before.add(place.corners, place.net());
      if (chosen[i] != 0) after.add(place.corners, chosen[i]);
    }
    if (before.open() == 0 && std::all_of(places_.begin(), places_.end(),
                                          [](const Place& p) { return std::abs(p.net()) <= 1; })) {
      // The mesh is closed. Only surfaces that exist twice, once facing each way, need repair.
      if (!choose_double_surfaces(chosen)) return 0;
    } else if (same_everywhere()) {
      // The whole mesh is repeated several times.
    } else {
      close_with_both_ways(chosen, after);
      if (after.open() >= before.open()) return 0;
    }
    kept_.clear();
    for (size_t i = 0; i < places_.size(); i++)
      if (chosen[i] != 0) kept_.push_back(triangle_at(places_[i], chosen[i] > 0));
    return proper_ - kept_.size();
  }

  bool same_everywhere() const {
    const int net = std::abs(places_.front().net());
    return net > 1 && std::all_of(places_.begin(), places_.end(),
                                  [&](const Place& p) { return std::abs(p.net()) == net; });
  }

  // Adds one triangle at places whose triangles face both ways, if a side of it is an open edge.
  void close_with_both_ways(std::vector<int>& chosen, EdgeBalance& balance) const {
    std::unordered_map<uint64_t, std::vector<size_t>> at_edge;
    std::vector<size_t> next;
    for (size_t i = 0; i < places_.size(); i++) {
      if (chosen[i] != 0) continue;
      next.push_back(i);
      for (size_t k = 0; k < 3; k++)
        at_edge[edge_key(places_[i].corners[k], places_[i].corners[(k + 1) % 3])].push_back(i);
    }
    while (!next.empty()) {
      const size_t i = next.back();
      next.pop_back();
      if (chosen[i] != 0) continue;
      const Triangle& c = places_[i].corners;
      const int forward = balance.gain(c, 1), backward = balance.gain(c, -1);
      // A gain of -3 means that no side is an open edge. With one such side, the triangle begins to
      // fill the hole, although the gain is -1.
      if (std::max(forward, backward) <= -3) continue;
      chosen[i] = forward >= backward ? 1 : -1;
      balance.add(c, chosen[i]);
      for (size_t k = 0; k < 3; k++)
        for (const size_t other : at_edge[edge_key(c[k], c[(k + 1) % 3])])
          if (chosen[other] == 0) next.push_back(other);
    }
  }

  // Chooses one direction for each closed surface of places that face both ways. Returns false if
  // there is none.
  bool choose_double_surfaces(std::vector<int>& chosen) const {
    std::unordered_map<uint64_t, std::vector<size_t>> at_edge;
    for (size_t i = 0; i < places_.size(); i++)
      for (size_t k = 0; k < 3; k++)
        at_edge[edge_key(places_[i].corners[k], places_[i].corners[(k + 1) % 3])].push_back(i);
    bool any = false;
    std::vector<bool> seen(places_.size());
    for (size_t start = 0; start < places_.size(); start++) {
      if (seen[start] || chosen[start] != 0) continue;
      std::vector<size_t> surface{start};
      std::vector<int> way{1};
      seen[start] = true;
      bool closed = true;
      double volume = 0;
      for (size_t n = 0; n < surface.size(); n++) {
        const Triangle& c = places_[surface[n]].corners;
        volume += way[n] * signed_volume(c);
        for (size_t k = 0; k < 3; k++) {
          const uint32_t a = c[k], b = c[(k + 1) % 3];
          const std::vector<size_t>& there = at_edge[edge_key(a, b)];
          closed &= there.size() == 2;
          for (const size_t other : there) {
            if (other == surface[n]) continue;
            closed &= chosen[other] == 0;
            if (seen[other] || chosen[other] != 0) continue;
            seen[other] = true;
            surface.push_back(other);
            way.push_back(passes(places_[other].corners, a, b) ? -way[n] : way[n]);
          }
        }
      }
      if (!closed || volume == 0) continue;
      any = true;
      for (size_t n = 0; n < surface.size(); n++)
        chosen[surface[n]] = volume > 0 ? way[n] : -way[n];
    }
    return any;
  }

  static bool passes(const Triangle& c, uint32_t a, uint32_t b) {
    for (size_t k = 0; k < 3; k++)
      if (c[k] == a && c[(k + 1) % 3] == b) return true;
    return false;
  }
  double signed_volume(const Triangle& t) const {
    const Vec3& middle = mesh_.vertices.front();
    const Vec3 a = mesh_.vertices[t[0]] - middle, b = mesh_.vertices[t[1]] - middle,
               c = mesh_.vertices[t[2]] - middle;
    return a.dot(b.cross(c)) / 6;
  }

  void keep_all() { kept_ = mesh_.triangles; }

  // Turns inverted bodies of kept_. Returns their number.
  size_t turn_inverted() {
    std::vector<uint32_t> set(mesh_.vertices.size());  // union-find
    std::iota(set.begin(), set.end(), 0u);
    const auto find = [&](uint32_t a) {
      while (set[a] != a) a = set[a] = set[set[a]];
      return a;
    };
    for (const Triangle& t : kept_)
      for (size_t k = 1; k < 3; k++) {
        const uint32_t a = find(ids_[t[0]]), b = find(ids_[t[k]]);
        set[std::max(a, b)] = std::min(a, b);
      }
    struct Body {
      double volume = 0;
      Box box;
      EdgeBalance balance;
      bool inverted = false;
    };
    std::unordered_map<uint32_t, double> volumes;
    double all = 0;
    for (const Triangle& t : kept_) {
      const double volume = signed_volume(t);
      volumes[find(ids_[t[0]])] += volume;
      all += volume;
    }
    const double sign = all < 0 ? -1 : 1;
    if (volumes.size() < 2 || std::all_of(volumes.begin(), volumes.end(), [&](const auto& body) {
          return sign * body.second >= 0;
        }))
      return 0;
    std::unordered_map<uint32_t, Body> bodies;
    for (const Triangle& t : kept_) {
      Body& body = bodies[find(ids_[t[0]])];
      body.volume += signed_volume(t);
      for (const uint32_t v : t) body.box.include(mesh_.vertices[v]);
      const Triangle c = corners(t);
      if (is_proper(c)) body.balance.add(c, 1);
    }
    size_t turned = 0;
    for (auto& entry : bodies) {
      Body& body = entry.second;
      if (!(sign * body.volume < 0) || body.balance.open() > 0) continue;
      const bool is_hollow = std::any_of(bodies.begin(), bodies.end(), [&](const auto& other) {
        return sign * other.second.volume > 0 &&
               (other.second.box.min.array() <= body.box.min.array()).all() &&
               (other.second.box.max.array() >= body.box.max.array()).all();
      });
      body.inverted = !is_hollow;
      turned += body.inverted;
    }
    if (turned > 0)
      for (Triangle& t : kept_)
        if (bodies[find(ids_[t[0]])].inverted) t = reversed(t);
    return turned;
  }

  const TriangleMesh& mesh_;
  const std::vector<uint32_t> ids_;
  std::vector<Place> places_;
  size_t proper_ = 0;  // triangles with three different corners
  std::vector<Triangle> kept_;
};

}  // namespace

std::string MeshRepair::warning() const {
  std::string text;
  if (copies > 0)
    text = std::to_string(copies) + (copies == 1 ? " triangle is" : " triangles are") +
           " left out because others are in the same place";
  if (inverted > 0)
    text += (text.empty() ? "" : "; ") + std::to_string(inverted) +
            (inverted == 1 ? " body is" : " bodies are") + " reversed because it faces inwards";
  if (inverted > 1) text.replace(text.find("it faces"), 8, "they face");
  return text;
}

std::optional<MeshRepair> repair_mesh(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return std::nullopt;
  return Repair(mesh).run();
}

}  // namespace kibori
