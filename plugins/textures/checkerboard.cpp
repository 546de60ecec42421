#include "kinome/plugin.h"
#include "kinome/wide/textures.h"
#include "to_uv.h"

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
        number0_(color0_.texture()),
        number1_(color1_.texture()),
        to_uv_(props.transform("to_uv")) {}

  Rgb eval(const Vec2& uv) const override {
    return halves_match<float>(uv) ? color0_.at(uv) : color1_.at(uv);
  }
  float eval_1(const Vec2& uv) const override {
    return halves_match<float>(uv) ? number1_.at(uv) : number0_.at(uv);
  }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    choose_colors({color0_, uv, count}, {color1_, uv, count}, uv, count, out);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    choose_numbers({number0_, uv, count}, {number1_, uv, count}, uv, count, out);
  }
  Rgb eval_at(const SurfaceInteraction& si) const override {
    return halves_match<float>(si.uv) ? color0_.at(si) : color1_.at(si);
  }
  float eval_1_at(const SurfaceInteraction& si) const override {
    return halves_match<float>(si.uv) ? number1_.at(si) : number0_.at(si);
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    choose_colors({color0_, points}, {color1_, points}, points.uv, points.count, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    choose_numbers({number0_, points}, {number1_, points}, points.uv, points.count, out);
  }
  /// Edges aside, it is flat.
  Vec2 eval_1_gradient(const Vec2&) const override { return Vec2(0); }
  Rgb mean() const override { return 0.5f * (color0_->mean() + color1_->mean()); }
  float max() const override { return std::max(color0_->max(), color1_->max()); }
  float min() const override { return std::min(color0_->min(), color1_->min()); }
  Rgb channel_max() const override {
    return glm::max(color0_->channel_max(), color1_->channel_max());
  }

 private:
  void choose_colors(const wide::ColorInput::Columns& color0,
                     const wide::ColorInput::Columns& color1, const Columns2& uv, size_t count,
                     const Columns3& out) const {
    wide::for_lanes(count, [&](size_t i) {
      const auto match = halves_match<wide::Float>(wide::Vec2::load(uv, i));
      select(match, color0[i], color1[i]).store(out, i);
    });
  }
  void choose_numbers(const wide::NumberInput::Columns& number0,
                      const wide::NumberInput::Columns& number1, const Columns2& uv, size_t count,
                      float* out) const {
    wide::for_lanes(count, [&](size_t i) {
      const auto match = halves_match<wide::Float>(wide::Vec2::load(uv, i));
      select(match, number1[i], number0[i]).store(out + i);
    });
  }

  /// Nothing that a texture is for takes negative values; those of a nested image were warned of.
  static std::shared_ptr<Texture> read_color(const Properties& props, const std::string& name) {
    auto color = props.texture(name);
    if (color->is_uniform() && color->min() < 0) {
      throw props.error(name, "must not be negative, got " + std::to_string(color->min()));
    }
    return color;
  }

  template <class F>
  MaskOf<F> halves_match(const Vec2Of<F>& uv) const {
    const Vec2Of<F> p = texture_coordinates<F>(to_uv_, uv);
    const MaskOf<F> upper_u = p.x - floor(p.x) > 0.5f;
    const MaskOf<F> upper_v = p.y - floor(p.y) > 0.5f;
    return !(upper_u ^ upper_v);
  }

  wide::ColorInput color0_, color1_;
  wide::NumberInput number0_, number1_;
  Transform to_uv_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Checkerboard, kinome::Category::kTexture, "checkerboard",
              "Squares of two colours.", kinome::kParameters);
