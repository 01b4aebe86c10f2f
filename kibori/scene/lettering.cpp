// SPDX-License-Identifier: MIT
#include <kibori/scene/lettering.h>

#include <GL/glu.h>
#include <fontconfig/fontconfig.h>
#include <ft2build.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

namespace kibori {
namespace {

// Smallest tolerance of outlines, as a share of the height (Lettering::tolerance_mm).
constexpr double kFlat = 1.0 / 1000;
constexpr double kMinMm = 0.1, kMaxMm = 1000;
// Height of a capital H as a share of an em, for fonts without an H.
constexpr double kCapital = 0.7;
constexpr size_t kMaxPoints = 200'000;

using Point = Eigen::Vector2d;
using Contour = std::vector<Point>;

template <class T, auto destroy>
struct Destroy {
  void operator()(T* t) const { destroy(t); }
};
using Pattern = std::unique_ptr<FcPattern, Destroy<FcPattern, FcPatternDestroy>>;
using FontSet = std::unique_ptr<FcFontSet, Destroy<FcFontSet, FcFontSetDestroy>>;
using Objects = std::unique_ptr<FcObjectSet, Destroy<FcObjectSet, FcObjectSetDestroy>>;
using Library = std::unique_ptr<FT_LibraryRec_, Destroy<FT_LibraryRec_, FT_Done_FreeType>>;
using Face = std::unique_ptr<FT_FaceRec_, Destroy<FT_FaceRec_, FT_Done_Face>>;
using Tessellator = std::unique_ptr<GLUtesselator, Destroy<GLUtesselator, gluDeleteTess>>;

// ---- Search for a font

struct FontFile {
  std::string path;
  int index = 0;
};

// The names of a font's family in all languages.
std::vector<std::string> families_of(const FcPattern* pattern) {
  std::vector<std::string> names;
  FcChar8* name = nullptr;
  for (int i = 0; FcPatternGetString(pattern, FC_FAMILY, i, &name) == FcResultMatch; i++)
    names.emplace_back(reinterpret_cast<const char*>(name));
  return names;
}

bool same_name(const std::string& a, const std::string& b) {
  return FcStrCmpIgnoreCase(reinterpret_cast<const FcChar8*>(a.c_str()),
                            reinterpret_cast<const FcChar8*>(b.c_str())) == 0;
}

Result<FontFile> find_font(const std::string& font) {
  std::error_code ignored;
  if (font.find('/') != std::string::npos) {
    if (std::filesystem::is_regular_file(font, ignored)) return FontFile{font, 0};
    return Error{font + ": no such font file; give the path of a font, or a family"};
  }
  const Pattern wanted(FcNameParse(reinterpret_cast<const FcChar8*>(font.c_str())));
  if (!wanted || families_of(wanted.get()).empty())
    return Error{sanitize_message(font) + " names no font; try a family, as in DejaVu Sans"};
  const std::string family = families_of(wanted.get()).front();
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result = FcResultNoMatch;
  const Pattern found(FcFontMatch(nullptr, wanted.get(), &result));
  if (found) {
    // Fontconfig always finds some font. Only the requested family is accepted.
    const std::vector<std::string> names = families_of(found.get());
    FcChar8* path = nullptr;
    FontFile file;
    if (std::any_of(names.begin(), names.end(),
                    [&](const std::string& name) { return same_name(name, family); }) &&
        FcPatternGetString(found.get(), FC_FILE, 0, &path) == FcResultMatch) {
      file.path = reinterpret_cast<const char*>(path);
      FcPatternGetInteger(found.get(), FC_INDEX, 0, &file.index);
      return file;
    }
  }
  const std::vector<std::string> all = font_families();
  std::string error = "no font called '";
  error.append(sanitize_message(family)).append("' is installed; ");
  for (size_t i = 0; i < std::min<size_t>(all.size(), 5); i++)
    error.append(i ? ", " : "use one of ").append(all[i]);
  return Error{error.append(all.empty() ? "install a font first" : ", ...")};
}

// ---- The outlines of letters

// Callbacks that FreeType calls for each part of an outline. They append points [font units].
struct Outlines {
  std::vector<Contour> contours;
  Point offset = Point::Zero();
  double tolerance = 1;

