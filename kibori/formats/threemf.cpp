// SPDX-License-Identifier: MIT
#include <kibori/formats/threemf.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <expat.h>

#include <kibori/base/tolerances.h>
#include <kibori/formats/surface_writer.h>
#include <kibori/formats/text.h>
#include <kibori/formats/threemf_check.h>
#include <kibori/formats/zip.h>

namespace kibori {
namespace {

constexpr const char* kModelPath = "3D/3dmodel.model";
constexpr const char* kModelType = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
constexpr int kMaxDepth = 32;         // max depth of components inside components
constexpr size_t kMaxParts = 1000;    // max number of model files in one archive
constexpr size_t kMaxItems = 100000;  // max number of components and build items

// --- writing

class ThreeMfWriter final : public SurfaceWriter {
 public:
  ThreeMfWriter(NewFile& file, Spool& vertices, Spool& triangles, std::span<const Rgb> colors)
      : zip_(file), vertices_(vertices), triangles_(triangles), colors_(colors) {}

  bool places() const override { return true; }
  void begin(const SurfaceObject& object) override {
    objects_.push_back({object.name, object.pose, vertices_.size(), 0, triangles_.size(), 0});
  }
  void put(const SurfacePart& part) override {
    for (const SurfaceVertex& v : part.vertices.first(part.own))
      vertices_.write(v.position.data(), 12);
    objects_.back().vertex_bytes += 12 * part.own;
    objects_.back().triangle_bytes += 24 * part.triangles.size();
    for (const SurfaceTriangle& t : part.triangles) {
      uint32_t row[6];  // three vertices, then the index of each one's colour
      for (size_t i = 0; i < 3; i++) {
        row[i] = part.number[t[i]];
        row[3 + i] = palette_of(color_of(part.vertices[t[i]], colors_));
      }
      triangles_.write(row, sizeof row);
    }
  }

  Status finish() override {
    zip_.begin("[Content_Types].xml");
    zip_.write(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
        "<Default Extension=\"rels\" "
        "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
        "<Default Extension=\"model\" "
        "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>"
        "</Types>\n");
    zip_.end();
    zip_.begin("_rels/.rels");
    std::string relationships(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
        "<Relationship Target=\"/");
    relationships.append(kModelPath).append("\" Id=\"model\" Type=\"").append(kModelType);
    zip_.write(relationships.append("\"/></Relationships>\n"));
    zip_.end();
    zip_.begin(kModelPath);
    std::string text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<model unit=\"millimeter\" xml:lang=\"en-US\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
        "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n"
        "<metadata name=\"Application\">Kibori</metadata>\n<resources>\n<m:colorgroup id=\"1\">\n";
    for (const Rgb& c : palette_) {
      char line[60];
      std::snprintf(line, sizeof line, "<m:color color=\"#%02X%02X%02X\"/>\n", c[0], c[1], c[2]);
      text += line;
    }
    text += "</m:colorgroup>\n";
    std::string build;
    int id = 1;  // the colour group has id 1, and the objects follow
    bool read = true;
    for (const Object& object : objects_) {
      if (object.triangle_bytes == 0) continue;
      text.append("<object id=\"").append(std::to_string(++id)).append("\" type=\"model\"");
      if (!object.name.empty()) text.append(" name=\"").append(escaped(object.name)).append("\"");
      text += " pid=\"1\" pindex=\"0\">\n<mesh>\n<vertices>\n";
      read = read && write_mesh(object, text);
      text += "</triangles>\n</mesh>\n</object>\n";
      build.append("<item objectid=\"").append(std::to_string(id)).append("\"");
      if (object.pose.tip != Vec3::Zero() || object.pose.frame != Mat3::Identity()) {
        build += " transform=\"";
        // 3MF multiplies row vectors by the matrix. Its rows are the columns of the frame.
        for (const double x : object.pose.frame.reshaped()) {
          add(build, x);
          build += ' ';
        }
        for (int i = 0; i < 3; i++) {
          add(build, object.pose.tip[i]);
          build += i < 2 ? " " : "\"";
        }
      }
      build += "/>\n";
    }
    text.append("</resources>\n<build>\n").append(build).append("</build>\n</model>\n");
    zip_.write(text);
    zip_.end();
    if (!read) return Error{"no space for temporary data next to the file"};
    return zip_.finish();
  }

