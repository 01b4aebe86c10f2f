// SPDX-License-Identifier: MIT
// Labelled volumes: read data against written data, solids against an interpolation by corners, and
// shapes with known faces and volumes.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/nrrd.h>
#include <kibori/formats/volume_file.h>
#include <kibori/solid/grid_solid.h>

#include "tests/support.h"

namespace kibori::labels_tests {
namespace {

using test::Folder;
using test::Random;

LabelVolume volume_of(const Index3& size, const Vec3& voxel_mm,
                      const std::function<uint16_t(const Vec3&)>& label_at) {
  LabelVolume volume;
  volume.size = size;
  volume.voxel_mm = voxel_mm;
  for (int z = 0; z < size.z(); z++)
    for (int y = 0; y < size.y(); y++)
      for (int x = 0; x < size.x(); x++)
        volume.values.push_back(label_at(voxel_mm.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5))));
  return volume;
}

// The trilinear interpolation, corner by corner.
double interpolated(const ShapeGrid& grid, const Vec3& mm) {
  const Vec3 at = mm.cwiseQuotient(grid.voxel_mm) - Vec3::Constant(0.5);
  const Vec3 floor = at.array().floor(), part = at - floor;
  double sum = 0;
  for (int c = 0; c < 8; c++) {
    double weight = 1;
    Index3 place;
    for (int i = 0; i < 3; i++) {
      const int up = c >> i & 1;
      weight *= up ? part[i] : 1 - part[i];
      place[i] = static_cast<int>(floor[i]) + up;
    }
    sum += weight * double{grid.at(place.x(), place.y(), place.z(), -1)};
  }
  return sum;
}

TEST(GridSolid, IsWhereTheInterpolationIsAboveZero) {
  Random random;
  for (int round = 0; round < test::rounds_of("KIBORI_ROUNDS", 60); round++) {
    ShapeGrid grid;
    grid.size = Index3(random.integer(1, 9), random.integer(1, 9), random.integer(1, 9));
    grid.voxel_mm = Vec3(random.uniform(0.5, 3), random.uniform(0.5, 3), random.uniform(0.5, 3));
    for (int i = 0; i < grid.size.prod(); i++)
      grid.values.push_back(static_cast<float>(random.uniform(-1, 1)));
    Lattice lattice;
    lattice.pitch_mm = random.uniform(0.3, 1.5);
    lattice.origin_mm = random.in_box(-2, 2);
    lattice.nodes = Index3(32, 32, 32);
    const Vec3 corner = random.in_box(-3, 6);
    const GridSolid solid(grid, corner, lattice);
    for (int sample = 0; sample < 60; sample++) {
      const Axis axis = kAxes[static_cast<size_t>(random.integer(0, 2))];
      const RayTile tile{axis, 16 * random.integer(0, 1), 16 * random.integer(0, 1)};
      const int slot = random.integer(0, kTileRays - 1);
      Vec3 at;
      at[u_index(axis)] = tile.u0 + slot % kTileSide + 0.5;
      at[v_index(axis)] = tile.v0 + slot / kTileSide + 0.5;
      const double depth = random.uniform(0, 32);
      at[depth_index(axis)] = depth;
      const double value = interpolated(grid, lattice.to_mm(LatticePoint{at}) - corner);
      if (std::abs(value) < 1e-4) continue;
      SpanLayer layer;
      bool found = false;
      float last = -kFar;
      for (int l = 0;; l++) {
        layer.last = false;
        layer.normals_ready = 0;
        if (!solid.spans(tile, l, layer)) break;
        if (!(layer.lo[slot] < layer.hi[slot])) continue;
        EXPECT_GE(layer.lo[slot], last) << random.note();
        last = layer.hi[slot];
        found |= layer.lo[slot] <= depth && depth < layer.hi[slot];
      }
      EXPECT_EQ(found, value > 0) << random.note() << " round " << round << " sample " << sample;
    }
  }
}

