// Film of linear radiance, written as OpenEXR, PFM or RGBE.
//
//   <film type="hdrfilm">
//     <integer name="width" value="1024"/>
//     <integer name="height" value="1024"/>
//     <string name="pixel_format" value="rgba"/>
//     <rfilter type="box"/>
//   </film>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <optional>

#include "kinome/image_files.h"
#include "kinome/film.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

constexpr int64_t kMaxSide = 1 << 16;
/// Maximum number of pixels of the rendered window, which the renderer counts in int.
constexpr int64_t kMaxPixels = std::numeric_limits<int>::max();

enum class FileFormat { kExr, kPfm, kRgbe };
constexpr const char* kFileFormats[] = {"openexr", "exr", "pfm", "rgbe"};
constexpr FileFormat kFormatOfName[] = {FileFormat::kExr, FileFormat::kExr, FileFormat::kPfm,
                                        FileFormat::kRgbe};
constexpr const char* kExtensions[] = {".exr", ".pfm", ".rgbe"};  // by FileFormat
constexpr const char* kPixelFormats[] = {"luminance", "luminance_alpha", "rgb",
                                         "rgba",      "xyz",             "xyza"};
constexpr int kFirstRgb = 2, kFirstXyz = 4;
constexpr const char* kComponentFormats[] = {"float16", "float32", "uint32"};  // by ExrSampleType

const Parameter kTable[] = {
    {"width", ParameterType::kInteger, "768", "width of the full film in pixels"},
    {"height", ParameterType::kInteger, "576", "height of the full film in pixels"},
    {"crop_offset_x", ParameterType::kInteger, "0", "left edge of the crop window in pixels"},
    {"crop_offset_y", ParameterType::kInteger, "0", "upper edge of the crop window in pixels"},
    {"crop_width", ParameterType::kInteger, nullptr, "width of the crop window; default: width"},
    {"crop_height", ParameterType::kInteger, nullptr, "height of the crop window; default: height"},
    choice_of("file_format", kFileFormats, "openexr", "openexr (or exr), pfm or rgbe"),
    choice_of("pixel_format", kPixelFormats, "rgb",
              "luminance, luminance_alpha, rgb, rgba, xyz or xyza"),
    choice_of("component_format", kComponentFormats, "float16",
              "float16, float32 or uint32 (whose largest value is 1); pfm is always float32"),
    {"sample_border", ParameterType::kBoolean, "false",
     "also sample the border within the filter's radius, so that edge pixels have no more noise"},
    ignored_row("compensate", ParameterType::kBoolean, "sums are precise enough without it"),
    ignored_row("banner", ParameterType::kBoolean, "images have no banner"),
    {"rfilter", ParameterType::kObject, nullptr, "reconstruction filter; default: gaussian", false,
     Category::kReconstructionFilter},
};

/// Linear Rec.709 to CIE XYZ.
constexpr float kToXyz[3][3] = {{0.412453f, 0.357580f, 0.180423f},
                                {0.212671f, 0.715160f, 0.072169f},
                                {0.019334f, 0.119193f, 0.950227f}};

/// Converts R, G and B, the first three channels, to X, Y and Z.
Image to_xyz(Image image) {
  const char* const names[] = {"X", "Y", "Z"};
  for (size_t c = 0; c < 3; ++c) image.channels[c] = names[c];
  const size_t stride = image.channels.size();
  for (size_t i = 0; i < image.data.size(); i += stride) {
    const Rgb rgb(image.data[i], image.data[i + 1], image.data[i + 2]);
    for (size_t c = 0; c < 3; ++c) {
      image.data[i + c] = glm::dot(Rgb(kToXyz[c][0], kToXyz[c][1], kToXyz[c][2]), rgb);
    }
  }
  return image;
}

