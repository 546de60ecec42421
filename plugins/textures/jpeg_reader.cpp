#include <csetjmp>
#include <cstdio>

// These need size_t and FILE.
#include <jerror.h>
#include <jpeglib.h>

#include "image_formats.h"

namespace kinome {
namespace {

struct ErrorManager {
  jpeg_error_mgr base;  // first member, because libjpeg has pointers to it
  jmp_buf return_point;
  bool is_baseline_scan = false;  ///< the header was read, and all scans have whole coefficients
  bool is_truncated = false;
  char message[JMSG_LENGTH_MAX] = "";
};

[[noreturn]] void fail(j_common_ptr jpeg) {
  auto* const errors = reinterpret_cast<ErrorManager*>(jpeg->err);
  errors->base.format_message(jpeg, errors->message);
  std::longjmp(errors->return_point, 1);
}

/// Treats the end of the data as an error, because libjpeg would invent the missing data. Files
/// that only lack the end marker are accepted: their scans are complete.
void handle_message(j_common_ptr jpeg, int level) {
  auto* const errors = reinterpret_cast<ErrorManager*>(jpeg->err);
  const int code = errors->base.msg_code;
  if (level >= 0 || (code != JWRN_JPEG_EOF && !errors->is_truncated)) return;
  errors->is_truncated = true;
  if (!errors->is_baseline_scan || code == JWRN_HIT_MARKER) fail(jpeg);
}

/// State of libjpeg. Its errors jump out of `call`, which therefore must not have local objects
/// with destructors.
class Jpeg {
 public:
  Jpeg() {
    state_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = fail;
    errors_.base.emit_message = handle_message;
    run([](jpeg_decompress_struct& jpeg) { jpeg_create_decompress(&jpeg); });
  }
  ~Jpeg() { jpeg_destroy_decompress(&state_); }
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;

  template <class Call>
  void run(const Call& call) {
    if (try_to(call)) return;
    throw std::runtime_error(errors_.is_truncated ? kTruncated
                                                  : std::string("libjpeg: ") + errors_.message);
  }
  const jpeg_decompress_struct& state() const { return state_; }
  void begin_scans() { errors_.is_baseline_scan = state_.progressive_mode == FALSE; }

 private:
  template <class Call>
  bool try_to(const Call& call) {
    if (setjmp(errors_.return_point) != 0) return false;
    call(state_);
    return true;
  }

  jpeg_decompress_struct state_{};
  ErrorManager errors_{};
};

/// Converts from Adobe's CMYK, whose values are the fractions of light that each ink lets through.
void convert_from_cmyk(std::vector<uint8_t>& pixels) {
  size_t out = 0;
  for (size_t i = 0; i < pixels.size(); i += 4) {
    for (size_t c = 0; c < 3; ++c) {
      pixels[out++] = static_cast<uint8_t>((pixels[i + c] * pixels[i + 3] + 127) / 255);
    }
  }
  pixels.resize(out);
}

}  // namespace

void read_jpeg(const std::string& bytes, StoredImage& image) {
  Jpeg jpeg;
  jpeg.run([&bytes](jpeg_decompress_struct& j) {
    jpeg_mem_src(&j, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&j, TRUE);
    jpeg_calc_output_dimensions(&j);
  });
  const auto channels = static_cast<size_t>(jpeg.state().output_components);
  const size_t row = size_t{jpeg.state().output_width} * channels;
  // A single colour needs one bit per 8x8 block of a channel, or less in a progressive file.
  constexpr uint64_t kBestRatio = 2000;
  set_size(image, jpeg.state().output_width, jpeg.state().output_height,
           uint64_t{row} * jpeg.state().output_height, kBestRatio, bytes.size());
  if (channels != 1 && channels != 3 && channels != 4) {
    throw std::runtime_error("it has " + std::to_string(channels) +
                             " channels, expected 1, 3 or 4");
  }
  image.channels = channels == 1 ? 1 : 3;
  image.is_encoded = true;
  image.bytes.resize(row * static_cast<size_t>(image.height));
  jpeg.begin_scans();
  jpeg.run([&](jpeg_decompress_struct& j) {
    jpeg_start_decompress(&j);
    while (j.output_scanline < j.output_height) {
      JSAMPROW line = &image.bytes[j.output_scanline * row];
      jpeg_read_scanlines(&j, &line, 1);
    }
    jpeg_finish_decompress(&j);
  });
  if (channels == 4) convert_from_cmyk(image.bytes);
}

}  // namespace kinome
