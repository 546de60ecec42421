#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstring>

#include "image_formats.h"

namespace kinome {
namespace {

/// Input of libpng, and its last error.
struct Source {
  const std::string& bytes;
  size_t at = 0;
  char error[128] = "";
};

[[noreturn]] void fail(png_structp png, png_const_charp message) {
  auto& source = *static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source.error, message, sizeof source.error - 1);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp /*png*/, png_const_charp /*message*/) {}

void read_bytes(png_structp png, png_bytep out, size_t count) {
  auto& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.bytes.size() - source.at) png_error(png, kTruncated);
  std::memcpy(out, source.bytes.data() + source.at, count);
  source.at += count;
}

/// Structures of libpng. Its errors jump out of `call`, which therefore must not have local objects
/// with destructors.
class Png {
 public:
  explicit Png(const std::string& bytes)
      : source_{bytes},
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, fail, ignore_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (!info_) throw std::bad_alloc();
    png_set_read_fn(png_, &source_, read_bytes);
  }
  ~Png() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;

  template <class Call>
  void run(const Call& call) {
    if (!try_to(call)) {
      const std::string error = source_.error;
      throw std::runtime_error(error == kTruncated ? error : "libpng: " + error);
    }
  }

 private:
  template <class Call>
  bool try_to(const Call& call) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    call(png_, info_);
    return true;
  }

  Source source_;
  png_structp png_;
  png_infop info_;
};

struct Header {
  png_uint_32 width = 0, height = 0;
  int depth = 0, type = 0;
  bool has_alpha = false;
  size_t row_bytes = 0;  ///< as stored
};

}  // namespace

void read_png(const std::string& bytes, StoredImage& image) {
  Png png(bytes);
  Header header;
  png.run([&header](png_structp p, png_infop info) {
    png_read_info(p, info);
    png_get_IHDR(p, info, &header.width, &header.height, &header.depth, &header.type, nullptr,
                 nullptr, nullptr);
    header.row_bytes = png_get_rowbytes(p, info);
    header.has_alpha =
        (header.type & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(p, info, PNG_INFO_tRNS) != 0;
    // Converts all kinds to grey or RGB with 8 or 16 bits. Gamma and colour profiles are ignored.
    if (header.type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(p);
    if (header.type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(p);
    png_set_strip_alpha(p);
    if (std::endian::native == std::endian::little) png_set_swap(p);
    png_set_interlace_handling(p);
    png_read_update_info(p, info);
  });
  constexpr uint64_t kBestRatio = 1032;  // compression ratio of deflate
  set_size(image, header.width, header.height, uint64_t{header.row_bytes} * header.height,
           kBestRatio, bytes.size());
  image.channels = (header.type & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1;
  image.is_encoded = true;
  if (header.has_alpha) image.unused.emplace_back("channel A");

  const bool is_wide = header.depth == 16;
  const size_t row_values = size_t{header.width} * static_cast<size_t>(image.channels);
  const size_t row_bytes = row_values * (is_wide ? 2 : 1);
  std::vector<uint8_t> pixels(row_bytes * header.height);
  std::vector<png_bytep> rows;
  for (size_t y = 0; y < header.height; ++y) rows.push_back(&pixels[y * row_bytes]);
  png.run([&](png_structp p, png_infop info) {
    if (png_get_rowbytes(p, info) != row_bytes) png_error(p, "rows of an unexpected length");
    png_read_image(p, rows.data());
    png_read_end(p, nullptr);
  });
  if (!is_wide) {
    image.bytes = std::move(pixels);
    return;
  }
  image.floats.reserve(pixels.size() / 2);
  for (size_t i = 0; i < pixels.size(); i += 2) {
    uint16_t value = 0;
    std::memcpy(&value, &pixels[i], sizeof value);
    image.floats.push_back(static_cast<float>(value) / 65535.f);
  }
}

}  // namespace kinome
