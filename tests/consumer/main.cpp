// SPDX-License-Identifier: MIT
// Example of a program that uses an installed Kibori. First it carves a block with a ball tick by
// tick, and prints the force. Then it carves a scene into a document with a thumbnail, writes the
// model as 3MF, and draws a picture of it.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <kibori/kibori.h>

namespace {

using namespace kibori;

int fail(const std::string& what) { return std::fprintf(stderr, "%s\n", what.c_str()), 2; }

int by_ticks() {
  Result<Lattice> lattice = make_lattice(Vec3(30, 20, 10), 0.25, 1);
  if (!lattice) return fail(lattice.error());
  TriDexel model(lattice.value());
  model.fill_block({Vec3::Zero(), Vec3(30, 20, 10)}, 0);
  DirectTool tool(model, Pose{Vec3(-5, 10, 7), Mat3::Identity()});
  double removed = 0, force = 0;
  for (int i = 1; i <= 100; i++) {
    const auto tick = tool.advance(BallTool{4}, Vec3(-5 + 0.2 * i, 10, 7), Vec3::Zero(), Mode::cut,
                                   {ForceModel::energy, 6}, {Material{}});
    if (!tick) return fail(tick.error());
    removed += tick.value().removed_mm3;
    force = tick.value().wrench.force.norm();
  }
  std::printf("removed %.3f mm3, force %.3f N\n", removed, force);
  return removed > 0 && force > 0 ? 0 : 1;
}

const char* const kScene = R"(
[stock]
block = [20, 10, 8]
pitch = 0.25
[tool]
shape = "ball"
radius = 3
[force]
model = "energy"
[[move]]
to = [-4, 5, 6]
mode = "off"
[[move]]
to = [24, 5, 6]
speed = 100
mode = "cut"
)";

int by_scene(const std::filesystem::path& folder) {
  const std::filesystem::path document = folder / "scene.kibori";
  const Result<Scene> scene = parse_scene(kScene, "scene", {});
  if (!scene) return fail(scene.error());
  CarveOptions options;
  options.document = document;
  options.warning = [](const std::string& text) { fail(text); };
  const Result<Carving> carving = carve(scene.value(), options);
  if (!carving) return fail(carving.error());
  const CarveSummary& summary = carving.value().summary;
  const auto kept = Document::open(document, Document::Access::read);
  if (!kept) return fail(kept.error());
  const auto thumbnail = kept.value()->thumbnail(kept.value()->head());
  if (!thumbnail) return fail(thumbnail.error());
  const Snapshot model = carving.value().model->snapshot();
  const std::vector<Rgb> colors = {{196, 154, 108}};
  const auto written = write_model(folder / "scene.3mf", model, colors, 0, 1);
  if (!written) return fail(written.error());
  PictureOptions how;
  how.width = 64;
  how.height = 48;
  const auto picture = draw_picture(extract_surface(model, 1), colors, how);
  if (!picture) return fail(picture.error());
  std::printf(
      "carve: removed %.3f mm3, left %.3f mm3, thumbnail of %zu bytes, %zu triangles, %zu bytes of "
      "picture\n",
      summary.removed_mm3, summary.volume_mm3, thumbnail.value().size(), written.value(),
      picture.value().pixels.size());
  const bool adds_up = std::abs(summary.removed_mm3 + summary.volume_mm3 - 20 * 10 * 8) < 1;
  return adds_up && summary.removed_mm3 > 0 && !thumbnail.value().empty() && written.value() > 100
             ? 0
             : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return fail("usage: consumer FOLDER");
  const int status = by_ticks();
  return status ? status : by_scene(argv[1]);
}