  Point place(const FT_Vector* v) const {
    return Point(static_cast<double>(v->x), static_cast<double>(v->y)) + offset;
  }
  static Outlines& of(void* user) { return *static_cast<Outlines*>(user); }
  static int move(const FT_Vector* to, void* user) {
    of(user).contours.push_back({of(user).place(to)});
    return 0;
  }
  static int line(const FT_Vector* to, void* user) {
    of(user).contours.back().push_back(of(user).place(to));
    return 0;
  }
  static int conic(const FT_Vector* control, const FT_Vector* to, void* user) {
    const Outlines& self = of(user);
    const Point c = self.place(control), b = self.place(to);
    const Point a = self.contours.back().back();
    // The same curve, written as a cubic curve.
    of(user).curve(a, Point((a + 2 * c) / 3), Point((b + 2 * c) / 3), b);
    return 0;
  }
  static int cubic(const FT_Vector* c0, const FT_Vector* c1, const FT_Vector* to, void* user) {
    Outlines& self = of(user);
    const Point a = self.contours.back().back();
    self.curve(a, self.place(c0), self.place(c1), self.place(to));
    return 0;
  }
  void curve(const Point& a, const Point& c0, const Point& c1, const Point& b) {
    // A chord over 1/n of a curve is within |second derivative| / 8 n^2 of it.
    const double second = 6 * std::max((a - 2 * c0 + c1).norm(), (c0 - 2 * c1 + b).norm());
    const int n =
        std::clamp(static_cast<int>(std::ceil(std::sqrt(second / (8 * tolerance)))), 1, 100);
    for (int i = 1; i < n; i++) {
      const double t = static_cast<double>(i) / n, s = 1 - t;
      contours.back().push_back(s * s * s * a + 3 * s * s * t * c0 + 3 * s * t * t * c1 +
                                t * t * t * b);
    }
    contours.back().push_back(b);
  }
};

std::optional<std::vector<FcChar32>> letters_of(const std::string& text) {
  std::vector<FcChar32> letters;
  const auto* at = reinterpret_cast<const FcChar8*>(text.data());
  for (int left = static_cast<int>(text.size()); left > 0;) {
    FcChar32 letter = 0;
    const int used = FcUtf8ToUcs4(at, &letter, left);
    if (used <= 0) return std::nullopt;
    letters.push_back(letter);
    at += used;
    left -= used;
  }
  return letters;
}

// Height of a capital H [font units].
double capital_of(FT_Face face) {
  const FT_UInt glyph = FT_Get_Char_Index(face, 'H');
  if (glyph && FT_Load_Glyph(face, glyph, FT_LOAD_NO_SCALE) == 0) {
    FT_BBox box;
    FT_Outline_Get_CBox(&face->glyph->outline, &box);
    if (box.yMax > 0) return static_cast<double>(box.yMax);
  }
  return kCapital * face->units_per_EM;
}

Result<std::vector<Contour>> outlines_of(const std::vector<FcChar32>& letters, FT_Face face,
                                         double tolerance) {
  FT_Outline_Funcs calls{};
  calls.move_to = Outlines::move;
  calls.line_to = Outlines::line;
  calls.conic_to = Outlines::conic;
  calls.cubic_to = Outlines::cubic;
  Outlines drawn;
  drawn.tolerance = tolerance;
  // The middle of each line is at x = 0.
  Point pen = Point::Zero();
  size_t line_begins = 0;
  FT_UInt before = 0;
  const auto end_line = [&] {
    for (size_t i = line_begins; i < drawn.contours.size(); i++)
      for (Point& p : drawn.contours[i]) p.x() -= pen.x() / 2;
    line_begins = drawn.contours.size();
    pen = Point(0, pen.y() - face->height);
    before = 0;
  };
  for (const FcChar32 letter : letters) {
    if (letter == '\n') {
      end_line();
      continue;
    }
    const FT_UInt glyph = FT_Get_Char_Index(face, letter);
    if (!glyph) {
      FcChar8 utf8[FC_UTF8_MAX_LEN + 1] = {};
      FcUcs4ToUtf8(letter, utf8);
      std::string error = "the font ";
      error.append(face->family_name).append(" has no letter '");
      error.append(sanitize_message(reinterpret_cast<const char*>(utf8)))
          .append("'; use another font");
      return Error{error};
    }
    FT_Vector kern{};
    if (before && FT_Get_Kerning(face, before, glyph, FT_KERNING_UNSCALED, &kern) == 0)
      pen.x() += static_cast<double>(kern.x);
    before = glyph;
    drawn.offset = pen;
    if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_SCALE) != 0 ||
        face->glyph->format != FT_GLYPH_FORMAT_OUTLINE ||
        FT_Outline_Decompose(&face->glyph->outline, &calls, &drawn) != 0)
      return Error{std::string("the font ") + face->family_name +
                   " has letters without outlines; use another font"};
    pen.x() += static_cast<double>(face->glyph->advance.x);
  }
  end_line();
  return std::move(drawn.contours);
}

