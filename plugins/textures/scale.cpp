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

class Scale final : public Texture {
 public:
  explicit Scale(const Properties& props)
      : texture_(read_texture(props)), scale_(read_scale(props)), scale_1_(luminance(scale_)) {}

  Rgb eval(const Vec2& uv) const override { return scale_ * texture_->eval(uv); }
  float eval_1(const Vec2& uv) const override { return scale_1_ * texture_->eval_1(uv); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    texture_->eval_block(uv, count, out);
    scale_colors(count, out);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    texture_->eval_1_block(uv, count, out);
    scale_numbers(count, out);
  }
  Vec2 eval_1_gradient(const Vec2& uv) const override {
    return scale_1_ * texture_->eval_1_gradient(uv);
  }
  void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const override {
    texture_->eval_1_gradient_block(uv, count, out);
    scale_numbers(count, out.x);
    scale_numbers(count, out.y);
  }
  Rgb eval_at(const SurfaceInteraction& si) const override { return scale_ * texture_->eval_at(si); }
  float eval_1_at(const SurfaceInteraction& si) const override {
    return scale_1_ * texture_->eval_1_at(si);
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    texture_->eval_block_at(points, out);
    scale_colors(points.count, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    texture_->eval_1_block_at(points, out);
    scale_numbers(points.count, out);
  }

  std::string attribute() const override { return texture_->attribute(); }
  Rgb mean() const override { return scale_ * texture_->mean(); }
  Rgb emission() const override { return scale_ * texture_->emission(); }
  float max() const override { return max_component(channel_max()); }
  float min() const override {
    const float value = texture_->min();
    return value * (value < 0 ? max_component(scale_) : std::min({scale_.x, scale_.y, scale_.z}));
  }
  Rgb channel_max() const override { return scale_ * texture_->channel_max(); }
  bool is_uniform() const override { return texture_->is_uniform(); }
  glm::uvec2 resolution() const override { return texture_->resolution(); }

 private:
  static std::shared_ptr<const Texture> read_texture(const Properties& props) {
    const bool has_value = props.has("value");
    if (const auto nested = props.object<Texture>()) {
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

  void scale_colors(size_t count, const Columns3& out) const {
    const wide::Rgb factor(scale_);
    wide::for_lanes(count, [&](size_t i) { (wide::Rgb::load(out, i) * factor).store(out, i); });
  }
  void scale_numbers(size_t count, float* out) const {
    wide::for_lanes(count,
                    [&](size_t i) { (wide::Float::load(out + i) * scale_1_).store(out + i); });
  }

  std::shared_ptr<const Texture> texture_;
  Rgb scale_;
  float scale_1_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Scale, kinome::Category::kTexture, "scale",
              "Another texture times a number or a colour, as in Mitsuba 0.6.",
              kinome::kParameters);
