#include "kinome/plugin.h"
#include "kinome/texture.h"

/// Two colours in squares of half a unit of (u, v), as in Mitsuba 3. As a colour it is color0 where
/// both coordinates lie in like halves. Read as one number (a roughness, say) Mitsuba swaps the two
/// colours; scenes are made to look right there, so the same is done here.
///
///     <texture type="checkerboard" name="reflectance">
///       <rgb name="color0" value="0.8 0.1 0.1"/><float name="color1" value="0.1"/>
///       <transform name="to_uv"><scale value="10"/></transform>
///     </texture>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"color0", ParameterType::kColorTexture, "0.4", "colour of one kind of squares"},
    {"color1", ParameterType::kColorTexture, "0.2", "colour of the other"},
    {"to_uv", ParameterType::kTransform, "identity", "from surface to texture coordinates"},
};

class Checkerboard final : public Texture {
 public:
  explicit Checkerboard(const Properties& props)
      : color0_(read_color(props, "color0")),
        color1_(read_color(props, "color1")),
        to_uv_(props.transform("to_uv")) {}

  Rgb eval(const Vec2& uv) const override {
    return halves_match(uv) ? color0_->eval(uv) : color1_->eval(uv);
  }
  float eval_1(const Vec2& uv) const override {
    return halves_match(uv) ? color1_->eval_1(uv) : color0_->eval_1(uv);
  }
  Rgb mean() const override { return 0.5f * (color0_->mean() + color1_->mean()); }
  float max() const override { return std::max(color0_->max(), color1_->max()); }
  float min() const override { return std::min(color0_->min(), color1_->min()); }
  Rgb channel_max() const override {
    return glm::max(color0_->channel_max(), color1_->channel_max());
  }

 private:
  /// Nothing that a texture is for takes negative values; those of a nested image were warned of.
  static std::shared_ptr<Texture> read_color(const Properties& props, const std::string& name) {
    auto color = props.texture(name);
    if (color->is_uniform() && color->min() < 0) {
      throw props.error(name, "must not be negative, got " + std::to_string(color->min()));
    }
    return color;
  }

  bool halves_match(const Vec2& uv) const {
    const Vec3 p = to_uv_.point(Vec3(uv.x, uv.y, 0.f));
    const bool upper_u = p.x - std::floor(p.x) > 0.5f;
    const bool upper_v = p.y - std::floor(p.y) > 0.5f;
    return upper_u == upper_v;
  }

  std::shared_ptr<Texture> color0_;
  std::shared_ptr<Texture> color1_;
  Transform to_uv_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Checkerboard, kinome::Category::kTexture, "checkerboard",
              "Squares of two colours.", kinome::kParameters);
