// SPDX-License-Identifier: MIT
#include <kibori/reshape/alpha.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>

#include <kibori/base/file.h>
#include <kibori/base/trig.h>
#include <kibori/formats/png_file.h>

namespace kibori {
namespace {

constexpr int kSide = AlphaPicture::kSide;
using Texture = std::array<float, kSide * kSide>;

double wrapped(double x) { return x - std::floor(x); }
// 0 below `low`, 1 above `high`, smooth between them.
double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
// A wave from 0 to 1 with a period of 1; 1 at whole numbers.
double wave(double x) { return 0.5 + 0.5 * sin_cos(2 * std::numbers::pi * wrapped(x)).cos; }

// A random number from 0 to 1 for a point of a grid that repeats after (nu, nv).
double hashed(int i, int j, int nu, int nv, uint32_t seed) {
  uint32_t x = static_cast<uint32_t>(((i % nu) + nu) % nu) * 0x9e3779b9u ^
               static_cast<uint32_t>(((j % nv) + nv) % nv) * 0x85ebca6bu ^ seed * 0xc2b2ae35u;
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x / 4294967296.0;
}

// Smooth noise from 0 to 1 with nu by nv values in the square.
double noise(double u, double v, int nu, int nv, uint32_t seed) {
  const double x = u * nu, y = v * nv;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double s = smooth_step(0, 1, x - i), t = smooth_step(0, 1, y - j);
  const auto at = [&](int di, int dj) { return hashed(i + di, j + dj, nu, nv, seed); };
  return (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
}

// Distances to the nearest and the second nearest of n by n scattered points, in units of their
// mean distance.
struct Cells {
  double first, second;
};
Cells cells(double u, double v, int n, uint32_t seed) {
  const double x = u * n, y = v * n;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  Cells found{9, 9};
  for (int dj = -2; dj <= 2; dj++)
    for (int di = -2; di <= 2; di++) {
      const double px = i + di + 0.15 + 0.7 * hashed(i + di, j + dj, n, n, seed),
                   py = j + dj + 0.15 + 0.7 * hashed(i + di, j + dj, n, n, seed + 1);
      const double distance = std::sqrt((px - x) * (px - x) + (py - y) * (py - y));
      if (distance < found.first)
        found = {distance, found.first};
      else
        found.second = std::min(found.second, distance);
    }
  return found;
}

// Overlapping rows of round scales. Each is highest at its free end, and the next row covers its
// other end.
double scales(double u, double v) {
  constexpr int kRows = 4;
  double best = 0;
  const int row = static_cast<int>(std::floor(u * kRows));
  for (int r = row + 1; r >= row - 1; r--) {
    const double x = u * kRows - r, y = v * kRows - 0.5 * (((r % 2) + 2) % 2),
                 side = y - std::floor(y + 0.5);
    const double radius = std::sqrt((x - 0.35) * (x - 0.35) * 0.8 + 4 * 0.8 * side * side);
    if (radius < 0.95) best = std::max(best, smooth_step(0.95, 0.85, radius) * (0.25 + 0.6 * x));
  }
  return std::clamp(best, 0.0, 1.0);
}
double bark(double u, double v) {
  const double bent = v + 0.06 * (noise(u, v, 4, 4, 11) - 0.5);
  const double ridges = std::fabs(2 * noise(u, bent, 3, 12, 12) - 1),
               fine = noise(u, bent, 9, 30, 13);
  return std::clamp(0.75 * smooth_step(0.08, 0.5, ridges) + 0.25 * fine, 0.0, 1.0);
}
double hatching(double u, double v) {
  return smooth_step(0.45, 0.75, wave(8 * v + 0.12 * (noise(u, v, 3, 6, 21) - 0.5)));
}
double leather(double u, double v) {
  const Cells near = cells(u, v, 7, 31);
  return smooth_step(0.02, 0.35, near.second - near.first) * (0.8 + 0.2 * noise(u, v, 20, 20, 32));
}
double cracks(double u, double v) {
  const double bent_u = u + 0.05 * (noise(u, v, 6, 6, 41) - 0.5),
               bent_v = v + 0.05 * (noise(u, v, 6, 6, 42) - 0.5);
  const Cells near = cells(wrapped(bent_u), wrapped(bent_v), 4, 43);
  return 1 - smooth_step(0.02, 0.12, near.second - near.first);
}
double pores(double u, double v) { return 1 - smooth_step(0.12, 0.3, cells(u, v, 9, 51).first); }
double weave(double u, double v) {
  constexpr int kThreads = 6;
  const double x = u * kThreads, y = v * kThreads;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double a = x - i - 0.5, b = y - j - 0.5;
  // A thread is a round bar; it passes over every second one.
  const bool over = (i + j) % 2 == 0;
  const double across = over ? b : a, along = over ? a : b;
  const double bar = std::sqrt(std::max(0.0, 1 - 4.4 * across * across));
  return std::clamp(bar * (0.55 + 0.45 * wave(along)), 0.0, 1.0);
}
double knit(double u, double v) {
  constexpr int kStitches = 5;
  const double x = u * kStitches, y = v * kStitches, side = y - std::floor(y) - 0.5;
  // Two slanted loops that meet in the middle.
  const double along = wrapped(x + 1.1 * std::fabs(side)), middle = 0.27 - std::fabs(side);
  const double loop = (along - 0.5) * (along - 0.5) * 3.4 + middle * middle * 12;
  return std::sqrt(std::max(0.0, 1 - loop));
}
double hammered(double u, double v) {
  const Cells near = cells(u, v, 5, 71);
  return std::clamp(1.25 * near.first * near.first + 0.1, 0.0, 1.0);
}
double fur(double u, double v) {
  const double bent = v + 0.03 * (noise(u, v, 5, 5, 81) - 0.5);
  return smooth_step(0.25, 0.8,
                     0.65 * noise(u, bent, 3, 36, 82) + 0.35 * noise(u, bent, 5, 80, 83));
}
double ripples(double u, double v) {
  const double x = u - 0.5, y = v - 0.5, radius = std::sqrt(x * x + y * y);
  return radius < 0.5 ? wave(9 * radius) : 0.5 + 0.5 * wave(4.5);
}
double studs(double u, double v) {
  constexpr int kRows = 4;
  const double x = wrapped(u * kRows) - 0.5, y = wrapped(v * kRows) - 0.5;
  return std::sqrt(std::max(0.0, 1 - (x * x + y * y) / (0.4 * 0.4)));
}

double pattern(Alpha alpha, double u, double v) {
  switch (alpha) {
    case Alpha::none:
    case Alpha::picture:
      return 1;
    case Alpha::scales:
      return scales(u, v);
    case Alpha::bark:
      return bark(u, v);
    case Alpha::hatching:
      return hatching(u, v);
    case Alpha::leather:
      return leather(u, v);
    case Alpha::cracks:
      return cracks(u, v);
    case Alpha::pores:
      return pores(u, v);
    case Alpha::weave:
      return weave(u, v);
    case Alpha::knit:
      return knit(u, v);
    case Alpha::hammered:
      return hammered(u, v);
    case Alpha::fur:
      return fur(u, v);
    case Alpha::ripples:
      return ripples(u, v);
    case Alpha::studs:
      return studs(u, v);
  }
  return 1;
}

const Texture& texture_of(Alpha alpha) {
  constexpr size_t kCount = names_of(Alpha{}).size();
  static std::array<std::once_flag, kCount> made;
  static std::array<std::unique_ptr<Texture>, kCount> textures;
  const auto i = static_cast<size_t>(alpha);
  std::call_once(made[i], [&] {
    auto texture = std::make_unique<Texture>();
    for (size_t y = 0; y < kSide; y++)
      for (size_t x = 0; x < kSide; x++)
        (*texture)[y * kSide + x] = static_cast<float>(
            pattern(alpha, static_cast<double>(x) / kSide, static_cast<double>(y) / kSide));
    textures[i] = std::move(texture);
  });
  return *textures[i];
}

// The value at (u, v) between the four nearest texels. texel(i) is that of row i / kSide.
template <class Texel>
double interpolated(double u, double v, Texel&& texel) {
  const double x = wrapped(u) * kSide, y = wrapped(v) * kSide;
  const auto i = static_cast<size_t>(x) % kSide, j = static_cast<size_t>(y) % kSide,
             i1 = (i + 1) % kSide, j1 = (j + 1) % kSide;
  const double s = x - std::floor(x), t = y - std::floor(y);
  const auto at = [&](size_t a, size_t b) { return texel(b * kSide + a); };
  return (1 - t) * ((1 - s) * at(i, j) + s * at(i1, j)) +
         t * ((1 - s) * at(i, j1) + s * at(i1, j1));
}

// The grey of a picture at (u, v), 0 to 65535, between its pixels. The picture repeats.
double grey_at(const GreyMap& map, double u, double v) {
  const double x = wrapped(u) * map.width - 0.5, y = wrapped(1 - v) * map.height - 0.5;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double s = x - i, t = y - j;
  const auto at = [&](int column, int row) {
    column = (column + map.width) % map.width;
    row = (row + map.height) % map.height;
    return static_cast<double>(
        map.pixels[static_cast<size_t>(row) * static_cast<size_t>(map.width) +
                   static_cast<size_t>(column)]);
  };
  return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) +
         t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
}

}  // namespace

double alpha_at(Alpha alpha, double u, double v) {
  if (alpha == Alpha::none || alpha == Alpha::picture) return 1;
  const Texture& texture = texture_of(alpha);
  return interpolated(u, v, [&](size_t i) { return static_cast<double>(texture[i]); });
}

double alpha_at(const AlphaPicture& picture, double u, double v) {
  return interpolated(u, v, [&](size_t i) { return picture.greys[i] / 255.0; });
}

Result<std::shared_ptr<const AlphaPicture>> parse_alpha_picture(std::span<const char> png,
                                                                const std::string& name) {
  const Result<GreyMap> map = parse_png_grey(png, name, kMaxPictureSide);
  if (!map) return Error{map.error()};
  auto picture = std::make_shared<AlphaPicture>();
  // A texel of a large picture is the mean of several samples, so that fine lines stay.
  const int samples = (std::max(map.value().width, map.value().height) + kSide - 1) / kSide;
  const double step = 1.0 / (kSide * samples);
  for (int y = 0; y < kSide; y++)
    for (int x = 0; x < kSide; x++) {
      double sum = 0;
      for (int j = 0; j < samples; j++)
        for (int i = 0; i < samples; i++)
          sum +=
              grey_at(map.value(), (x * samples + i + 0.5) * step, (y * samples + j + 0.5) * step);
      picture->greys[static_cast<size_t>(y * kSide + x)] =
          static_cast<uint8_t>(std::lround(sum / (samples * samples) / 257));
    }
  return std::shared_ptr<const AlphaPicture>(std::move(picture));
}

Result<std::shared_ptr<const AlphaPicture>> read_alpha_picture(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path);
  if (!bytes) return Error{bytes.error()};
  return parse_alpha_picture(bytes.value(), path.string());
}

}  // namespace kibori