// A box that nearly fills its grid: its faces stay in place, also at the grid's border.
TEST(Labels, FacesStayWhereTheyWere) {
  for (const int margin : {0, 1, 2, 7}) {
    const Index3 size = Index3::Constant(12 + 2 * margin);
    const LabelVolume volume = volume_of(size, Vec3::Ones(), [&](const Vec3& p) {
      const bool in = (p.array() > margin).all() && (p.array() < margin + 12).all();
      return static_cast<uint16_t>(in ? 1 : 0);
    });
    const ShapeGrid shape = shape_of_labels(volume, [](uint16_t l) { return l == 1; });
    // Along the middle, where no edge is near.
    for (int axis = 0; axis < 3; axis++) {
      Vec3 at = Vec3::Constant(margin + 6);
      double low = margin - 0.9, high = margin + 3;
      for (int i = 0; i < 40; i++) {
        at[axis] = (low + high) / 2;
        (interpolated(shape, at) > 0 ? high : low) = at[axis];
      }
      // Outside the grid the value is -1. So without a margin the face is less exact.
      EXPECT_NEAR(high, margin, margin == 0 ? 0.25 : 0.02) << margin;
    }
  }
}

// The middle of each voxel stays inside or outside, even in thin and small parts.
TEST(Labels, EveryVoxelStaysOnItsSide) {
  Random random;
  for (int round = 0; round < test::rounds_of("KIBORI_ROUNDS", 30); round++) {
    const Index3 size(random.integer(1, 12), random.integer(1, 12), random.integer(1, 12));
    const int lump = random.integer(1, 4);
    std::map<std::array<int, 3>, uint16_t> lumps;
    const LabelVolume volume = volume_of(size, Vec3::Ones(), [&](const Vec3& p) {
      const std::array<int, 3> key{static_cast<int>(p.x()) / lump, static_cast<int>(p.y()) / lump,
                                   static_cast<int>(p.z()) / lump};
      if (!lumps.contains(key)) lumps[key] = static_cast<uint16_t>(random.integer(0, 3));
      return lumps[key];
    });
    for (uint16_t label = 1; label <= 3; label++) {
      const ShapeGrid shape = shape_of_labels(volume, [&](uint16_t l) { return l == label; });
      for (size_t i = 0; i < shape.values.size(); i++)
        EXPECT_EQ(shape.values[i] > 0, volume.values[i] == label) << random.note();
    }
  }
}

// The steps of the voxels are gone: an oblique plane is flat within a tenth of a voxel.
TEST(Labels, LeaningPlanesArePlane) {
  const Vec3 normal = Vec3(0.12, 0.31, 1).normalized();
  const LabelVolume volume = volume_of(Index3(60, 60, 60), Vec3::Ones(), [&](const Vec3& p) {
    return static_cast<uint16_t>(normal.dot(p - Vec3(30, 30, 30)) < 0 ? 1 : 0);
  });
  const ShapeGrid shape = shape_of_labels(volume, [](uint16_t l) { return l == 1; });
  double worst = 0;
  for (double x = 20; x < 40; x += 0.31)
    for (double y = 20; y < 40; y += 0.37) {
      double low = 10, high = 50;
      for (int i = 0; i < 40; i++) {
        const double mid = (low + high) / 2;
        (interpolated(shape, Vec3(x, y, mid)) > 0 ? low : high) = mid;
      }
      worst = std::max(worst, std::abs(normal.dot(Vec3(x, y, low) - Vec3(30, 30, 30))));
    }
  EXPECT_LT(worst, 0.1);
  std::printf("a leaning plane is off by %.3f voxels at most\n", worst);
}

