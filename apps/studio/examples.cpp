// SPDX-License-Identifier: MIT
#include "apps/studio/examples.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "apps/studio/bundle.h"

namespace kibori::studio {
namespace {

// The first sentence of a scene's first comment, or the part before a colon.
std::string first_comment(const std::string& text) {
  std::string about;
  for (size_t at = 0; at < text.size() && text[at] == '#';) {
    const size_t end = std::min(text.find('\n', at), text.size());
    if (!about.empty()) about += ' ';
    about.append(text, std::min(at + 2, end), end - std::min(at + 2, end));
    at = end + 1;
  }
  for (size_t i = 0; i < about.size(); i++) {
    const bool sentence =
        about[i] == '.' &&
        (i + 2 >= about.size() || std::isupper(static_cast<unsigned char>(about[i + 2])));
    if (sentence || about[i] == ':') return about.substr(0, i);
  }
  return about;
}

std::vector<Example> bundled() {
  std::vector<Example> all;
  for (const BundledFile& file : bundle()) {
    const std::filesystem::path path(file.path);
    if (path.parent_path() != "/examples" || path.extension() != ".toml") continue;
    const std::string text(reinterpret_cast<const char*>(file.data), file.size);
    all.push_back({path.stem().string(), first_comment(text), text});
  }
  return all;
}

}  // namespace

const std::vector<Example>& examples() {
  static const std::vector<Example> all = bundled();
  return all;
}

}  // namespace kibori::studio