// ---- From outlines to a solid

// Collects the triangles with which GLU covers the inside of the outlines. Every three corners form
// a triangle.
struct Inside {
  std::deque<Eigen::Vector3d> points;  // a deque, because GLU keeps their addresses
  std::vector<const double*> corners;
  bool failed = false;

  static void begin(GLenum) {}
  static void end() {}
  // With this callback, GLU emits only triangles.
  static void edge(GLboolean) {}
  static void vertex(void* data, void* user) {
    static_cast<Inside*>(user)->corners.push_back(static_cast<const double*>(data));
  }
  static void combine(GLdouble at[3], void* [4], GLfloat[4], void** out, void* user) {
    auto& points = static_cast<Inside*>(user)->points;
    points.emplace_back(at[0], at[1], 0);
    *out = points.back().data();
  }
  static void error(GLenum, void* user) { static_cast<Inside*>(user)->failed = true; }
};

std::optional<TriangleMesh> extruded(const std::vector<Contour>& contours, double depth) {
  Inside inside;
  const Tessellator tess(gluNewTess());
  using Callback = void (*)();
  const auto call = [&](GLenum which, auto* function) {
    gluTessCallback(tess.get(), which, reinterpret_cast<Callback>(function));
  };
  call(GLU_TESS_BEGIN, Inside::begin);
  call(GLU_TESS_END, Inside::end);
  call(GLU_TESS_EDGE_FLAG, Inside::edge);
  call(GLU_TESS_VERTEX_DATA, Inside::vertex);
  call(GLU_TESS_COMBINE_DATA, Inside::combine);
  call(GLU_TESS_ERROR_DATA, Inside::error);
  // Letters may overlap, and so may the parts of one letter.
  gluTessProperty(tess.get(), GLU_TESS_WINDING_RULE, GLU_TESS_WINDING_NONZERO);
  gluTessNormal(tess.get(), 0, 0, 1);
  gluTessBeginPolygon(tess.get(), &inside);
  for (const Contour& contour : contours) {
    gluTessBeginContour(tess.get());
    for (const Point& p : contour) {
      inside.points.emplace_back(p.x(), p.y(), 0);
      double* at = inside.points.back().data();
      gluTessVertex(tess.get(), at, at);
    }
    gluTessEndContour(tess.get());
  }
  gluTessEndPolygon(tess.get());
  if (inside.failed) return std::nullopt;

  // Each corner becomes one vertex of the bottom and one of the top. An edge that only one triangle
  // uses is on the outline and gets a wall.
  TriangleMesh mesh;
  std::map<std::pair<double, double>, uint32_t> numbers;
  std::vector<uint32_t> corners;
  corners.reserve(inside.corners.size());
  for (const double* p : inside.corners) {
    const auto [at, fresh] =
        numbers.try_emplace({p[0], p[1]}, static_cast<uint32_t>(numbers.size()));
    corners.push_back(at->second);
  }
  const auto count = static_cast<uint32_t>(numbers.size());
  mesh.vertices.resize(size_t{2} * count);
  for (const auto& [at, number] : numbers) {
    mesh.vertices[number] = Vec3(at.first, at.second, 0);
    mesh.vertices[number + count] = Vec3(at.first, at.second, depth);
  }
  std::set<std::pair<uint32_t, uint32_t>> open;
  for (size_t i = 0; i + 2 < corners.size(); i += 3) {
    const uint32_t of[3] = {corners[i], corners[i + 1], corners[i + 2]};
    if (of[0] == of[1] || of[1] == of[2] || of[2] == of[0]) continue;
    mesh.triangles.push_back({of[0], of[2], of[1]});
    mesh.triangles.push_back({of[0] + count, of[1] + count, of[2] + count});
    for (int e = 0; e < 3; e++)
      if (!open.erase({of[(e + 1) % 3], of[e]})) open.insert({of[e], of[(e + 1) % 3]});
  }
  for (const auto& [a, b] : open) {
    mesh.triangles.push_back({a, b, b + count});
    mesh.triangles.push_back({a, b + count, a + count});
  }
  return mesh;
}

}  // namespace