// A ball in a ball in a block, of 0.2 mm voxels: volumes to 0.1 %, faces to half a voxel.
TEST(Labels, VolumesAndFacesAreThoseOfTheShapes) {
  const Vec3 middle(10.03, 9.96, 10.01);
  constexpr double kVoxel = 0.2, kInner = 5, kOuter = 8;
  const LabelVolume volume =
      volume_of(Index3(100, 100, 100), Vec3::Constant(kVoxel), [&](const Vec3& p) -> uint16_t {
        const double r = (p - middle).norm();
        return r < kInner ? 2 : r < kOuter ? 1 : 0;
      });
  Lattice lattice;
  lattice.pitch_mm = 0.15;
  lattice.nodes = Index3(140, 140, 140);
  TriDexel model(lattice);
  Removed added;
  const ShapeGrid all = shape_of_labels(volume, [](uint16_t l) { return l > 0; }),
                  two = shape_of_labels(volume, [](uint16_t l) { return l == 2; });
  deposit(model, GridSolid(all, Vec3::Zero(), lattice), 0, {}, added);
  cut(model, GridSolid(two, Vec3::Zero(), lattice), {}, added);
  deposit(model, GridSolid(two, Vec3::Zero(), lattice), 1, {}, added);
  const double pi = std::acos(-1.0), inner = 4 / 3.0 * pi * std::pow(kInner, 3),
               outer = 4 / 3.0 * pi * std::pow(kOuter, 3);
  std::array<double, 2> volumes{};
  double farthest = 0;
  for (const Axis axis : kAxes)
    for (int v = 0; v < 140; v++)
      for (int u = 0; u < 140; u++)
        model.field(axis).view().for_spans(u, v, [&](const Span& s) {
          volumes[s.material] += double{s.out - s.in} * std::pow(lattice.pitch_mm, 3) / 3;
          for (const float end : {s.in, s.out}) {
            Vec3 at;
            at[u_index(axis)] = u + 0.5;
            at[v_index(axis)] = v + 0.5;
            at[depth_index(axis)] = end;
            const Vec3 from = lattice.to_mm(LatticePoint{at}) - middle;
            const double off =
                std::min(std::abs(from.norm() - kInner), std::abs(from.norm() - kOuter));
            farthest = std::max(farthest, off);
          }
        });
  EXPECT_NEAR(volumes[1], inner, 0.001 * inner);
  EXPECT_NEAR(volumes[0], outer - inner, 0.001 * (outer - inner));
  EXPECT_NEAR(model.volume_mm3(), outer, 0.001 * outer);
  // Half the diagonal of a voxel.
  EXPECT_LT(farthest, kVoxel * std::sqrt(3.0) / 2);
}

TEST(Labels, NormalsPointOut) {
  const Vec3 middle(10, 10, 10);
  const LabelVolume volume =
      volume_of(Index3(40, 50, 80), Vec3(0.5, 0.4, 0.25),
                [&](const Vec3& p) -> uint16_t { return (p - middle).norm() < 8 ? 3 : 0; });
  Lattice lattice;
  lattice.pitch_mm = 0.25;
  lattice.nodes = Index3(80, 80, 80);
  TriDexel model(lattice);
  Removed added;
  const ShapeGrid shape = shape_of_labels(volume, [](uint16_t l) { return l == 3; });
  deposit(model, GridSolid(shape, Vec3::Zero(), lattice), 0, {}, added);
  double sum = 0;
  int count = 0;
  for (const Axis axis : kAxes)
    for (int v = 0; v < 80; v++)
      for (int u = 0; u < 80; u++)
        model.field(axis).view().for_spans(u, v, [&](const Span& s) {
          for (const bool out : {false, true}) {
            Vec3 at;
            at[u_index(axis)] = u + 0.5;
            at[v_index(axis)] = v + 0.5;
            at[depth_index(axis)] = out ? s.out : s.in;
            const Vec3 radial = (lattice.to_mm(LatticePoint{at}) - middle).normalized();
            // Skips ends where the surface is nearly parallel to the ray.
            if (std::abs(radial[depth_index(axis)]) < 0.3) continue;
            const Vec3 n = decode_normal(out ? s.normal_out : s.normal_in, axis, out);
            sum += n.dot(radial);
            count++;
          }
        });
  EXPECT_GT(count, 10000);
  EXPECT_GT(sum / count, 0.995);
}

