#include <algorithm>
#include <array>
#include <cstring>

#include "kinome/plugin.h"
#include "kinome/texture.h"
#include "kinome/wide/vectors.h"
#include "stored_image.h"
#include "to_uv.h"

/// An image over (u, v), as in Mitsuba 3: row 0 is at v = 0, and texel (i, j) is centred at
/// ((i + .5) / width, (j + .5) / height). 8- and 16-bit images are decoded from sRGB before
/// interpolation, unless `raw` is set. The colour of an EXR is that of its part or layer with
/// colour, converted to linear Rec.709 from its `chromaticities`, from XYZ, or from luminance with
/// chroma, `raw` or not. Alpha is dropped. NaN becomes 0, with a warning.
///
///     <texture type="bitmap" name="diffuse_reflectance">
///       <string name="filename" value="wood.jpg"/>
///       <transform name="to_uv"><scale value="4"/></transform>
///     </texture>
namespace kinome {
namespace {

constexpr const char* kFilters[] = {"bilinear", "nearest"};
constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};

constexpr Parameter kParameters[] = {
    {"filename", ParameterType::kFile, nullptr,
     "OpenEXR (XYZ, luminance with chroma, and other primaries are converted to Rec.709), PFM, "
     "PNG, JPEG, Radiance (HDR), or any format that OpenImageIO reads (TIFF, TGA, ...)",
     true},
    {"data", ParameterType::kImage, nullptr,
     "pixels from a program, instead of the file: linear, with one or three channels"},
    choice_of("filter_type", kFilters, "bilinear", "interpolation: bilinear or nearest"),
    choice_of("wrap_mode", kWraps, "repeat", "texels outside [0,1]: repeat, mirror or clamp"),
    {"raw", ParameterType::kBoolean, "false",
     "use the values without sRGB decoding, for data other than colours"},
    ignored_row("format", ParameterType::kString, "texels have the precision of their file"),
    ignored_row("accel", ParameterType::kBoolean, "it selects texture units of graphics cards"),
    {"to_uv", ParameterType::kTransform, "identity", "transform from surface to image coordinates"},
};

enum class Filter { kBilinear, kNearest };
enum class Wrap { kRepeat, kMirror, kClamp };

/// Loads bytes p[i] ... p[i + 3] in each lane, the first one lowest. All four must be readable, and
/// indices must not be negative.
KINOME_WIDE wide::Int gather_bytes(const uint8_t* p, wide::Int i) {
  alignas(kColumnAlignment) int32_t index[wide::kLanes];
  alignas(kColumnAlignment) uint32_t value[wide::kLanes];
  i.store(index);
  for (size_t lane = 0; lane < wide::kLanes; ++lane) std::memcpy(value + lane, p + index[lane], 4);
  return wide::Int::load(value);
}

class Bitmap final : public Texture {
 public:
  explicit Bitmap(const Properties& props)
      : filter_(static_cast<Filter>(props.choice("filter_type"))),
        wrap_(static_cast<Wrap>(props.choice("wrap_mode"))),
        to_uv_(props.transform("to_uv")) {
    const bool raw = props.boolean("raw");
    image_ = LoadedImage(props).image;
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
    summarise();
    // Padding, because three channels are loaded as four bytes.
    if (!image_.bytes.empty()) image_.bytes.insert(image_.bytes.end(), 3, 0);
  }

  Rgb eval(const Vec2& uv) const override { return color_at<float>(uv); }
  float eval_1(const Vec2& uv) const override { return number_of(color_at<float>(uv)); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    if (!has_short_indices()) return Texture::eval_block(uv, count, out);
    wide::for_lanes(
        count, [&](size_t i) { color_at<wide::Float>(wide::Vec2::load(uv, i)).store(out, i); });
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    if (!has_short_indices()) return Texture::eval_1_block(uv, count, out);
    wide::for_lanes(count, [&](size_t i) {
      number_of(color_at<wide::Float>(wide::Vec2::load(uv, i))).store(out + i);
    });
  }
  Vec2 eval_1_gradient(const Vec2& uv) const override { return gradient_at<float>(uv); }
  void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const override {
    if (!has_short_indices()) return Texture::eval_1_gradient_block(uv, count, out);
    wide::for_lanes(
        count, [&](size_t i) { gradient_at<wide::Float>(wide::Vec2::load(uv, i)).store(out, i); });
  }
  Rgb mean() const override { return mean_; }
  glm::uvec2 resolution() const override { return {image_.width, image_.height}; }
  float max() const override { return max_component(channel_max_); }
  float min() const override { return min_; }
  Rgb channel_max() const override { return channel_max_; }

