// SPDX-License-Identifier: MIT
// Writes web/src/connection/kinds.ts: what pages must know of tools, modes and force models, from
// the library's own lists.
//
// Usage: make_kinds FILE writes it; make_kinds --check FILE writes nothing, and exits 1 where FILE
// is not what would be written.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>

#include <kibori/base/tolerances.h>
#include <kibori/report/force_report.h>
#include <kibori/formats/endings.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/solid/tool.h>
#include "apps/studio/imports.h"

namespace {

std::string tools() {
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
  text.insert(text.size() - 1, ";");
  return text;
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
         "/** A tool: its shape and its numbers [mm, degrees]; kibori/solid/tool.h says what they "
         "are. */\n"
         "export type Tool =\n" +
         tools() +
         "\n/** What a tool does (kibori/motion/tool_tick.h). */\n"
         "export const MODES = " +
         list<kibori::Mode>() +
         ";\nexport type Mode = (typeof MODES)[number];\n\n"
         "/** How motion becomes force (kibori/haptics/force.h). */\n"
         "export const MODELS = " +
         list<kibori::ForceModel>() +
         ";\nexport type Model = (typeof MODELS)[number];\n\n"
         "/** A sentence on each. */\n"
         "export const MODEL_NOTES: Record<Model, string> = {\n" +
         models +
         "};\n\n/** The files that can be brought, as <input accept> has them: those that become "
         "bodies, and "
         "all. */\nexport const MESHES = \"" +
         kibori::list_of(kibori::kMeshesRead, ", ") + "\";\nexport const IMPORTS = `${MESHES}, " +
         kibori::list_of(kibori::studio::kOtherImports, ", ") +
         "`;\n\n/** Materials of one document, at most. */\nexport const MAX_MATERIALS = " +
         std::to_string(kibori::kMaxMaterials) + ";\n";
}

}  // namespace

int main(int count, char** arguments) {
  const bool check = count == 3 && std::string_view(arguments[1]) == "--check";
  if (!check && count != 2) {
    std::fprintf(stderr, "usage: make_kinds [--check] FILE\n");
    return 2;
  }
  const char* const path = arguments[count - 1];
  const std::string text = kinds();
  if (check) {
    std::ifstream file(path, std::ios::binary);
    if (std::string(std::istreambuf_iterator<char>(file), {}) == text) return 0;
    std::fprintf(stderr, "%s is not what the library's lists say; run make_kinds %s\n", path, path);
    return 1;
  }
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "can't write %s\n", path);
  return 1;
}
