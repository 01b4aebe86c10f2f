// SPDX-License-Identifier: MIT
// Writes the library's lists into files of other languages:
//   web/src/connection/kinds.ts  tools, modes and force models, for pages; the whole file
//   python/kibori/__init__.pyi   modes and the classes of tool shapes, for type checkers; only the
//                                lines between marks
//   docs/scenes.md               the tables of tool shapes and presets, for people; only the lines
//                                between marks
//
// Usage: make_kinds FILE... writes them (./dev kinds). make_kinds --check FILE... writes nothing,
// and exits with 1 if a FILE is out of date.
#include <cctype>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include <kibori/base/tolerances.h>
#include <kibori/report/force_report.h>
#include <kibori/scene/tool_presets.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/reshape/brush.h>
#include <kibori/solid/tool.h>
#include "apps/studio/imports.h"

namespace {

std::string tool_types() {
  std::string text;
  for (const char* shape : kibori::kToolShapes) {
    text += "  | { shape: \"" + std::string(shape) + "\"";
    kibori::for_tool_numbers(*kibori::default_tool(shape),
                             [&](const char* name, const auto& number) {
                               constexpr bool one = std::is_same_v<decltype(number), const double&>;
                               text += "; " + std::string(name) + (one ? ": number" : ": Vec3");
                             });
    text += " }\n";
  }
  text.back() = ';';
  return text;
}

// The names of a tool's numbers.
std::string numbers_of(const kibori::Tool& tool, const std::string& quote) {
  std::string text;
  kibori::for_tool_numbers(tool, [&](const char* name, const auto&) {
    text += (text.empty() ? "" : ", ") + quote + name + quote;
  });
  return text;
}

std::string tool_table() {
  std::string text = "| `shape` | numbers | what it is |\n|---|---|---|\n";
  for (const char* shape : kibori::kToolShapes) {
    const kibori::Tool tool = *kibori::default_tool(shape);
    text += "| `\"" + std::string(shape) + "\"` | " + numbers_of(tool, "`") + " | " +
            kibori::shape_note(tool) + " |\n";
  }
  return text;
}

std::string tool_stubs() {
  std::string text, all;
  for (const char* shape : kibori::kToolShapes) {
    std::string name = shape;  // "ball" becomes Ball
    name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    all += "    " + name + ",\n";
    const kibori::Tool tool = *kibori::default_tool(shape);
    if (std::holds_alternative<kibori::MeshTool>(tool)) continue;  // a mesh has no numbers
    std::string fields;
    kibori::for_tool_numbers(tool, [&](const char* number_name, const auto& number) {
      constexpr bool one = std::is_same_v<decltype(number), const double&>;
      fields += "    " + std::string(number_name) + (one ? ": float\n" : ": Vector\n");
    });
    text += "class " + name + "(_Numbers):" + (fields.empty() ? " ...\n" : "\n" + fields) + "\n";
  }
  return text + "Shape = Union[\n" + all + "]\n";
}

std::string preset_table() {
  std::string text = "| `preset` | for | tool |\n|---|---|---|\n";
  for (const kibori::ToolPreset& preset : kibori::tool_presets()) {
    std::string numbers;
    kibori::for_tool_numbers(preset.tool, [&](const char* name, const auto& number) {
      if constexpr (std::is_same_v<decltype(number), const double&>) {
        char value[64];
        std::snprintf(value, sizeof value, ", `%s` %g", name, number);
        numbers += value;
      }
    });
    text += "| `\"" + std::string(preset.name) + "\"` | " + std::string(preset.use) + " | `\"" +
            kibori::shape_of(preset.tool) + "\"`" + numbers + " |\n";
  }
  return text;
}

// The names of all modes, as a type of Python.
std::string mode_stub() {
  constexpr size_t kMaxLine = 100;
  std::string text = "ModeName = Literal[\n", line = "   ";
  for (const std::string_view name : names_of(kibori::Mode{})) {
    const std::string item = " \"" + std::string(name) + "\",";
    if (line.size() + item.size() > kMaxLine) {
      text += line + "\n";
      line = "   ";
    }
    line += item;
  }
  return text + line + "\n]\n";
}

// Returns `text` with `part` in place of the lines between its two marks. `what` names the list in
// the marks, for example "tool shapes". Nothing if the text has no marks.
std::optional<std::string> with_part(const std::string& text, const std::string& part,
                                     std::string what) {
  const size_t end = text.find("End of the " + what + ".");
  what[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(what[0])));
  const size_t mark = text.find(what + ", made by apps/studio/make_kinds.cpp");
  if (mark == std::string::npos || end == std::string::npos || end < mark) return std::nullopt;
  const size_t from = text.find('\n', mark) + 1, to = text.rfind('\n', end) + 1;
  return text.substr(0, from) + part + text.substr(to);
}