 private:
  template <class F>
  RgbOf<F> color_at(const Vec2Of<F>& uv) const {
    const Vec2Of<F> p = texture_coordinates<F>(to_uv_, uv);
    const F x = reduced(p.x) * static_cast<float>(image_.width);
    const F y = reduced(p.y) * static_cast<float>(image_.height);
    if (filter_ == Filter::kNearest) return texel(to_int(floor(x)), to_int(floor(y)));
    const Corner<F> at(x, y);
    return (1.f - at.wy) * ((1.f - at.wx) * texel(at.i, at.j) + at.wx * texel(at.i + 1, at.j)) +
           at.wy * ((1.f - at.wx) * texel(at.i, at.j + 1) + at.wx * texel(at.i + 1, at.j + 1));
  }

  /// The first of four texels, and the weights of the position between them.
  template <class F>
  struct Corner {
    Corner(const F& x, const F& y) {
      const F x0 = floor(x - 0.5f), y0 = floor(y - 0.5f);
      wx = x - 0.5f - x0, wy = y - 0.5f - y0;
      i = to_int(x0), j = to_int(y0);
    }
    F wx, wy;
    IntOf<F> i, j;
  };

  template <class F>
  Vec2Of<F> gradient_at(const Vec2Of<F>& uv) const {
    if (filter_ == Filter::kNearest) return {F(0.f), F(0.f)};
    const Vec2Of<F> p = texture_coordinates<F>(to_uv_, uv);
    const float width = static_cast<float>(image_.width);
    const float height = static_cast<float>(image_.height);
    const Corner<F> at(reduced(p.x) * width, reduced(p.y) * height);
    const RgbOf<F> a = texel(at.i, at.j), b = texel(at.i + 1, at.j);
    const RgbOf<F> c = texel(at.i, at.j + 1), d = texel(at.i + 1, at.j + 1);
    // Differences per texel.
    const F along_x = number_of((1.f - at.wy) * (b - a) + at.wy * (d - c));
    const F along_y = number_of((1.f - at.wx) * (c - a) + at.wx * (d - b));
    // As in Mitsuba, width and height are applied along u and v. This is only exact if to_uv
    // doesn't rotate the image or the image is square, but scenes are designed to look right in
    // Mitsuba.
    const Mat4& m = to_uv_.matrix();
    return {width * (m[0][0] * along_x + m[0][1] * along_y),
            height * (m[1][0] * along_x + m[1][1] * along_y)};
  }

  template <class V>
  NumberOf<V> number_of(const V& color) const {
    return image_.channels == 1 ? color.x : luminance(color);
  }

  /// Reduces a coordinate to at most two periods, so that texel indices fit in an int. NaN becomes
  /// 0.
  template <class F>
  F reduced(const F& u) const {
    F r = clamp(u, F(-1.f), F(2.f));
    if (wrap_ == Wrap::kRepeat) r = u - floor(u);
    if (wrap_ == Wrap::kMirror) r = u - 2.f * floor(0.5f * u);
    return select(is_finite(u), r, F(0.f));
  }

  /// Wraps an index that is at most one texel outside the range of reduced() coordinates.
  template <class I>
  I wrapped(const I& i, int size) const {
    if (wrap_ == Wrap::kClamp) return clamp(i, I(0), I(size - 1));
    const int period = wrap_ == Wrap::kRepeat ? size : 2 * size;
    const I r = select(i < 0, i + period, select(i >= period, i - period, i));
    if (wrap_ == Wrap::kRepeat) return r;
    return select(r < size, r, 2 * size - 1 - r);
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

  wide::Rgb texel(wide::Int x, wide::Int y) const {
    const wide::Int first =
        (wrapped(y, image_.height) * image_.width + wrapped(x, image_.width)) * image_.channels;
    if (image_.bytes.empty()) {
      const float* const p = image_.floats.data();
      const wide::Float r = gather(p, first);
      return image_.channels == 1 ? wide::Rgb(r)
                                  : wide::Rgb(r, gather(p + 1, first), gather(p + 2, first));
    }
    const wide::Int bytes = gather_bytes(image_.bytes.data(), first);
    const auto decode = [&](wide::Int byte) { return gather(decoded_.data(), byte & 255); };
    const wide::Float r = decode(bytes);
    return image_.channels == 1
               ? wide::Rgb(r)
               : wide::Rgb(r, decode(shift_right<8>(bytes)), decode(shift_right<16>(bytes)));
  }

  /// True if indices fit in the 31 bits of wide::Int.
  bool has_short_indices() const {
    return std::max(image_.bytes.size(), image_.floats.size()) < size_t(1) << 31;
  }

  /// Computes the mean, minimum and maximum.
  void summarise() {
    Summary summary(image_.channels);
    if (image_.bytes.empty()) {
      summarise_floats(summary);
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

  void summarise_floats(Summary& summary) const {
    const size_t channels = static_cast<size_t>(image_.channels);
    for (size_t i = 0; i < image_.floats.size(); ++i) {
      summary.add(i % channels, image_.floats[i], 1);
    }
  }

  /// Uses a histogram, so that each of 256 values is decoded once.
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