 private:
  struct Object {
    std::string name;
    Pose pose;
    uint64_t first_vertex, vertex_bytes, first_triangle, triangle_bytes;  // bytes in the spools
  };

  bool write_mesh(const Object& object, std::string& text) {
    const auto vertices = [&](const char* data, size_t bytes) {
      for (size_t at = 0; at < bytes; at += 12) {
        float p[3];
        std::memcpy(p, data + at, sizeof p);
        text += "<vertex x=\"";
        add(text, p[0]);
        text += "\" y=\"";
        add(text, p[1]);
        text += "\" z=\"";
        add(text, p[2]);
        text += "\"/>\n";
        pass_on(text);
      }
    };
    if (!vertices_.read_back(12, vertices, object.first_vertex, object.vertex_bytes)) return false;
    text += "</vertices>\n<triangles>\n";
    return triangles_.read_back(
        24,
        [&](const char* data, size_t bytes) {
          constexpr const char* kNames[6] = {"<triangle v1=\"",    "\" v2=\"", "\" v3=\"",
                                             "\" pid=\"1\" p1=\"", "\" p2=\"", "\" p3=\""};
          const size_t shown = palette_.size() > 1 ? 6 : 3;
          for (size_t at = 0; at < bytes; at += 24) {
            uint32_t row[6];
            std::memcpy(row, data + at, sizeof row);
            for (size_t i = 0; i < shown; i++) {
              text += kNames[i];
              add(text, row[i]);
            }
            text += "\"/>\n";
            pass_on(text);
          }
        },
        object.first_triangle, object.triangle_bytes);
  }
  static std::string escaped(const std::string& name) {
    std::string out;
    for (const char c : name) {
      if (c == '&')
        out += "&amp;";
      else if (c == '<')
        out += "&lt;";
      else if (c == '"')
        out += "&quot;";
      else
        out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    return out;
  }
  template <class T>
  static void add(std::string& text, T number) {
    char digits[32];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  }
  void pass_on(std::string& text) {
    if (text.size() < 1 << 16) return;
    zip_.write(text);
    text.clear();
  }
  uint32_t palette_of(const Rgb& c) {
    const uint32_t key = static_cast<uint32_t>(c[0] << 16 | c[1] << 8 | c[2]);
    const auto [found, fresh] = index_.try_emplace(key, static_cast<uint32_t>(palette_.size()));
    if (fresh) palette_.push_back(c);
    return found->second;
  }

  ZipWriter zip_;
  Spool &vertices_, &triangles_;
  std::span<const Rgb> colors_;
  std::vector<Object> objects_;
  std::vector<Rgb> palette_;
  std::unordered_map<uint32_t, uint32_t> index_;
};

// --- reading

struct Placement {  // x' = linear * x + shift
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

struct Component {
  std::string path;  // of the model file that contains the object
  std::string object;
  Placement placement;
};

struct Object {
  TriangleMesh mesh;
  std::vector<Component> components;
  bool support = false;
};

using ObjectKey = std::pair<std::string, std::string>;  // path of the model file, id

// The attributes of an element, as expat passes them: names and values alternate.
class Attributes {
 public:
  explicit Attributes(const XML_Char** pairs) : pairs_(pairs) {}
  // Finds a value by the whole name; null if there is none.
  const char* find_exactly(std::string_view name) const {
    for (const XML_Char** p = pairs_; *p; p += 2)
      if (*p == name) return p[1];
    return nullptr;
  }
  // Finds a value by the name without its prefix; null if there is none.
  const char* find(std::string_view name) const {
    for (const XML_Char** p = pairs_; *p; p += 2)
      if (local(*p) == name) return p[1];
    return nullptr;
  }
  const XML_Char* const* pairs() const { return pairs_; }
  static std::string_view local(const char* name) {
    const char* colon = std::strrchr(name, ':');
    return colon ? colon + 1 : name;
  }

