// SPDX-License-Identifier: MIT
#include <kibori/scene/relief.h>

#include <algorithm>
#include <cmath>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/formats/png_file.h>

namespace kibori {
namespace {

// Larger pictures are averaged. A relief of this size has 17 million triangles.
constexpr int64_t kMaxPixels = int64_t{1} << 22;

// Halves the picture: each pixel is the mean of four.
GreyMap halved(const GreyMap& map) {
  GreyMap half{map.width / 2, map.height / 2, {}};
  half.pixels.resize(static_cast<size_t>(half.width) * static_cast<size_t>(half.height));
  for (int y = 0; y < half.height; y++)
    for (int x = 0; x < half.width; x++) {
      const auto from = static_cast<size_t>(2 * y * map.width + 2 * x),
                 below = from + static_cast<size_t>(map.width);
      const unsigned sum =
          map.pixels[from] + 0u + map.pixels[from + 1] + map.pixels[below] + map.pixels[below + 1];
      half.pixels[static_cast<size_t>(y * half.width + x)] = static_cast<uint16_t>((sum + 2) / 4);
    }
  return half;
}

}  // namespace

Result<TriangleMesh> read_relief(const std::filesystem::path& picture, const ReliefSize& size,
                                 double pitch_mm) {
  Result<GreyMap> read = read_png_grey(picture);
  if (!read) return Error{read.error()};
  GreyMap map = std::move(read).value();
  if (size.invert)
    for (uint16_t& pixel : map.pixels) pixel = static_cast<uint16_t>(65535 - pixel);
  const double depth_mm = size.width_mm * map.height / map.width;
  if (const Result<Lattice> fits =
          make_lattice({size.width_mm, depth_mm, size.base_mm + size.height_mm}, pitch_mm, 0);
      !fits)
    return Error{picture.string() + ": " + fits.error()};
  const auto too_fine = [&] {
    return size.width_mm / map.width < 0.5 * pitch_mm ||
           int64_t{map.width} * map.height > kMaxPixels;
  };
  while (map.width >= 4 && map.height >= 4 && too_fine()) map = halved(map);
  if (map.width < 2 || map.height < 2)
    return Error{picture.string() +
                 ": a relief needs at least two pixels on each side; use a larger picture"};
  const double step = size.width_mm / (map.width - 1);
  const auto w = static_cast<uint32_t>(map.width), h = static_cast<uint32_t>(map.height);
  TriangleMesh mesh;
  mesh.vertices.reserve(size_t{2} * w * h);
  // First the points of the upper side, then for each of them the point of the floor below it.
  for (const bool floor : {false, true})
    for (uint32_t y = 0; y < h; y++)
      for (uint32_t x = 0; x < w; x++) {
        const double z =
            floor ? 0
                  : size.base_mm + size.height_mm *
                                       map.pixels[static_cast<size_t>(h - 1 - y) * w + x] / 65535.0;
        mesh.vertices.emplace_back(x * step, y * step, z);
      }
  const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  const auto top = [&](uint32_t x, uint32_t y) { return y * w + x; };
  const auto below = [&](uint32_t x, uint32_t y) { return w * h + y * w + x; };
  for (uint32_t y = 0; y + 1 < h; y++)
    for (uint32_t x = 0; x + 1 < w; x++) {
      quad(top(x, y), top(x + 1, y), top(x + 1, y + 1), top(x, y + 1));
      quad(below(x, y), below(x, y + 1), below(x + 1, y + 1), below(x + 1, y));
    }
  for (uint32_t x = 0; x + 1 < w; x++) {
    quad(below(x, 0), below(x + 1, 0), top(x + 1, 0), top(x, 0));
    quad(below(x + 1, h - 1), below(x, h - 1), top(x, h - 1), top(x + 1, h - 1));
  }
  for (uint32_t y = 0; y + 1 < h; y++) {
    quad(below(0, y + 1), below(0, y), top(0, y), top(0, y + 1));
    quad(below(w - 1, y), below(w - 1, y + 1), top(w - 1, y + 1), top(w - 1, y));
  }
  return mesh;
}

}  // namespace kibori
