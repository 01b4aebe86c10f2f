// SPDX-License-Identifier: MIT
// Reads mutated mesh files with the helper program. read_mesh must return a valid mesh or an error
// of one sentence, within 20 s. Anything else and a crash of the helper are findings. Each finding
// is stored in the current folder. KIBORI_SEED sets the seed.
//
//   fuzz_foreign SECONDS CORPUS_FOLDER     (has a folder for each format: obj, ply, ...)
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

#include <kibori/base/file.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/mesh_format.h>

using namespace kibori;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

class Mutator {
 public:
  explicit Mutator(unsigned seed) : engine_(seed) {}
  size_t below(size_t count) {
    return std::uniform_int_distribution<size_t>(0, count - 1)(engine_);
  }
  std::string operator()(std::string bytes) {
    static const std::vector<std::string> words = {"-1",
                                                   "4294967295",
                                                   "1e999",
                                                   "nan",
                                                   "0",
                                                   "\xff\xff\xff\xff",
                                                   std::string(4, '\0'),
                                                   "99999999999",
                                                   "\n",
                                                   "//",
                                                   "f 1 2 3\n"};
    for (size_t times = 1 + below(6); times > 0 && !bytes.empty(); times--) {
      const size_t at = below(bytes.size());
      switch (below(6)) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
          break;
        case 1:
          bytes[at] = static_cast<char>(below(256));
          break;
        case 2:
          bytes.erase(at, 1 + below(20));
          break;
        case 3:
          bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(60)));
          break;
        case 4: {
          const std::string& word = words[below(words.size())];
          bytes.replace(at, std::min(word.size(), bytes.size() - at), word);
          break;
        }
        default:
          if (below(4) == 0) bytes.resize(at);
      }
    }
    return bytes;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: fuzz_foreign SECONDS CORPUS_FOLDER\n"), 2;
  const double seconds = std::atof(argv[1]);
  const char* given = std::getenv("KIBORI_SEED");
  const unsigned seed =
      given ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : std::random_device{}();
  std::printf("seed %u\n", seed);
  Mutator mutate(seed);
  const auto folder =
      std::filesystem::temp_directory_path() / ("kibori-fuzz-" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  std::vector<std::pair<std::string, std::string>> corpus;  // ending, bytes
  for (const MeshFormat& format : kMeshFormats) {
    if (format.ending == ".stl") continue;  // this process reads it, not the helper
    const std::string ending(format.ending.substr(1));
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(argv[2]) / ending)) {
      if (ending_of(entry.path()) == ".bin") {  // a .gltf file names it
        std::filesystem::copy_file(entry.path(), folder / entry.path().filename());
        continue;
      }
      const auto bytes = read_file(entry.path()).value();
      corpus.emplace_back(ending, std::string(bytes.begin(), bytes.end()));
    }
  }
  if (corpus.empty()) return std::fprintf(stderr, "no corpus in %s\n", argv[2]), 2;
  std::map<std::string, int> ends;  // number of files per outcome
  double slowest = 0;
  int findings = 0;
  const auto start = Clock::now();
  while (seconds_since(start) < seconds) {
    const auto& [ending, bytes] = corpus[mutate.below(corpus.size())];
    const std::string mutant = mutate(bytes);
    const auto file = folder / ("a." + ending);
    std::ofstream(file, std::ios::binary) << mutant;
    const auto from = Clock::now();
    const Result<TriangleMesh> mesh = read_mesh(file);
    const double took = seconds_since(from);
    slowest = std::max(slowest, took);
    bool good = took < 20;
    if (mesh) {
      for (const Vec3& p : mesh.value().vertices) good &= p.allFinite();
      for (const auto& t : mesh.value().triangles)
        for (const uint32_t v : t) good &= v < mesh.value().vertices.size();
      ends["read"]++;
    } else {
      good &= !mesh.error().empty() && mesh.error().find('\n') == std::string::npos;
      const auto ended_by = [&](const char* what) {
        return mesh.error().find(what) != std::string::npos;
      };
      good &= !ended_by("bug of Kibori");
      ends[ended_by("crashes")                ? "parser crashed"
           : ended_by("too long or too much") ? "parser stopped"
                                              : "refused"]++;
    }
    if (good) continue;
    findings++;
    const auto kept = std::filesystem::current_path() /
                      ("foreign-finding-" + std::to_string(findings) + "." + ending);
    std::ofstream(kept, std::ios::binary) << mutant;
    std::printf("finding: %s (%.1f s): %s\n", kept.c_str(), took,
                mesh ? "unsound mesh" : mesh.error().c_str());
  }
  std::filesystem::remove_all(folder);
  for (const auto& [how, count] : ends) std::printf("%-16s %d\n", how.c_str(), count);
  std::printf("slowest %.2f s, %d findings\n", slowest, findings);
  return findings ? 1 : 0;
}
