#include <array>
#include <cmath>
#include <sstream>

#include "image_formats.h"
#include "kinome/color.h"

/// Reader of Radiance's image format. Sources: Ward's description in "Real Pixels" (Graphics Gems
/// II), and Radiance's ra_rgbe for the run lengths.
namespace kinome {
namespace {

class Source {
 public:
  explicit Source(const std::string& bytes) : bytes_(bytes) {}
  uint8_t next() {
    if (at_ >= bytes_.size()) throw std::runtime_error(kTruncated);
    return static_cast<uint8_t>(bytes_[at_++]);
  }
  std::string line() {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string::npos) throw std::runtime_error("truncated: its header has no end");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    if (text.ends_with('\r')) text.pop_back();
    return text;
  }
  /// True if the next scan line, of `length` pixels, is encoded as runs of each channel.
  bool has_runs_of_channels(size_t length) const {
    return length >= 8 && length < 0x8000 && at_ + 4 <= bytes_.size() && bytes_[at_] == 2 &&
           bytes_[at_ + 1] == 2 && (static_cast<uint8_t>(bytes_[at_ + 2]) & 0x80) == 0;
  }

 private:
  const std::string& bytes_;
  size_t at_ = 0;
};

/// One axis of the header's size line, such as "-Y 512".
struct Axis {
  char sign = 0, name = 0;
  int64_t size = 0;
  /// Returns the column, or the row from the top, of the i-th position along the axis.
  int64_t position(int64_t i) const { return (sign == '+') == (name == 'X') ? i : size - 1 - i; }
};

using Pixel = std::array<uint8_t, 4>;

[[noreturn]] void throw_damaged() {
  throw std::runtime_error("damaged: a scan line has a different length than the image");
}

void read_runs_of_channels(Source& source, std::vector<Pixel>& line) {
  source.next(), source.next();
  const size_t high = source.next(), low = source.next();
  if ((high << 8 | low) != line.size()) throw_damaged();
  for (size_t c = 0; c < 4; ++c) {
    for (size_t x = 0; x < line.size();) {
      const size_t code = source.next();
      const bool is_run = code > 128;
      const size_t count = is_run ? code - 128 : code;
      if (count == 0 || count > line.size() - x) throw_damaged();
      const uint8_t value = is_run ? source.next() : 0;
      for (const size_t end = x + count; x < end; ++x) line[x][c] = is_run ? value : source.next();
    }
  }
}

/// Reads pixels one by one. (1, 1, 1, n) repeats the previous pixel n times. Consecutive ones are
/// digits of n in base 256, the lowest first.
void read_runs_of_pixels(Source& source, std::vector<Pixel>& line) {
  int shift = 0;
  for (size_t x = 0; x < line.size();) {
    Pixel pixel;
    for (uint8_t& value : pixel) value = source.next();
    if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
      line[x++] = pixel;
      shift = 0;
      continue;
    }
    const size_t count = shift < 24 ? size_t{pixel[3]} << shift : line.size() + 1;
    if (x == 0 || count > line.size() - x) throw_damaged();
    for (const size_t end = x + count; x < end; ++x) line[x] = line[x - 1];
    shift += 8;
  }
}

Rgb to_color(const Pixel& pixel) {
  if (pixel[3] == 0) return Rgb(0.f);
  const float scale = std::ldexp(1.f, int{pixel[3]} - (128 + 8));
  return scale * Rgb(pixel[0], pixel[1], pixel[2]);
}

}  // namespace

void read_radiance(const std::string& bytes, StoredImage& image) {
  Source source(bytes);
  bool is_xyz = false;
  for (std::string line = source.line(); !line.empty(); line = source.line()) {
    if (line.starts_with("FORMAT=")) is_xyz = line.find("xyze") != std::string::npos;
  }
  Axis first, second;
  const std::string size = source.line();
  std::istringstream(size) >> first.sign >> first.name >> first.size >> second.sign >>
      second.name >> second.size;
  const auto is_axis = [](const Axis& axis) {
    return (axis.sign == '+' || axis.sign == '-') && (axis.name == 'X' || axis.name == 'Y') &&
           axis.size > 0;
  };
  if (!is_axis(first) || !is_axis(second) || first.name == second.name) {
    throw std::runtime_error("its header must have a size such as '-Y 512 +X 1024', got '" +
                             size.substr(0, 40) + "'");
  }
  const int64_t width = first.name == 'X' ? first.size : second.size;
  const int64_t height = first.name == 'X' ? second.size : first.size;
  // Two bytes encode at most 127 values of a channel. (Runs of pixels can be longer, but no program
  // has written them since 1991.)
  constexpr uint64_t kBestRatio = 64;
  // Unsigned, because the product may overflow before set_size() refuses absurd sizes.
  const auto pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  set_size(image, width, height, pixels * 4, kBestRatio, bytes.size());
  image.channels = 3;
  image.floats.resize(static_cast<size_t>(width * height) * 3);
  const glm::mat3 to_rgb =
      is_xyz ? glm::mat3(glm::inverse(glm::dmat3(xyz({1, 0, 0}), xyz({0, 1, 0}), xyz({0, 0, 1}))))
             : glm::mat3(1.f);
  std::vector<Pixel> line(static_cast<size_t>(second.size));
  for (int64_t i = 0; i < first.size; ++i) {
    if (source.has_runs_of_channels(line.size())) {
      read_runs_of_channels(source, line);
    } else {
      read_runs_of_pixels(source, line);
    }
    for (int64_t j = 0; j < second.size; ++j) {
      const int64_t a = first.position(i), b = second.position(j);
      const int64_t x = first.name == 'X' ? a : b, y = first.name == 'X' ? b : a;
      const Rgb color = to_rgb * to_color(line[static_cast<size_t>(j)]);
      for (int c = 0; c < 3; ++c)
        image.floats[static_cast<size_t>((y * width + x) * 3 + c)] = color[c];
    }
  }
}

}  // namespace kinome
