#include "kinome/derived_texture.h"
#include "kinome/plugin.h"
#include "kinome/wide/textures.h"

/// Another texture times a number or a colour, as in Mitsuba 0.6.
///
///     <texture type="scale" name="reflectance">
///       <rgb name="scale" value="0.5 0.4 0.3"/>
///       <texture type="checkerboard"/>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"scale", ParameterType::kUnitlessTexture, "1",
     "factor, a number or a colour; single numbers are scaled by its luminance"},
    {"value", ParameterType::kColorTexture, nullptr,
     "scaled colour; alternative to a nested texture"},
    {"texture", ParameterType::kObject, nullptr, "scaled texture", false, Category::kTexture},
};

class Scale final : public DerivedTexture {
 public:
  explicit Scale(const Properties& props)
      : DerivedTexture(read_texture(props)),
        scale_(read_scale(props)),
        scale_1_(luminance(scale_)) {}

  Vec2 eval_1_gradient(const Vec2& uv) const override {
    return scale_1_ * base().eval_1_gradient(uv);
  }
  void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const override {
    base().eval_1_gradient_block(uv, count, out);
    map_numbers(count, out.x);
    map_numbers(count, out.y);
  }
  float max() const override { return max_component(channel_max()); }
  float min() const override {
    const float value = base().min();
    return value * (value < 0 ? max_component(scale_) : std::min({scale_.x, scale_.y, scale_.z}));
  }

 private:
  static std::shared_ptr<const Texture> read_texture(const Properties& props) {
    const bool has_value = props.has("value");
    if (const auto nested = props.object<Texture>("texture")) {
      if (has_value) {
        throw props.error("value", "can't be combined with a nested texture: remove one of them");
      }
      return nested;
    }
    if (!has_value) throw props.error("texture", "is missing: nest a texture, or set 'value'");
    return props.texture("value");
  }
  static Rgb read_scale(const Properties& props) {
    const auto texture = props.texture("scale");
    if (!texture->is_uniform()) {
      throw props.error("scale", "must be a number or a colour, got a texture");
    }
    const Rgb scale = texture->mean();
    const bool is_valid = is_finite(scale) && std::min({scale.x, scale.y, scale.z}) >= 0;
    if (!is_valid) throw props.error("scale", "must be finite and not negative");
    return scale;
  }

  Rgb map_color(const Rgb& color) const override { return scale_ * color; }
  float map_number(float number) const override { return scale_1_ * number; }
  void map_colors(size_t count, const Columns3& colors) const override {
    const wide::Rgb factor(scale_);
    wide::for_lanes(count,
                    [&](size_t i) { (wide::Rgb::load(colors, i) * factor).store(colors, i); });
  }
  void map_numbers(size_t count, float* numbers) const override {
    wide::for_lanes(
        count, [&](size_t i) { (wide::Float::load(numbers + i) * scale_1_).store(numbers + i); });
  }

  Rgb scale_;
  float scale_1_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Scale, kinome::Category::kTexture, "scale",
              "Another texture times a number or a colour, as in Mitsuba 0.6.",
              kinome::kParameters);