// ---- NRRD

std::string bytes_of(const std::vector<uint16_t>& labels, int bytes, bool big) {
  std::string out;
  for (const uint16_t label : labels)
    for (int b = 0; b < bytes; b++) {
      const int shift = 8 * (big ? bytes - 1 - b : b);
      out += shift < 16 ? static_cast<char>(label >> shift & 0xff) : '\0';
    }
  return out;
}

std::string zipped(const std::string& raw) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string out(raw.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(raw.data()));
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.erase(out.size() - stream.avail_out);
  deflateEnd(&stream);
  return out;
}

Result<LabelVolume> parsed(const std::string& text) {
  return parse_nrrd({text.data(), text.size()}, {}, "a.nrrd");
}

TEST(Nrrd, EveryTypeAndEncodingIsRead) {
  Random random;
  std::vector<uint16_t> labels(2 * 3 * 4);
  for (uint16_t& label : labels) label = static_cast<uint16_t>(random.integer(0, 120));
  const std::string sizes = "dimension: 3\nsizes: 2 3 4\nspacings: 0.5 1 2\n";
  struct Type {
    const char* name;
    int bytes;
  };
  for (const Type& type : {Type{"uchar", 1},
                           {"int8", 1},
                           {"unsigned short", 2},
                           {"short", 2},
                           {"uint32_t", 4},
                           {"int", 4},
                           {"long long int", 8},
                           {"uint64", 8}})
    for (const bool big : {false, true})
      for (const char* encoding : {"raw", "gzip", "ascii"}) {
        std::string text = std::string("NRRD0004\n# by a test\ntype: ") + type.name + "\n" + sizes +
                           "encoding: " + encoding + "\nendian: " + (big ? "big" : "little") +
                           "\n\n";
        const std::string raw = bytes_of(labels, type.bytes, big);
        if (std::string(encoding) == "raw") text += raw;
        if (std::string(encoding) == "gzip") text += zipped(raw);
        if (std::string(encoding) == "ascii")
          for (const uint16_t label : labels) text += std::to_string(label) + "\n";
        const auto volume = parsed(text);
        ASSERT_TRUE(volume) << volume.error();
        EXPECT_EQ(volume.value().values, labels) << type.name << " " << encoding;
        EXPECT_EQ(volume.value().voxel_mm, Vec3(0.5, 1, 2));
        EXPECT_EQ(volume.value().at(1, 2, 3, 0), labels.back());
      }
}

// As Slicer writes them: x and y of the file are opposite to those of the space; segments have
// names.
TEST(Nrrd, AxesAreTurnedToTheSpaceAndSegmentsHaveNames) {
  const std::string text =
      "NRRD0005\r\ntype: unsigned char\r\ndimension: 3\r\nspace: left-posterior-superior\r\n"
      "sizes: 2 2 3\r\nspace directions: (0,0,0.4) (-0.3,0.01,0) (0,-0.2,0)\r\nkinds: domain "
      "domain domain\r\nencoding: raw\r\nspace origin: (10,20,30)\r\nspace units: \"mm\" \"mm\" "
      "\"mm\"\r\nSegment0_LabelValue:=2\r\nSegment0_Name:=Enamel\r\n\r\n"
      "\1\2\3\4\5\6\7\x8\x9\xa\xb\xc";
  const auto volume = parsed(text);
  ASSERT_TRUE(volume) << volume.error();
  // The file's axes are z, -x, -y.
  EXPECT_TRUE((volume.value().size == Index3(2, 3, 2)).all());
  EXPECT_TRUE(volume.value().voxel_mm.isApprox(Vec3(std::hypot(0.3, 0.01), 0.2, 0.4), 1e-12));
  EXPECT_EQ(volume.value().at(1, 2, 0, 0), 1);
  EXPECT_EQ(volume.value().at(1, 2, 1, 0), 2);
  EXPECT_EQ(volume.value().at(0, 2, 0, 0), 3);
  EXPECT_EQ(volume.value().at(1, 1, 0, 0), 5);
  EXPECT_EQ(volume.value().at(0, 0, 1, 0), 12);
  EXPECT_EQ(volume.value().names.at(2), "Enamel");
}