std::vector<std::string> font_families() {
  const Pattern any(FcPatternCreate());
  FcPatternAddBool(any.get(), FC_OUTLINE, FcTrue);
  const Objects wanted(FcObjectSetBuild(FC_FAMILY, nullptr));
  const FontSet fonts(FcFontList(nullptr, any.get(), wanted.get()));
  std::set<std::string> names;
  for (int i = 0; fonts && i < fonts->nfont; i++)
    if (const std::vector<std::string> of = families_of(fonts->fonts[i]); !of.empty())
      names.insert(of.front());
  return {names.begin(), names.end()};
}

Result<TriangleMesh> letter_mesh(const Lettering& lettering) {
  const auto fits = [](double mm) { return mm >= kMinMm && mm <= kMaxMm; };
  if (!fits(lettering.height_mm) || !fits(lettering.depth_mm))
    return Error{"letters must be 0.1 to 1000 mm high and deep"};
  if (lettering.text.size() > 4 * kMaxLetters)
    return Error{"a text may have at most 200 letters; use a shorter one"};
  const std::optional<std::vector<FcChar32>> letters = letters_of(lettering.text);
  if (!letters) return Error{"the text is not UTF-8; encode it as UTF-8"};
  if (letters->size() > kMaxLetters)
    return Error{"a text may have at most 200 letters; use a shorter one"};
  const Result<FontFile> file = find_font(lettering.font);
  if (!file) return Error{file.error()};

  FT_Library raw_library = nullptr;
  if (FT_Init_FreeType(&raw_library) != 0)
    return Error{"FreeType can't be started, probably because there is too little memory"};
  const Library library(raw_library);
  FT_Face raw_face = nullptr;
  if (FT_New_Face(library.get(), file.value().path.c_str(), file.value().index, &raw_face) != 0)
    return Error{file.value().path + ": can't be read as a font; use another one"};
  const Face face(raw_face);
  if (!FT_IS_SCALABLE(face.get()) || !(face->units_per_EM > 0) || !face->family_name)
    return Error{file.value().path + ": this font has no outlines; use another one"};

  const double capital = capital_of(face.get());
  const double scale = lettering.height_mm / capital,
               tolerance = std::max(capital * kFlat, lettering.tolerance_mm / scale);
  Result<std::vector<Contour>> drawn = outlines_of(*letters, face.get(), tolerance);
  if (!drawn) return Error{drawn.error()};
  size_t points = 0;
  for (const Contour& contour : drawn.value()) points += contour.size();
  if (points == 0) return Error{"the text has no letters with an outline; add letters"};
  if (points > kMaxPoints)
    return Error{
        "the text's letters have too many points for a tool; use fewer letters or a simpler font"};
  std::optional<TriangleMesh> mesh = extruded(drawn.value(), lettering.depth_mm);
  if (!mesh || mesh->triangles.empty())
    return Error{"the text's letters enclose no area; use another font"};
  const Vec3 middle = mesh->bounds().centre();
  for (Vec3& p : mesh->vertices) {
    p.x() = (p.x() - middle.x()) * scale;
    p.y() = (p.y() - middle.y()) * scale;
  }
  return std::move(*mesh);
}

}  // namespace kibori