 private:
  const XML_Char** pairs_;
};

std::string_view trimmed(std::string_view text) {
  const auto space = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
  while (!text.empty() && space(text.front())) text.remove_prefix(1);
  while (!text.empty() && space(text.back())) text.remove_suffix(1);
  return text;
}

template <class T>
std::optional<T> number_of(std::string_view text) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Reads one XML entry of the archive with expat. Derived classes receive the elements. An error
// stops the reader.
class XmlReader {
 public:
  XmlReader(const ZipReader& zip, std::string entry) : zip_(zip), entry_(std::move(entry)) {}
  virtual ~XmlReader() = default;

  Status run() {
    parser_ = XML_ParserCreate(nullptr);
    if (!parser_) return Error{"out of memory"};
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(
        parser_,
        [](void* self, const XML_Char* name, const XML_Char** pairs) {
          static_cast<XmlReader*>(self)->check_prefixes(name, pairs);
          static_cast<XmlReader*>(self)->open(Attributes::local(name), Attributes(pairs));
        },
        [](void* self, const XML_Char* name) {
          auto& prefixes = static_cast<XmlReader*>(self)->prefixes_;
          static_cast<XmlReader*>(self)->close(Attributes::local(name));
          prefixes.resize(prefixes.empty() ? 0 : prefixes.size() - 1);
        });
    // A document type declaration can define entities that expand a small file to a gigabyte. 3MF
    // forbids it.
    XML_SetStartDoctypeDeclHandler(
        parser_, [](void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
          static_cast<XmlReader*>(self)->fail(
              "has a document type declaration, which the 3MF format forbids");
        });
    Status read = zip_.read(entry_, [&](std::string_view data) {
      if (XML_Parse(parser_, data.data(), static_cast<int>(data.size()), 0) == XML_STATUS_ERROR &&
          wrong_.empty())
        fail(std::string("is not valid XML: ") + XML_ErrorString(XML_GetErrorCode(parser_)));
      return wrong_.empty();
    });
    if (read && wrong_.empty() && XML_Parse(parser_, "", 0, 1) == XML_STATUS_ERROR)
      fail(std::string("is not valid XML: ") + XML_ErrorString(XML_GetErrorCode(parser_)));
    XML_ParserFree(parser_);
    if (!wrong_.empty()) return Error{wrong_};
    return read;
  }

 protected:
  virtual void open(std::string_view name, const Attributes& attributes) = 0;
  virtual void close(std::string_view) {}
  // Called for a name with a prefix that no attribute xmlns:PREFIX declares.
  virtual void found_undeclared(const std::string&) {}

  void fail(const std::string& what) {
    if (!wrong_.empty()) return;
    wrong_ = entry_ + ":" + std::to_string(XML_GetCurrentLineNumber(parser_)) + ": " + what;
    XML_StopParser(parser_, XML_FALSE);
  }
  bool failed() const { return !wrong_.empty(); }
  const std::string& entry() const { return entry_; }
  const ZipReader& zip() const { return zip_; }

  template <class T>
  T number(const Attributes& attributes, const char* name) {
    const char* text = attributes.find(name);
    const std::optional<T> value = text ? number_of<T>(text) : std::nullopt;
    bool good = value.has_value();
    if constexpr (std::is_floating_point_v<T>) good = good && std::isfinite(*value);
    if (good) return *value;
    fail(std::string("attribute '") + name + "' " +
         (text ? "is '" + std::string(text).substr(0, 30) + "', not a number" : "is missing"));
    return T{};
  }