/// Like Properties::choice, but case-insensitive as in Mitsuba.
int choice(const Properties& props, const char* name, std::span<const char* const> choices) {
  std::string given = props.string(name);
  std::transform(given.begin(), given.end(), given.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (size_t i = 0; i < choices.size(); ++i) {
    if (given == choices[i]) return static_cast<int>(i);
  }
  return props.choice(name);  // throws, with a suggestion
}

class HdrFilm : public Film {
 public:
  explicit HdrFilm(const Properties& props) {
    width_ = side(props, "width");
    height_ = side(props, "height");
    read_crop(props);
    format_ = kFormatOfName[choice(props, "file_format", kFileFormats)];
    int pixel_format = choice(props, "pixel_format", kPixelFormats);
    const bool is_supported = format_ == FileFormat::kExr || pixel_format == kFirstRgb ||
                              (format_ == FileFormat::kPfm && pixel_format == 0);
    if (!is_supported) {
      props.warn("pixel_format",
                 "is unsupported by this file_format: using rgb, as Mitsuba 3 does");
      pixel_format = kFirstRgb;
    }
    is_luminance_ = pixel_format < kFirstRgb;
    is_xyz_ = pixel_format >= kFirstXyz;
    has_alpha_ = pixel_format % 2 == 1;
    number_ = static_cast<ExrSampleType>(choice(props, "component_format", kComponentFormats));
    sample_border_ = props.boolean("sample_border");
    filter_ = props.object<ReconstructionFilter>();
    if (!filter_) throw props.error("rfilter", "is missing: the film needs a nested <rfilter>");
  }

  void write(const std::string& path, const Image& image,
             const ImageMetadata& metadata) const override {
    std::filesystem::path file = path;
    if (!file.has_extension()) file += file_extension();
    if (format_ == FileFormat::kPfm) {
      write_pfm(file.string(), image);
    } else if (format_ == FileFormat::kRgbe) {
      write_rgbe(file.string(), image);
    } else {
      // Variances exceed the range of half floats, and ids of Cryptomatte have 32 bits.
      const bool needs_float =
          std::any_of(image.channels.begin(), image.channels.end(), [](const std::string& name) {
            return name.starts_with("variance.") || name.starts_with("Crypto");
          });
      std::optional<Image> xyz;  // without it, the image is written as it is, not copied
      if (is_xyz_) xyz = to_xyz(image);
      write_exr(file.string(), xyz ? *xyz : image, needs_float ? ExrSampleType::kFloat : number_,
                metadata, Vec2(crop_.x0, crop_.y0), Vec2(width_, height_));
    }
  }
  std::string file_extension() const override {
    return kExtensions[static_cast<int>(format_)];
  }

 private:
  static int side(const Properties& props, const char* name) {
    return static_cast<int>(props.integer(name, 1, kMaxSide));
  }

  void read_crop(const Properties& props) {
    const int64_t x = props.integer("crop_offset_x");
    const int64_t y = props.integer("crop_offset_y");
    const int64_t w = props.has("crop_width") ? side(props, "crop_width") : width_;
    const int64_t h = props.has("crop_height") ? side(props, "crop_height") : height_;
    check_crop(props, "crop_offset_x", x, w, width_);
    check_crop(props, "crop_offset_y", y, h, height_);
    check_pixels(props, w, h);
    crop_ = {static_cast<int>(x), static_cast<int>(y), static_cast<int>(x + w),
             static_cast<int>(y + h)};
  }
  static void check_crop(const Properties& props, const char* name, int64_t offset, int64_t size,
                         int full) {
    // This order of operations can't overflow.
    if (offset >= 0 && offset < full && size <= full - offset) return;
    throw props.error(name, "must keep the crop window within the film's " + std::to_string(full) +
                                " pixels, got " + std::to_string(size) + " pixels from " +
                                std::to_string(offset));
  }
  /// Only the crop window is limited; the film may be larger.
  static void check_pixels(const Properties& props, int64_t w, int64_t h) {
    if (w * h <= kMaxPixels) return;
    // Reports the parameter that sets the longer side.
    const bool by_width = w >= h;
    const char* name = by_width ? "crop_width" : "crop_height";
    if (!props.has(name)) name = by_width ? "width" : "height";
    throw props.error(name, "makes the image too large: must have at most " +
                                std::to_string(kMaxPixels) + " pixels, got " + std::to_string(w) +
                                " x " + std::to_string(h));
  }

  FileFormat format_ = FileFormat::kExr;
  bool is_xyz_ = false;
  ExrSampleType number_ = ExrSampleType::kHalf;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::HdrFilm, kinome::Category::kFilm, "hdrfilm",
              "Film of linear radiance, written as OpenEXR, PFM or RGBE.", kinome::kTable);
