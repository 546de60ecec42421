#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "kinome/plugin.h"
#include "kinome/wide/textures.h"
#include "to_uv.h"

namespace kinome {

/// Two colours in a pattern over (u, v). Blocks evaluate both colours at all points, so a texture
/// that several nested patterns refer to is evaluated once for each path to it. Pattern must provide
///
///     template <class F>
///     MaskOf<F> is_first(const Vec2Of<F>& uv) const;  // true for color0
///     float share_of_first() const;                   // fraction of the unit square with color0
///     static constexpr bool kSwapsNumbers = …;        // swaps the colours if read as one number
template <class Pattern>
class TwoColors : public Texture {
 public:
  TwoColors(const Properties& props, Pattern pattern)
      : pattern_(pattern),
        color0_(read_color(props, "color0")),
        color1_(read_color(props, "color1")),
        number0_(color0_.texture()),
        number1_(color1_.texture()),
        to_uv_(props.transform("to_uv")) {}

  Rgb eval(const Vec2& uv) const override {
    return is_first<float>(uv) ? color0_.at(uv) : color1_.at(uv);
  }
  float eval_1(const Vec2& uv) const override {
    return takes_number0(is_first<float>(uv)) ? number0_.at(uv) : number1_.at(uv);
  }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    choose_colors({color0_, uv, count}, {color1_, uv, count}, uv, count, out);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    choose_numbers({number0_, uv, count}, {number1_, uv, count}, uv, count, out);
  }
  Rgb eval_at(const SurfaceInteraction& si) const override {
    return is_first<float>(si.uv) ? color0_.at(si) : color1_.at(si);
  }
  float eval_1_at(const SurfaceInteraction& si) const override {
    return takes_number0(is_first<float>(si.uv)) ? number0_.at(si) : number1_.at(si);
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    choose_colors({color0_, points}, {color1_, points}, points.uv, points.count, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    choose_numbers({number0_, points}, {number1_, points}, points.uv, points.count, out);
  }
  /// The texture is constant except at edges.
  Vec2 eval_1_gradient(const Vec2&) const override { return Vec2(0); }
  Rgb mean() const override {
    const float share = pattern_.share_of_first();
    return share * color0_->mean() + (1 - share) * color1_->mean();
  }
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
      const auto first = is_first<wide::Float>(wide::Vec2::load(uv, i));
      select(first, color0[i], color1[i]).store(out, i);
    });
  }
  void choose_numbers(const wide::NumberInput::Columns& number0,
                      const wide::NumberInput::Columns& number1, const Columns2& uv, size_t count,
                      float* out) const {
    wide::for_lanes(count, [&](size_t i) {
      const auto first = is_first<wide::Float>(wide::Vec2::load(uv, i));
      const auto zero = Pattern::kSwapsNumbers ? number1[i] : number0[i];
      const auto one = Pattern::kSwapsNumbers ? number0[i] : number1[i];
      select(first, zero, one).store(out + i);
    });
  }

  /// Throws for negative colours, which no parameter accepts. (A nested image warns about its own.)
  static std::shared_ptr<Texture> read_color(const Properties& props, const std::string& name) {
    auto color = props.texture(name);
    if (color->is_uniform() && color->min() < 0) {
      throw props.error(name, "must not be negative, got " + format_number(color->min()));
    }
    return color;
  }

  template <class F>
  MaskOf<F> is_first(const Vec2Of<F>& uv) const {
    return pattern_.template is_first<F>(texture_coordinates<F>(to_uv_, uv));
  }

  static bool takes_number0(bool is_first) { return is_first != Pattern::kSwapsNumbers; }

  Pattern pattern_;
  wide::ColorInput color0_, color1_;
  wide::NumberInput number0_, number1_;
  Transform to_uv_;
};

}  // namespace kinome
