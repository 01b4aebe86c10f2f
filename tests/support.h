// SPDX-License-Identifier: MIT
// Shared by the tests: seeded randomness (the seed is printed with every failure), numbers of
// rounds, and folders.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <kibori/geometry/vec.h>

namespace kibori::test {

// KIBORI_SEED in the environment repeats a run.
class Random {
 public:
  Random() : Random(seed_from_environment()) {}
  explicit Random(unsigned seed) : engine_(seed), seed_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  Vec3 in_box(double low, double high) {
    return {uniform(low, high), uniform(low, high), uniform(low, high)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_box(-1, 1);
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }
  unsigned seed() const { return seed_; }
  std::string note() const { return "repeat with KIBORI_SEED=" + std::to_string(seed_); }

 private:
  static unsigned seed_from_environment() {
    const char* text = std::getenv("KIBORI_SEED");
    const unsigned seed =
        text ? static_cast<unsigned>(std::strtoul(text, nullptr, 10)) : std::random_device{}();
    std::printf("seed %u\n", seed);
    return seed;
  }
  std::mt19937 engine_;
  unsigned seed_;
};

// Number of rounds, unless the environment sets it: a campaign runs more, a sanitiser fewer.
inline int rounds_of(const char* name, int otherwise) {
  if (const char* value = std::getenv(name)) return std::atoi(value);
  return std::getenv("KIBORI_SHORT") ? otherwise / 5 : otherwise;
}

// A temporary folder; removed at the end.
struct Folder {
  Folder() {
    char name[] = "/tmp/kibori-test-XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path / name; }
  std::filesystem::path path;
};

}  // namespace kibori::test