// LPS, RAS and LAS files of the same labels differ by mirrors, also by their short names.
TEST(Nrrd, SpacesAreTurnedToLps) {
  const auto in_space = [](const std::string& space) {
    return parsed("NRRD0004\ntype: uchar\ndimension: 3\nspace: " + space +
                  "\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (0,0,1)\ncontent:\n"
                  "encoding: raw\n\n\1\2\3\4\5\6\7\x8");
  };
  const auto check = [&](const std::string& space, int flip_x, int flip_y) {
    const auto volume = in_space(space);
    ASSERT_TRUE(volume) << volume.error();
    for (int z = 0; z < 2; z++)
      for (int y = 0; y < 2; y++)
        for (int x = 0; x < 2; x++)
          EXPECT_EQ(volume.value().at(x ^ flip_x, y ^ flip_y, z, 0), 1 + x + 2 * y + 4 * z)
              << space;
  };
  for (const char* space : {"left-posterior-superior", "LPS", "scanner-xyz", "3D-right-handed"})
    check(space, 0, 0);
  for (const char* space : {"right-anterior-superior", "RAS"}) check(space, 1, 1);
  for (const char* space : {"left-anterior-superior", "LAS"}) check(space, 0, 1);
  check("3D-left-handed", 1, 0);
  EXPECT_NE(in_space("right-anterior-superior-time").error().find("space"), std::string::npos);
}

TEST(Nrrd, ABeginningIsSkipped) {
  const std::string head = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\n";
  const std::vector<uint16_t> labels{1, 2};
  for (const std::string& text :
       {head + "encoding: raw\nbyte skip: 3\n\nabc\1\2",
        head + "encoding: raw\nbyte skip: -1\n\nabc\1\2",
        head + "encoding: raw\nline skip: 2\n\na\nbc\n\1\2",
        head + "encoding: raw\nlineskip: 1\nbyteskip: 2\n\na\nbc\1\2",
        head + "encoding: ascii\nline skip: 1\n\nx y\n1 2\n",
        head + "encoding: gzip\nline skip: 1\nbyte skip: 3\n\na\n" + zipped("abc\1\2")}) {
    const auto volume = parsed(text);
    ASSERT_TRUE(volume) << volume.error() << text;
    EXPECT_EQ(volume.value().values, labels) << text;
  }
  for (const std::string& text : {head + "encoding: raw\nbyte skip: 9\n\nabc\1\2",
                                  head + "encoding: raw\nbyte skip: -2\n\nabc\1\2",
                                  head + "encoding: raw\nline skip: 9\n\na\n\1\2",
                                  head + "encoding: gzip\nbyte skip: -1\n\n" + zipped("abc\1\2"),
                                  head + "encoding: gzip\nbyte skip: 9\n\n" + zipped("abc\1\2")})
    EXPECT_FALSE(parsed(text)) << text;
}

TEST(Nrrd, DataMayBeInASeparateFile) {
  Folder folder;
  std::ofstream(folder / "a.nhdr") << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\n"
                                      "encoding: raw\nunits: x\ndata file: ./a.raw\n";
  std::ofstream(folder / "a.raw") << "\1\2";
  const auto volume = read_volume(folder / "a.nhdr");
  ASSERT_TRUE(volume) << volume.error();
  EXPECT_EQ(volume.value().values, (std::vector<uint16_t>{1, 2}));
  std::ofstream(folder / "b.nhdr") << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\n"
                                      "encoding: raw\ndata file: ../a.raw\n";
  EXPECT_FALSE(read_volume(folder / "b.nhdr"));
  EXPECT_FALSE(read_volume(folder / "c.nhdr"));
  std::ofstream(folder / "d.nrrd")
      << "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n0 0\n";
  EXPECT_NE(read_volume(folder / "d.nrrd").error().find("only air"), std::string::npos);
}

