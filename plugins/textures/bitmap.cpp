#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

#include "kinome/image.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/texture.h"
#include "open_image.h"

/// An image over (u, v), as Mitsuba 3's: row 0 lies at v = 0, texel (i, j) is centred at
/// ((i + .5) / width, (j + .5) / height). 8- and 16-bit images are decoded from sRGB before any
/// interpolation, unless `raw`. Colours of an EXR whose `chromaticities` are not Rec.709's become
/// linear Rec.709, `raw` or not. Alpha is dropped.
///
///     <texture type="bitmap" name="diffuse_reflectance">
///       <string name="filename" value="wood.jpg"/>
///       <transform name="to_uv"><scale value="4"/></transform>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"filename", ParameterType::kFile, nullptr,
     "OpenEXR (its chromaticities, if any, are converted to Rec.709), PFM, or anything that "
     "OpenImageIO reads (PNG, JPEG, TIFF, HDR, ...)",
     true},
    {"filter_type", ParameterType::kString, "bilinear", "bilinear or nearest"},
    {"wrap_mode", ParameterType::kString, "repeat", "outside [0,1]: repeat, mirror or clamp"},
    {"raw", ParameterType::kBoolean, "false", "numbers, not colours: no sRGB decoding"},
    {"to_uv", ParameterType::kTransform, "identity", "from surface to image coordinates"},
};

enum class Filter { kBilinear, kNearest };
enum class Wrap { kRepeat, kMirror, kClamp };
constexpr const char* kFilters[] = {"bilinear", "nearest"};
constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};

/// R, G, B or one channel of a float image.
StoredImage pick_channels(const Image& image, const std::string& path) {
  const auto index = [&](const char* name) {
    const auto it = std::find(image.channels.begin(), image.channels.end(), name);
    return it == image.channels.end() ? -1 : static_cast<int>(it - image.channels.begin());
  };
  std::vector<int> picked{index("R"), index("G"), index("B")};
  if (picked[0] < 0 || picked[1] < 0 || picked[2] < 0) {
    const int grey = image.channel_count() == 1 ? 0 : index("Y");
    if (grey < 0) {
      throw Error(Location{path}, "has no channels R, G, B, nor Y, nor a single one");
    }
    picked = {grey};
  }
  std::vector<std::string> unused;
  for (int c = 0; c < image.channel_count(); ++c) {
    const bool is_picked = std::find(picked.begin(), picked.end(), c) != picked.end();
    if (!is_picked) unused.push_back("channel " + image.channels[static_cast<size_t>(c)]);
  }
  log_unused(path, unused);
  StoredImage stored;
  stored.width = image.width;
  stored.height = image.height;
  stored.channels = static_cast<int>(picked.size());
  stored.floats.reserve(static_cast<size_t>(image.width) * image.height * picked.size());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (const int c : picked) {
        stored.floats.push_back(image.at(x, y, c));
      }
    }
  }
  return stored;
}

StoredImage load_image(const std::string& path, const Properties& props) {
  std::array<char, 4> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  if (std::memcmp(magic.data(), "\x76\x2f\x31\x01", 4) == 0) {
    return pick_channels(read_exr(path), path);
  }
  if (magic[0] == 'P' && (magic[1] == 'F' || magic[1] == 'f')) {
    return pick_channels(read_pfm(path), path);
  }
  return open_image(path, props);
}

class Bitmap final : public Texture {
 public:
  explicit Bitmap(const Properties& props)
      : filter_(static_cast<Filter>(props.choice("filter_type", kFilters))),
        wrap_(static_cast<Wrap>(props.choice("wrap_mode", kWraps))),
        to_uv_(props.transform("to_uv")) {
    const bool raw = props.boolean("raw");
    const std::string path = props.file("filename");
    image_ = load_image(path, props);
    const bool decode = image_.is_encoded && !raw;
    for (size_t i = 0; i < decoded_.size(); ++i) {
      const float v = static_cast<float>(i) / 255;
      decoded_[i] = decode ? srgb_to_linear(v) : v;
    }
    if (decode) {
      for (float& v : image_.floats) {
        v = srgb_to_linear(v);
      }
    }
    summarise(path, props);
  }

