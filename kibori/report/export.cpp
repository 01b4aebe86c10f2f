// SPDX-License-Identifier: MIT
#include <kibori/report/export.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <string>

#include <kibori/base/file.h>
#include <kibori/base/parallel.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/zip.h>

namespace kibori {
namespace {

constexpr size_t kMaxStale = 10000;  // exceeds the maximum number of layers of a lattice

std::string layer_name(size_t number, const char* ending) {
  char name[40];
  std::snprintf(name, sizeof name, "layer-%04zu.%s", number, ending);
  return name;
}

Status write_svg(const std::filesystem::path& path, const Lattice& lattice, const Layer& layer) {
  const Box box = lattice.to_mm(lattice.whole());
  const Index3 nodes = lattice.high() - lattice.low();
  const double width = nodes.x() * lattice.pitch_mm, height = nodes.y() * lattice.pitch_mm;
  NewFile file(path);
  char text[400];
  const auto put = [&](int length) { file.write(text, static_cast<size_t>(length)); };
  put(std::snprintf(text, sizeof text,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.6gmm\" height=\"%.6gmm\" "
                    "viewBox=\"0 0 %.6g "
                    "%.6g\">\n<desc>Kibori layer at z = %.6g mm; lower left corner at x = %.6g, y "
                    "= %.6g mm</desc>\n"
                    "<path fill=\"black\" fill-rule=\"evenodd\" d=\"",
                    width, height, width, height, layer.z_mm, box.min.x(), box.min.y()));
  for (const auto& outline : layer.outlines) {
    char move = 'M';
    for (const auto& p : outline) {
      put(std::snprintf(text, sizeof text, "%c%.9g %.9g", move, p[0] - box.min.x(),
                        box.min.y() + height - p[1]));
      move = 'L';
    }
    file.write("Z\n");
  }
  file.write("\"/>\n</svg>\n");
  return file.commit();
}

}  // namespace

Result<HeightMapSummary> write_height_map(const std::filesystem::path& path,
                                          const Snapshot& model) {
  const HeightMap map = height_map(model);
  if (map.low_mm > map.high_mm || *std::max_element(map.pixels.begin(), map.pixels.end()) == 0)
    return Error{path.string() + ": there is no material to map"};
  if (const Status written = write_png_grey16(path, map.width, map.height, map.pixels); !written)
    return Error{written.error()};
  return HeightMapSummary{map.width, map.height, map.low_mm, map.high_mm};
}

Result<int> write_layers(const std::filesystem::path& folder, const Snapshot& model,
                         const LayerOptions& options) {
  const std::vector<int> layers = layers_of(model, options.layer_mm);
  if (layers.empty()) return Error{folder.string() + ": there is no material to slice"};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    return Error{folder.string() + ": the folder cannot be created: " + error.message()};
  const Index3 nodes = model.lattice.high() - model.lattice.low();
  std::mutex guard;
  size_t done = 0;
  Status wrong = Ok{};
  run_parallel(options.threads, layers.size(), [&](size_t i) {
    const bool svg = options.format == LayerFormat::svg;
    const std::string name = layer_name(i + 1, svg ? "svg" : "png");
    const Status written =
        svg ? write_svg(folder / name, model.lattice, slice_layer(model, layers[i]))
            : write_png_grey8(folder / name, nodes.x(), nodes.y(), mask_layer(model, layers[i]));
    const std::lock_guard lock(guard);
    if (!written && wrong) wrong = written;
    if (options.progress)
      options.progress(static_cast<double>(++done) / static_cast<double>(layers.size()));
  });
  if (!wrong) return Error{wrong.error()};
  // Removes the layers of an earlier stack that had more layers or another format.
  for (size_t i = 1; i <= kMaxStale; i++)
    for (const char* ending : {"svg", "png"}) {
      const bool ours =
          i <= layers.size() && (ending[0] == 's') == (options.format == LayerFormat::svg);
      if (!ours) std::filesystem::remove(folder / layer_name(i, ending), error);
    }
  return static_cast<int>(layers.size());
}

Status write_layers_zip(const std::filesystem::path& path, const Snapshot& model,
                        const LayerOptions& options) {
  const auto made = TemporaryFolder::make();
  if (!made) return Error{made.error()};
  const std::filesystem::path& folder = made.value()->path();
  const Result<int> written = write_layers(folder, model, options);
  if (!written) return Error{written.error()};
  NewFile file(path);
  ZipWriter zip(file);
  for (int i = 1; i <= written.value(); i++) {
    const std::string name =
        layer_name(static_cast<size_t>(i), options.format == LayerFormat::svg ? "svg" : "png");
    const Result<std::vector<char>> layer = read_file(folder / name);
    if (!layer) return Error{layer.error()};
    zip.begin(name);
    zip.write({layer.value().data(), layer.value().size()});
    zip.end();
  }
  if (Status whole = zip.finish(); !whole) return whole;
  return file.commit();
}

}  // namespace kibori