 private:
  void check_prefixes(std::string_view element, const XML_Char* const* pairs) {
    std::vector<std::string>& declared = prefixes_.emplace_back();
    for (const XML_Char* const* p = pairs; *p; p += 2)
      if (std::string_view(*p).starts_with("xmlns:")) declared.emplace_back(*p + 6);
    const auto check = [&](std::string_view name) {
      const size_t colon = name.find(':');
      if (colon == std::string_view::npos) return;
      const std::string prefix(name.substr(0, colon));
      if (prefix == "xml" || prefix == "xmlns") return;
      for (const auto& level : prefixes_)
        if (std::find(level.begin(), level.end(), prefix) != level.end()) return;
      found_undeclared(prefix);
    };
    check(element);
    for (const XML_Char* const* p = pairs; *p; p += 2) check(*p);
  }

  const ZipReader& zip_;
  std::string entry_, wrong_;
  // For each open element, the prefixes that it declares.
  std::vector<std::vector<std::string>> prefixes_;
  XML_Parser parser_ = nullptr;
};

std::string without_slash(const std::string& path) {
  return path.starts_with('/') ? path.substr(1) : path;
}

class RelationshipReader final : public XmlReader {
 public:
  using XmlReader::XmlReader;
  std::string target;
  std::vector<std::string> notes;  // violations of the specification

 private:
  void open(std::string_view name, const Attributes& attributes) override {
    if (name != "Relationship") return;
    const char *type = attributes.find("Type"), *to = attributes.find("Target"),
               *mode = attributes.find("TargetMode");
    if (!type || !to) return;
    const std::string_view kind(type);
    if ((mode && std::string_view(mode) == "External") || std::strchr(to, ':'))
      notes.push_back("a part is stored in another file");
    if (kind == kModelType) {
      if (!target.empty()) notes.push_back("more than one model is listed; the last one is read");
      target = to;
    } else if (kind.ends_with("/thumbnail")) {
      if (!zip().has(without_slash(to))) notes.push_back("its picture is not in the archive");
    } else if (kind.ends_with("/printticket")) {
      if (tickets++ > 0) notes.push_back("more than one print ticket is listed");
    }
  }
  int tickets = 0;
};

using Note = std::function<void(const std::string&)>;

// Parts of slicers' projects that are not material: modifiers, supports, negative parts.
//
// PrusaSlicer joins the parts of an object to one mesh. A list has the triangles and the kind of
// each part. Bambu Studio and OrcaSlicer make each part a component. A list has the kind of each
// part.
struct SlicerParts {
  struct Range {
    uint64_t first, last;  // the first and the last triangle
  };
  std::map<std::string, std::vector<Range>> ranges;          // by object
  std::set<std::pair<std::string, std::string>> components;  // object, part
};

// Reads Metadata/Slic3r_PE_model.config (PrusaSlicer) or Metadata/model_settings.config (Bambu
// Studio and OrcaSlicer).
class SlicerReader final : public XmlReader {
 public:
  SlicerReader(const ZipReader& zip, const std::string& entry, SlicerParts& parts, const Note& note)
      : XmlReader(zip, entry), parts_(parts), note_(note) {}

 private:
  void open(std::string_view name, const Attributes& a) override {
    const auto text = [&](const char* key) { return std::string(a.find(key) ? a.find(key) : ""); };
    if (name == "object") {
      object_ = text("id");
    } else if (name == "part") {
      const std::string kind = text("subtype");
      if (!kind.empty() && kind != "normal_part") {
        parts_.components.insert({object_, text("id")});
        add_note(kind);
      }
    } else if (name == "volume") {
      first_ = number_of<uint64_t>(text("firstid"));
      last_ = number_of<uint64_t>(text("lastid"));
      kind_.clear();
    } else if (name == "metadata" && first_ && last_) {
      const std::string key = text("key"), value = text("value");
      if (key == "volume_type" && value != "ModelPart") kind_ = value;
      if (key == "modifier" && value == "1" && kind_.empty()) kind_ = "modifier";
    }
  }
  void close(std::string_view name) override {
    if (name != "volume") return;
    if (first_ && last_ && !kind_.empty()) {
      parts_.ranges[object_].push_back({*first_, *last_});
      add_note(kind_);
    }
    first_ = last_ = std::nullopt;
  }
  void add_note(const std::string& kind) {
    const bool negative = kind.starts_with("negative") || kind.starts_with("Negative");
    note_(negative ? "a negative part of the slicer's project is left out, and not cut out of the "
                     "other parts"
                   : "a part of the slicer's project that is not material is left out (" +
                         in_quotes(kind) + ")");
  }