TEST(Nrrd, BadFilesAreOneSentence) {
  const std::string good = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\n";
  ASSERT_TRUE(parsed(good + "\1\2"));
  const auto with = [&](const char* from, const char* to) {
    std::string text = good + "\1\2";
    text.replace(text.find(from), std::string(from).size(), to);
    return text;
  };
  struct Case {
    std::string text;
    const char* expected;
  };
  for (const Case& one :
       {Case{"", "not an NRRD"},
        {"NRRD0004\n", "type"},
        {good + "\1", "damaged"},
        {good + "\1\2\3", "damaged"},
        {with("uchar", "float"), "whole numbers"},
        {with("type: uchar\n", ""), "has no field 'type'"},
        {with("dimension: 3", "dimension: 4"), "three"},
        {with("2 1 1", "2 1"), "sizes"},
        {with("2 1 1", "2 1 1 1"), "sizes"},
        {with("2 1 1", "0 1 1"), "sizes"},
        {with("2 1 1", "2 1 99999999999"), "sizes"},
        {with("2 1 1", "2048 2048 2048"), "voxels"},
        {with("raw", "bzip2"), "bzip2"},
        {with("raw", "gzip"), "damaged"},
        {"NRRD0004\ntype: int8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n\n\xff\1", "0 to 65535"},
        {with("encoding", "spacings: 0 1 1\nencoding"), "axes"},
        {with("encoding", "spacings: nan 1 1\nencoding"), "spacings"},
        {with("encoding", "space directions: (1,0,0) (1,0,0) (0,0,1)\nencoding"), "axes"},
        {with("encoding", "space directions: (1,0,0) none (0,0,1)\nencoding"), "directions"},
        {with("encoding", "space units: \"furlong\"\nencoding"), "furlong"},
        {with("encoding", "byte skip: -3\nencoding"), "byte skip"},
        {with("encoding", "space: elsewhere\nencoding"), "elsewhere"},
        {with("encoding", "nonsense\nencoding"), "line 5"}}) {
    const auto volume = parsed(one.text);
    ASSERT_FALSE(volume) << one.text;
    EXPECT_NE(volume.error().find(one.expected), std::string::npos) << volume.error();
    EXPECT_EQ(volume.error().find('\n'), std::string::npos);
  }
}

// Changed and truncated bytes give a volume or an error message of one sentence.
TEST(Nrrd, DamageIsSurvived) {
  Random random;
  const std::string good =
      "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 2 3 2\nspace directions: (1,0,0) (0,1,0) "
      "(0,0,1)\nendian: little\nencoding: gzip\n\n" +
      zipped(std::string(24, '\1'));
  ASSERT_TRUE(parsed(good));
  for (int round = 0; round < test::rounds_of("KIBORI_ROUNDS", 3000); round++) {
    std::string text = good;
    for (int i = random.integer(1, 4); i > 0; i--)
      text[static_cast<size_t>(random.integer(0, static_cast<int>(text.size()) - 1))] =
          static_cast<char>(random.integer(0, 255));
    if (random.integer(0, 3) == 0)
      text.resize(static_cast<size_t>(random.integer(0, static_cast<int>(text.size()))));
    const auto volume = parsed(text);
    if (volume) {
      EXPECT_EQ(
          static_cast<int64_t>(volume.value().values.size()),
          int64_t{volume.value().size.x()} * volume.value().size.y() * volume.value().size.z());
    } else {
      EXPECT_FALSE(volume.error().empty());
      EXPECT_EQ(volume.error().find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace kibori::labels_tests
