// SPDX-License-Identifier: MIT
// Reads [motion] and [symmetry] of a scene. They apply to all moves.
#include <kibori/scene/scene_reader.h>

namespace kibori {

void read_motion(SceneReader& reader, const TableReader& root) {
  const std::optional<TableReader> t = root.section("motion", false);
  if (!t) return;
  Scene& scene = reader.scene;
  t->only({"rate_hz"});
  if (t->has("rate_hz")) scene.rate_hz = t->positive("rate_hz");
  scene.force.spring.tick_s = 1 / scene.rate_hz;
}

void read_symmetry(SceneReader& reader, const TableReader& root) {
  const std::optional<TableReader> t = root.section("symmetry", false);
  if (!t) return;
  t->only({"planes", "fold", "axis", "centre"});
  Symmetry& symmetry = reader.scene.symmetry;
  if (t->has("planes"))
    for (const char c : t->text("planes")) {
      if (const auto axis = value_of<Axis>(std::string_view(&c, 1)))
        symmetry.planes[static_cast<size_t>(*axis)] = true;
      else
        t->fail("planes",
                "[symmetry] planes must be letters of \"xyz\", as in planes = \"xy\": the planes "
                "normal to these axes");
    }
  if (t->has("fold")) {
    const double fold = t->number("fold");
    symmetry.fold = fold >= 1 && fold <= kMaxFold ? static_cast<int>(fold) : 0;
    if (symmetry.fold != fold)
      t->fail("fold",
              "[symmetry] fold must be a whole number from 1 to " + std::to_string(kMaxFold));
  }
  t->choice("axis", symmetry.axis);
  reader.scene.symmetry_centred = t->has("centre");
  if (t->has("centre")) symmetry.centre_mm = t->vector("centre");
  if (const Status fits = check_symmetry(symmetry); !fits) t->fail("[symmetry] " + fits.error());
}

}  // namespace kibori