  SlicerParts& parts_;
  const Note& note_;
  std::string object_, kind_;
  std::optional<uint64_t> first_, last_;
};

// True if a file may require the extension: either it does not change the mesh, or this reader
// supports it.
bool is_readable(std::string_view extension) {
  for (const std::string_view known :
       {"/3dmanufacturing/core/", "/3dmanufacturing/material/", "/3dmanufacturing/production/",
        "/3dmanufacturing/trianglesets/"})
    if (extension.find(known) != std::string_view::npos) return true;
  return false;
}

class ModelReader final : public XmlReader {
 public:
  ModelReader(const ZipReader& zip, const std::string& entry, std::map<ObjectKey, Object>& objects,
              size_t& total, size_t& items, const Note& note)
      : XmlReader(zip, entry),
        objects_(objects),
        total_(total),
        items_(items),
        note_(note),
        check_(note) {}

  double unit_mm = 1;
  std::vector<Component> build;

 private:
  void found_undeclared(const std::string& prefix) override { check_.found_undeclared(prefix); }
  void open(std::string_view name, const Attributes& a) override {
    if (failed()) return;
    check_.open(name, a.pairs());
    if (name == "model") {
      take_unit(a);
      check_extensions(a);
    } else if (name == "beamlattice" || name == "slicestack" || name == "volumetricstack") {
      note_("elements " + in_quotes(name) + " are ignored: only triangles are read");
    } else if (name == "object") {
      const char* id = a.find("id");
      if (!id) return fail("an object has no id");
      const auto [made, fresh] = objects_.try_emplace({entry(), id});
      if (!fresh) return fail("two objects have the id " + std::string(id).substr(0, 30));
      object_ = &made->second;
      const char* type = a.find("type");
      object_->support =
          type && (std::string_view(type) == "support" || std::string_view(type) == "other");
      if (object_->support) note_("objects of type " + in_quotes(type) + " are left out");
    } else if (name == "vertex" && object_) {
      const double x = number<double>(a, "x"), y = number<double>(a, "y"),
                   z = number<double>(a, "z");
      object_->mesh.vertices.emplace_back(x, y, z);
      if (object_->mesh.vertices.size() > 3 * kMaxImportTriangles) fail("too many vertices");
    } else if (name == "triangle" && object_) {
      const uint32_t v1 = number<uint32_t>(a, "v1"), v2 = number<uint32_t>(a, "v2"),
                     v3 = number<uint32_t>(a, "v3");
      if (failed()) return;
      const size_t count = object_->mesh.vertices.size();
      if (v1 >= count || v2 >= count || v3 >= count)
        return fail("a triangle refers to a missing vertex");
      object_->mesh.triangles.push_back({v1, v2, v3});
      if (++total_ > kMaxImportTriangles) fail("too many triangles");
    } else if (name == "component" && object_) {
      take_component(a, object_->components);
    } else if (name == "item") {
      take_component(a, build);
    }
  }
  void close(std::string_view name) override {
    if (name == "object") object_ = nullptr;
    if (name == "model") check_.finish();
  }