template <kibori::Named Enum>
std::string list() {
  std::string text;
  for (const std::string_view name : names_of(Enum{}))
    text += (text.empty() ? "\"" : ", \"") + std::string(name) + "\"";
  return "[" + text + "] as const";
}

std::string kinds() {
  std::string models;
  for (const std::string_view name : names_of(kibori::ForceModel{}))
    models += "  " + std::string(name) + ":\n    \"" +
              kibori::model_note(*kibori::value_of<kibori::ForceModel>(name)) + "\",\n";
  return "// SPDX-License-Identifier: MIT\n"
         "// Made by apps/studio/make_kinds.cpp from the library's own lists: change those.\n"
         "import type { Vec3 } from \"../base/vec3\";\n\n"
         "/** A tool: its shape and its numbers [mm, degrees]; kibori/solid/tools/ says what "
         "they are. */\n"
         "export type Tool =\n" +
         tool_types() +
         "\n\n/** What a tool does (kibori/motion/mode.h). */\n"
         "export const MODES = " +
         list<kibori::Mode>() +
         ";\nexport type Mode = (typeof MODES)[number];\n\n"
         "/** How motion becomes force (kibori/haptics/force.h). */\n"
         "export const MODELS = " +
         list<kibori::ForceModel>() +
         ";\nexport type Model = (typeof MODELS)[number];\n\n"
         "/** The textures of brushes (kibori/reshape/alpha.h). */\n"
         "export const ALPHAS = " +
         list<kibori::Alpha>() +
         ";\nexport type Alpha = (typeof ALPHAS)[number];\n\n"
         "/** What the mode mask does (kibori/reshape/brush.h). */\n"
         "export const MASK_VERBS = " +
         list<kibori::MaskVerb>() +
         ";\nexport type MaskVerb = (typeof MASK_VERBS)[number];\n\n"
         "/** What the pressure of a pen changes (kibori/reshape/brush.h). */\n"
         "export const PRESSURE_USES = " +
         list<kibori::PressureUse>() +
         ";\nexport type PressureUse = (typeof PRESSURE_USES)[number];\n\n"
         "/** One sentence for each force model. */\n"
         "export const MODEL_NOTES: Record<Model, string> = {\n" +
         models +
         "};\n\n/** The endings of files that can become bodies, for <input accept>, and of all "
         "files that can be "
         "imported. */\nexport const MESHES = \"" +
         kibori::list_of(kibori::kMeshesRead, ", ") + "\";\nexport const IMPORTS = `${MESHES}, " +
         kibori::list_of(kibori::studio::kOtherImports, ", ") + ", " +
         kibori::list_of(kibori::kProgramsRead, ", ") +
         "`;\n\n/** The maximum number of materials in a document. */\nexport const MAX_MATERIALS "
         "= " +
         std::to_string(kibori::kMaxMaterials) + ";\n";
}

// The new content of a file that contains `text`. Nothing if its marks are missing.
std::optional<std::string> made(std::string_view path, const std::string& text) {
  if (path.ends_with(".pyi")) {
    const std::optional<std::string> with_modes = with_part(text, mode_stub(), "modes");
    return with_modes ? with_part(*with_modes, tool_stubs(), "tool shapes") : std::nullopt;
  }
  if (path.ends_with(".md")) {
    const std::optional<std::string> with_shapes = with_part(text, tool_table(), "tool shapes");
    return with_shapes ? with_part(*with_shapes, preset_table(), "tool presets") : std::nullopt;
  }
  return kinds();
}

}  // namespace

int main(int count, char** arguments) {
  const bool check = count > 1 && std::string_view(arguments[1]) == "--check";
  const int first = check ? 2 : 1;
  if (count <= first) {
    std::fprintf(stderr, "usage: make_kinds [--check] FILE...\n");
    return 2;
  }
  int failed = 0;
  for (int i = first; i < count; i++) {
    const char* const path = arguments[i];
    std::ifstream in(path, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    const std::optional<std::string> wanted = made(path, text);
    if (text == wanted) continue;
    if (check || !wanted) {
      std::fprintf(stderr,
                   wanted ? "%s differs from the library's lists; run ./dev kinds\n"
                          : "%s has no marks around its lists\n",
                   path);
      failed = 1;
      continue;
    }
    std::ofstream out(path, std::ios::binary);
    out << *wanted;
    out.close();
    if (!out) {
      std::fprintf(stderr, "can't write %s\n", path);
      failed = 1;
    }
  }
  return failed;
}
