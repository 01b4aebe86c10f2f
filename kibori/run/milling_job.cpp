// SPDX-License-Identifier: MIT
#include <kibori/run/milling_job.h>

#include <cmath>
#include <numbers>
#include <utility>

#include <kibori/base/file.h>
#include <kibori/base/trig.h>
#include <kibori/scene/scene_reader.h>

namespace kibori {
namespace {

constexpr uint64_t kMaxJobBytes = uint64_t{1} << 20;
constexpr size_t kMaxSetups = 1000;

// Rotation about a coordinate axis. Quarter turns are exact, so that faces stay parallel to the
// coordinate planes.
Mat3 turned(int axis, double degrees) {
  const double rest = degrees - 360 * std::floor(degrees / 360);
  const SinCos angle = sin_cos(rest * (std::numbers::pi / 180));
  const bool quarter = std::fmod(rest, 90) == 0;
  const double cosine = quarter ? std::round(angle.cos) : angle.cos,
               sine = quarter ? std::round(angle.sin) : angle.sin;
  Mat3 matrix = Mat3::Identity();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  matrix(u, u) = matrix(v, v) = cosine;
  matrix(v, u) = sine;
  matrix(u, v) = -sine;
  return matrix;
}

// Reads job files. File names in them are relative to the folder.
class JobReader {
 public:
  explicit JobReader(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void read(const TableReader& root, MillJob& job) {
    root.only({"stock", "pitch", "material", "tolerance", "tools", "machine", "setup"});
    read_stock(root, job);
    if (root.has("pitch")) job.pitch_mm = root.positive("pitch");
    if (root.has("tolerance")) job.tolerance_mm = root.positive("tolerance");
    if (root.has("material")) job.material = root.text("material");
    MillJobSetup common;
    read_file_of(root, "tools", common.tools);
    read_file_of(root, "machine", common.machine);
    const std::string example = "a set-up is written as [[setup]], with programs = [\"part.nc\"]";
    root.for_tables("setup", example, [&](const TableReader& t) {
      if (job.setups.size() >= kMaxSetups) return t.fail("a job has at most 1000 set-ups");
      MillJobSetup setup = common;
      setup.name = std::to_string(job.setups.size() + 1);
      if (!job.setups.empty()) setup.frame = job.setups.back().frame;
      read_setup(t, setup);
      job.setups.push_back(std::move(setup));
    });
    if (job.setups.empty()) root.fail(0, "needs at least one set-up; " + example);
  }

 private:
  void read_stock(const TableReader& root, MillJob& job) {
    if (!root.has("stock"))
      return root.fail(0,
                       "stock is missing; give the corners of a block, as in stock = [0, 0, -20, "
                       "80, 60, 0], or a file");
    if (root.find("stock")->is_string()) {
      job.stock = folder_ / root.text("stock");
      return;
    }
    const std::vector<double> n = root.numbers("stock", 6);
    if (root.failed()) return;
    const Box box{Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])};
    if (!(box.size().array() > 0).all())
      return root.fail("stock",
                       "stock must be two corners, the lower one first: [x0, y0, z0, x1, y1, z1]");
    job.stock = box;
  }

  void read_file_of(const TableReader& t, const char* key, std::filesystem::path& file) const {
    if (t.has(key)) file = folder_ / t.text(key);
  }
  void read_files(const TableReader& t, const char* key,
                  std::vector<std::filesystem::path>& files) const {
    if (!t.has(key)) return;
    const toml::array* const list = t.find(key)->as_array();
    const auto wrong = [&] { t.fail(key, t.full(key) + " must be a list of files in quotes"); };
    if (!list) return wrong();
    for (const toml::node& one : *list) {
      const auto file = one.value_exact<std::string>();
      if (!file) return wrong();
      files.push_back(folder_ / *file);
    }
  }

  void read_setup(const TableReader& t, MillJobSetup& setup) const {
    t.only({"name", "programs", "tools", "machine", "tool", "turn", "shift", "fixtures", "target"});
    if (t.has("name")) setup.name = t.text("name");
    read_files(t, "programs", setup.programs);
    if (!t.failed() && setup.programs.empty())
      return t.fail(t.full("programs is missing, as in programs = [\"part.nc\"]"));
    read_file_of(t, "tools", setup.tools);
    read_file_of(t, "machine", setup.machine);
    read_file_of(t, "target", setup.target);
    read_files(t, "fixtures", setup.fixtures);
    if (t.has("tool")) {
      const double number = t.number("tool");
      if (!(number >= 1 && number <= 99999 && number == std::floor(number)))
        return t.fail("tool", t.full("tool must be the number of a tool, 1 to 99999"));
      setup.tool = static_cast<int>(number);
    }
    // The part turns about the origin of the set-up before, and is then shifted: new = turn * old +
    // shift.
    Mat3 turn = Mat3::Identity();
    if (t.has("turn")) {
      const Vec3 degrees = t.vector("turn");
      // After an error, `degrees` is arbitrary.
      if (t.failed()) return;
      if (!(degrees.cwiseAbs().maxCoeff() <= 3600))
        return t.fail("turn", t.full("turn must be angles of at most 3600 degrees"));
      turn = turned(2, degrees.z()) * turned(1, degrees.y()) * turned(0, degrees.x());
    }
    const Vec3 shift = t.has("shift") ? t.vector("shift") : Vec3(Vec3::Zero());
    const Mat3 back = turn.transpose();
    setup.frame = setup.frame.to_world(Pose{back * -shift, back});
  }

  std::filesystem::path folder_;
};

}  // namespace

Result<MillJob> parse_mill_job(const std::string& text, const std::string& name,
                               const std::filesystem::path& folder) {
  if (const Status flat = check_toml_depth(text, name); !flat) return Error{flat.error()};
  try {
    const toml::table parsed = toml::parse(text, name);
    SceneError error(name);
    MillJob job;
    JobReader(folder).read(TableReader(error, parsed, ""), job);
    if (error.found()) return Error{error.sentence()};
    return job;
  } catch (const toml::parse_error& error) {
    return Error{sanitize_message(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                  std::string(error.description()))};
  }
}

Result<MillJob> read_mill_job(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path, kMaxJobBytes);
  if (!bytes) return Error{bytes.error()};
  return parse_mill_job({bytes.value().begin(), bytes.value().end()}, path.string(),
                        path.parent_path());
}

}  // namespace kibori
