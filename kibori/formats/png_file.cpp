// SPDX-License-Identifier: MIT
#include <kibori/formats/png_file.h>

#include <csetjmp>
#include <cstring>
#include <string>

#include <png.h>

#include <kibori/base/file.h>

namespace kibori {
namespace {

// libpng reports errors by longjmp. Therefore, no object with a destructor may be created after
// setjmp.
struct Writer {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};

Status write_png(const std::filesystem::path& path, int width, int height, int depth, int color,
                 const void* pixels, size_t row_bytes) {
  NewFile file(path);
  Writer writer;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  if (writer.png) writer.info = png_create_info_struct(writer.png);
  if (!writer.info) return Error{path.string() + ": not enough memory to write it"};
  if (setjmp(png_jmpbuf(writer.png)))
    return Error{path.string() + ": can't be written; check that the disk has space"};
  png_set_write_fn(
      writer.png, &file,
      [](png_structp png, png_bytep data, png_size_t bytes) {
        static_cast<NewFile*>(png_get_io_ptr(png))->write(data, bytes);
      },
      [](png_structp) {});
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(width),
               static_cast<png_uint_32>(height), depth, color, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  if (depth == 16) png_set_swap(writer.png);  // PNG is big-endian
  const auto* row = static_cast<const unsigned char*>(pixels);
  for (int y = 0; y < height; y++, row += row_bytes) png_write_row(writer.png, row);
  png_write_end(writer.png, writer.info);
  return file.commit();
}

struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const char> left;
  char reason[120] = "";
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

}  // namespace

Status write_png_rgb(const std::filesystem::path& path, int width, int height,
                     std::span<const std::array<uint8_t, 3>> pixels) {
  return write_png(path, width, height, 8, PNG_COLOR_TYPE_RGB, pixels.data(),
                   static_cast<size_t>(width) * 3);
}
Result<std::vector<uint8_t>> png_rgb(int width, int height,
                                     std::span<const std::array<uint8_t, 3>> pixels) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<uint8_t> bytes(size);
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr))
    return Error{std::string("cannot create a PNG picture: ") +
                 static_cast<const char*>(image.message)};
  bytes.resize(size);
  return bytes;
}
Status write_png_grey8(const std::filesystem::path& path, int width, int height,
                       std::span<const uint8_t> pixels) {
  return write_png(path, width, height, 8, PNG_COLOR_TYPE_GRAY, pixels.data(),
                   static_cast<size_t>(width));
}
Status write_png_grey16(const std::filesystem::path& path, int width, int height,
                        std::span<const uint16_t> pixels) {
  return write_png(path, width, height, 16, PNG_COLOR_TYPE_GRAY, pixels.data(),
                   static_cast<size_t>(width) * 2);
}

Result<GreyMap> parse_png_grey(std::span<const char> bytes, const std::string& name, int max_side) {
  Reader reader;
  reader.left = bytes;
  GreyMap map;
  std::vector<png_bytep> rows;
  reader.png = png_create_read_struct(
      PNG_LIBPNG_VER_STRING, &reader,
      [](png_structp png, png_const_charp message) {
        auto* self = static_cast<Reader*>(png_get_error_ptr(png));
        std::strncpy(self->reason, message, sizeof self->reason - 1);
        png_longjmp(png, 1);
      },
      [](png_structp, png_const_charp) {});
  if (reader.png) reader.info = png_create_info_struct(reader.png);
  if (!reader.info) return Error{name + ": not enough memory to read it"};
  if (setjmp(png_jmpbuf(reader.png)))
    return Error{name + ": is not a valid PNG picture: " + static_cast<const char*>(reader.reason)};
  png_set_user_limits(reader.png, kMaxPngSide, kMaxPngSide);
  png_set_chunk_malloc_max(reader.png, 1 << 24);
  // Pixels are heights, not brightness on a screen. The four chunks below describe a colour space.
  // If libpng read them, it would use that colour space to convert colours to grey and to blend
  // transparent pixels.
  constexpr png_byte kColorSpaces[] = "gAMA\0sRGB\0cHRM\0iCCP";
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, kColorSpaces, 4);
  png_set_read_fn(reader.png, &reader, [](png_structp png, png_bytep to, png_size_t count) {
    auto* self = static_cast<Reader*>(png_get_io_ptr(png));
    if (self->left.size() < count) png_error(png, "it is cut short");
    std::memcpy(to, self->left.data(), count);
    self->left = self->left.subspan(count);
  });
  png_read_info(reader.png, reader.info);
  map.width = static_cast<int>(png_get_image_width(reader.png, reader.info));
  map.height = static_cast<int>(png_get_image_height(reader.png, reader.info));
  if (map.width > max_side || map.height > max_side) {
    const std::string side = std::to_string(max_side);
    return Error{name + ": has " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                 " pixels, but at most " + side + " x " + side +
                 " are possible here; scale it down"};
  }
  const int color = png_get_color_type(reader.png, reader.info);
  if (color == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reader.png);
  png_set_expand_16(reader.png);
  if (png_get_valid(reader.png, reader.info, PNG_INFO_tRNS)) png_set_tRNS_to_alpha(reader.png);
  if (color == PNG_COLOR_TYPE_PALETTE || (color & PNG_COLOR_MASK_COLOR))
    png_set_rgb_to_gray(reader.png, 1, -1, -1);
  png_color_16 black = {};
  png_set_background(reader.png, &black, PNG_BACKGROUND_GAMMA_SCREEN, 0, 1);
  png_set_strip_alpha(reader.png);
  png_set_swap(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  if (png_get_rowbytes(reader.png, reader.info) != static_cast<size_t>(map.width) * 2)
    return Error{name +
                 ": this kind of PNG picture can't be read as grey; save it as 8 or 16 bit grey"};
  map.pixels.resize(static_cast<size_t>(map.width) * static_cast<size_t>(map.height));
  for (size_t y = 0; y < static_cast<size_t>(map.height); y++)
    rows.push_back(
        reinterpret_cast<png_bytep>(map.pixels.data() + y * static_cast<size_t>(map.width)));
  png_read_image(reader.png, rows.data());
  png_read_end(reader.png, nullptr);
  return map;
}

Result<GreyMap> read_png_grey(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path);
  if (!bytes) return Error{bytes.error()};
  return parse_png_grey(bytes.value(), path.string());
}

}  // namespace kibori
