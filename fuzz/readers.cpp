// SPDX-License-Identifier: MIT
// libFuzzer on a reader of our own, chosen when compiling by KIBORI_FUZZ_<READER>. Anything but an answer or
// a sentence is a finding.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/threemf.h>
#include <kibori/motion/scene.h>

using namespace kibori;

namespace {

template <class T>
void one_sentence(const Result<T>& result) {
  if (!result && (result.error().empty() || result.error().find('\n') != std::string::npos)) std::abort();
}

[[maybe_unused]] void sound(const Result<TriangleMesh>& mesh) {
  one_sentence(mesh);
  if (!mesh) return;
  for (const Vec3& p : mesh.value().vertices)
    if (!p.allFinite()) std::abort();
  for (const auto& t : mesh.value().triangles)
    for (const uint32_t v : t)
      if (v >= mesh.value().vertices.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const char> bytes(reinterpret_cast<const char*>(data), size);
#if defined(KIBORI_FUZZ_STL)
  sound(parse_stl(bytes.data(), bytes.size(), "a.stl"));
#elif defined(KIBORI_FUZZ_3MF)
  sound(parse_3mf(bytes, "a.3mf"));
#elif defined(KIBORI_FUZZ_PNG)
  one_sentence(parse_png_grey(bytes, "a.png"));
#elif defined(KIBORI_FUZZ_SCENE)
  one_sentence(parse_scene({bytes.data(), bytes.size()}, "a.toml", "."));
#endif
  return 0;
}