  // The attribute requiredextensions is a list of prefixes. The attribute xmlns:PREFIX is the
  // identifier of the extension.
  void check_extensions(const Attributes& a) {
    const char* text = a.find("requiredextensions");
    std::string_view left(text ? text : "");
    for (std::string_view word = take_word(left); !word.empty() && !failed();
         word = take_word(left)) {
      const char* named = a.find_exactly("xmlns:" + std::string(word));
      if (!named || !is_readable(named))
        fail("needs the extension " + in_quotes(word) + " (" +
             std::string(named ? named : "without a name").substr(0, 100) +
             "), which Kibori does not read; export it as plain triangles");
    }
  }
  void take_unit(const Attributes& a) {
    const char* unit = a.find("unit");
    if (!unit) return;
    for (const auto& [known, mm] : {std::pair{"micron", 0.001},
                                    {"millimeter", 1.0},
                                    {"centimeter", 10.0},
                                    {"inch", 25.4},
                                    {"foot", 304.8},
                                    {"meter", 1000.0}})
      if (std::string_view(unit) == known) {
        unit_mm = mm;
        return;
      }
    fail("unknown unit '" + std::string(unit).substr(0, 30) + "'");
  }

  void take_component(const Attributes& a, std::vector<Component>& to) {
    const char *object = a.find("objectid"), *path = a.find("path");
    if (!object) return fail("a component or item refers to no object");
    if (++items_ > kMaxItems) return fail("too many components");
    Component component{path ? without_slash(path) : entry(), object, {}};
    if (const char* text = a.find("transform")) {
      std::string_view left(text);
      double m[12];
      for (double& value : m) {
        left = trimmed(left);
        const size_t end = std::min(left.find_first_of(" \t\n\r"), left.size());
        const std::optional<double> one = number_of<double>(left.substr(0, end));
        if (!one || !std::isfinite(*one)) return fail("a transform must be twelve numbers");
        value = *one;
        left.remove_prefix(end);
      }
      if (!trimmed(left).empty()) return fail("a transform must be twelve numbers");
      // 3MF multiplies row vectors by the matrix, so the matrix is transposed here.
      for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
          component.placement.linear(column, row) = m[3 * row + column];
      component.placement.shift = Vec3(m[9], m[10], m[11]);
    }
    to.push_back(std::move(component));
  }

  std::map<ObjectKey, Object>& objects_;
  size_t &total_, &items_;  // sums over all model files
  const Note& note_;
  ThreeMfCheck check_;
  Object* object_ = nullptr;
};

class Assembly {
 public:
  Assembly(const ZipReader& zip, const std::string& name, std::vector<std::string>* notes)
      : zip_(zip), name_(name), note_([this, notes](const std::string& what) {
          if (notes && noted_.insert(what).second)
            notes->push_back(sanitize_message(name_ + ": " + what));
        }) {}

  Result<TriangleMesh> run() {
    std::string path = kModelPath;
    if (zip_.has("_rels/.rels")) {
      RelationshipReader relations(zip_, "_rels/.rels");
      if (const Status read = relations.run(); !read) return wrong(read.error());
      for (const std::string& note : relations.notes) note_(note);
      if (relations.target.empty())
        note_(in_quotes(path) + " is read, although no part is marked as the model");
      if (!relations.target.empty()) path = without_slash(relations.target);
    }
    if (const Status read = load(path); !read) return wrong(read.error());
    main_ = path;
    check_relationships(path);
    for (const char* config : {"Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"})
      if (zip_.has(config)) {
        SlicerReader reader(zip_, config, slicer_, note_);
        if (const Status read = reader.run(); !read) note_(read.error());
      }
    for (auto& [object, ranges] : slicer_.ranges)
      std::ranges::sort(ranges, {}, &SlicerParts::Range::first);
    for (const Component& item : std::exchange(build_, {}))
      if (const Status added = add(item, {}, 0); !added) return wrong(added.error());
    return std::move(mesh_);
  }

 private:
  Error wrong(const std::string& what) const {
    return Error{sanitize_message(name_ + ": " + what)};
  }