  Rgb eval(const Vec2& uv) const override {
    const Vec3 p = to_uv_.point(Vec3(uv.x, uv.y, 0.f));
    const float x = reduced(p.x) * static_cast<float>(image_.width);
    const float y = reduced(p.y) * static_cast<float>(image_.height);
    if (filter_ == Filter::kNearest) {
      return texel(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
    }
    const float x0 = std::floor(x - 0.5f);
    const float y0 = std::floor(y - 0.5f);
    const float wx = x - 0.5f - x0;
    const float wy = y - 0.5f - y0;
    const int i = static_cast<int>(x0);
    const int j = static_cast<int>(y0);
    return (1 - wy) * ((1 - wx) * texel(i, j) + wx * texel(i + 1, j)) +
           wy * ((1 - wx) * texel(i, j + 1) + wx * texel(i + 1, j + 1));
  }

  float eval_1(const Vec2& uv) const override {
    const Rgb value = eval(uv);
    return image_.channels == 1 ? value.x : luminance(value);
  }
  Rgb mean() const override { return mean_; }
  glm::uvec2 resolution() const override { return {image_.width, image_.height}; }
  float max() const override { return max_component(channel_max_); }
  float min() const override { return min_; }
  Rgb channel_max() const override { return channel_max_; }

 private:
  /// The coordinate in few periods around [0, 1], so that it fits an int; NaN becomes 0.
  float reduced(float u) const {
    if (!std::isfinite(u)) {
      return 0;
    }
    switch (wrap_) {
      case Wrap::kRepeat:
        return u - std::floor(u);
      case Wrap::kMirror:
        return u - 2 * std::floor(0.5f * u);
      case Wrap::kClamp:
        break;
    }
    return std::clamp(u, -1.f, 2.f);
  }

  int wrapped(int i, int size) const {
    switch (wrap_) {
      case Wrap::kRepeat: {
        const int r = i % size;
        return r < 0 ? r + size : r;
      }
      case Wrap::kMirror: {
        const int r = i % (2 * size);
        const int positive = r < 0 ? r + 2 * size : r;
        return positive < size ? positive : 2 * size - 1 - positive;
      }
      case Wrap::kClamp:
        break;
    }
    return std::clamp(i, 0, size - 1);
  }

  float value(size_t index) const {
    return image_.bytes.empty() ? image_.floats[index] : decoded_[image_.bytes[index]];
  }

  Rgb texel(int x, int y) const {
    const size_t row = static_cast<size_t>(wrapped(y, image_.height));
    const size_t column = static_cast<size_t>(wrapped(x, image_.width));
    const size_t first =
        (row * static_cast<size_t>(image_.width) + column) * static_cast<size_t>(image_.channels);
    return image_.channels == 1 ? Rgb(value(first))
                                : Rgb(value(first), value(first + 1), value(first + 2));
  }

  /// Mean and extremes; refuses texels that are no numbers, warns of negative ones.
  void summarise(const std::string& path, const Properties& props) {
    Summary summary(image_.channels);
    if (image_.bytes.empty()) {
      summarise_floats(path, summary);
    } else {
      summarise_bytes(summary);
    }
    const double texels = static_cast<double>(image_.width) * image_.height;
    for (int c = 0; c < 3; ++c) {
      const size_t from = image_.channels == 1 ? 0 : static_cast<size_t>(c);
      mean_[c] = static_cast<float>(summary.sum[from] / texels);
      channel_max_[c] = summary.max[from];
      min_ = std::min(min_, summary.min[from]);
    }
    if (min_ < 0) {
      props.warn("filename",
                 "has negative texels, which are kept: the smallest is " + std::to_string(min_));
    }
  }

  struct Summary {
    explicit Summary(int channels)
        : sum(channels, 0.), max(channels, -kInfinity), min(channels, kInfinity) {}
    void add(size_t c, float value, double count) {
      sum[c] += value * count;
      max[c] = std::max(max[c], value);
      min[c] = std::min(min[c], value);
    }
    std::vector<double> sum;
    std::vector<float> max;
    std::vector<float> min;
  };

  void summarise_floats(const std::string& path, Summary& summary) const {
    const size_t channels = static_cast<size_t>(image_.channels);
    for (size_t i = 0; i < image_.floats.size(); i += channels) {
      for (size_t c = 0; c < channels; ++c) {
        const float v = image_.floats[i + c];
        if (!std::isfinite(v)) {
          const size_t texel = i / channels;
          const size_t width = static_cast<size_t>(image_.width);
          throw Error(Location{path},
                      "has a NaN or infinite texel at x = " + std::to_string(texel % width) +
                          ", y = " + std::to_string(texel / width));
        }
        summary.add(c, v, 1);
      }
    }
  }

  /// By a histogram: large photographs are counted, not decoded.
  void summarise_bytes(Summary& summary) const {
    const size_t channels = static_cast<size_t>(image_.channels);
    std::array<std::array<uint64_t, 256>, 3> count{};
    for (size_t i = 0; i < image_.bytes.size(); i += channels) {
      for (size_t c = 0; c < channels; ++c) {
        ++count[c][image_.bytes[i + c]];
      }
    }
    for (size_t c = 0; c < channels; ++c) {
      for (size_t v = 0; v < 256; ++v) {
        if (count[c][v] > 0) {
          summary.add(c, decoded_[v], static_cast<double>(count[c][v]));
        }
      }
    }
  }

  Filter filter_;
  Wrap wrap_;
  Transform to_uv_;
  StoredImage image_;
  std::array<float, 256> decoded_;
  Rgb mean_{0.f};
  Rgb channel_max_{0.f};
  float min_ = kInfinity;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Bitmap, kinome::Category::kTexture, "bitmap",
              "An image file over the surface's (u, v).", kinome::kParameters);