  // Reports violations of the specification in the model's list of related files. These files are
  // not read.
  void check_relationships(const std::string& model) {
    const size_t folder = model.rfind('/') + 1;  // npos + 1 is 0
    const std::string entry = model.substr(0, folder) + "_rels/" + model.substr(folder) + ".rels";
    if (!zip_.has(entry)) return;
    RelationshipReader relations(zip_, entry);
    if (const Status read = relations.run(); !read) note_(read.error());
    for (const std::string& note : relations.notes) note_(note);
  }

  Status load(const std::string& path) {
    if (units_.contains(path)) return Ok{};
    if (units_.size() >= kMaxParts) return Error{"has too many parts"};
    ModelReader reader(zip_, path, objects_, total_, items_, note_);
    if (Status read = reader.run(); !read) return read;
    units_[path] = reader.unit_mm;
    if (units_.size() == 1) build_ = reader.build;
    return Ok{};
  }

  Status add(const Component& component, const Placement& outer, int depth) {
    if (depth > kMaxDepth)
      return Error{"has components that contain themselves, or more than 32 levels of them"};
    if (Status read = load(component.path); !read) return read;
    const auto found = objects_.find({component.path, component.object});
    if (found == objects_.end())
      return Error{"refers to an object " + component.object.substr(0, 30) +
                   " that does not exist"};
    const Object& object = found->second;
    if (object.support) return Ok{};
    const Placement at{outer.linear * component.placement.linear,
                       outer.linear * component.placement.shift + outer.shift};
    if (++visits_ > kMaxItems ||
        mesh_.triangles.size() + object.mesh.triangles.size() > kMaxImportTriangles)
      return Error{"has too many objects or triangles to import"};
    const double unit = units_.at(component.path);
    const auto first = static_cast<uint32_t>(mesh_.vertices.size());
    for (const Vec3& p : object.mesh.vertices) {
      mesh_.vertices.push_back(unit * (at.linear * p + at.shift));
      if (!mesh_.vertices.back().allFinite())
        return Error{"places a vertex at an infinite distance"};
    }
    const bool mirrored = at.linear.determinant() < 0;
    const auto ranges =
        component.path == main_ ? slicer_.ranges.find(component.object) : slicer_.ranges.end();
    const std::vector<SlicerParts::Range> none,
        &left_out = ranges == slicer_.ranges.end() ? none : ranges->second;
    size_t range = 0;
    uint64_t end = 0;  // end of the ranges that begin at or before triangle i
    for (size_t i = 0; i < object.mesh.triangles.size(); i++) {
      auto t = object.mesh.triangles[i];
      for (; range < left_out.size() && left_out[range].first <= i; range++)
        end = std::max(end, left_out[range].last + 1);
      if (i < end) continue;
      if (mirrored) std::swap(t[1], t[2]);
      mesh_.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    for (const Component& inner : object.components) {
      if (component.path == main_ && slicer_.components.contains({component.object, inner.object}))
        continue;
      if (Status added = add(inner, at, depth + 1); !added) return added;
    }
    return Ok{};
  }

  const ZipReader& zip_;
  const std::string& name_;
  std::map<ObjectKey, Object> objects_;
  std::map<std::string, double> units_;  // the unit of each model file that was read [mm]
  std::vector<Component> build_;
  std::string main_;  // path of the model file with the build section
  SlicerParts slicer_;
  std::set<std::string> noted_;
  const Note note_;
  size_t total_ = 0, items_ = 0, visits_ = 0;
  TriangleMesh mesh_;
};

}  // namespace

std::unique_ptr<SurfaceWriter> threemf_writer(NewFile& file, Spool& vertices, Spool& triangles,
                                              std::span<const Rgb> colors) {
  return std::make_unique<ThreeMfWriter>(file, vertices, triangles, colors);
}

Result<TriangleMesh> parse_3mf(std::span<const char> bytes, const std::string& name,
                               std::vector<std::string>* notes) {
  const Result<ZipReader> zip = ZipReader::open(bytes);
  if (!zip) return Error{sanitize_message(name + ": " + zip.error())};
  return Assembly(zip.value(), name, notes).run();
}

}  // namespace kibori
