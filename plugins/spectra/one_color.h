#pragma once

#include <algorithm>

#include "kinome/plugin.h"
#include "kinome/texture.h"

namespace kinome {

/// Base of textures that are a single colour, or forward to another texture. Mitsuba's spectra are
/// such textures, because they reduce to colours in RGB.
class OneColor : public Texture {
 public:
  explicit OneColor(const Rgb& color) : OneColor(color, color) {}
  /// A spectrum, given by its colours as a reflectance and as emission.
  OneColor(const Rgb& reflectance, const Rgb& emission)
      : color_(make_uniform_texture(reflectance)), emission_(emission) {}
  explicit OneColor(std::shared_ptr<Texture> other)
      : color_(std::move(other)), emission_(color_->emission()) {}

  Rgb eval(const Vec2& uv) const final { return color_->eval(uv); }
  float eval_1(const Vec2& uv) const final { return color_->eval_1(uv); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const final {
    color_->eval_block(uv, count, out);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const final {
    color_->eval_1_block(uv, count, out);
  }
  Vec2 eval_1_gradient(const Vec2& uv) const final { return color_->eval_1_gradient(uv); }
  void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const final {
    color_->eval_1_gradient_block(uv, count, out);
  }
  Rgb eval_at(const SurfaceInteraction& si) const final { return color_->eval_at(si); }
  float eval_1_at(const SurfaceInteraction& si) const final { return color_->eval_1_at(si); }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const final {
    color_->eval_block_at(points, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const final {
    color_->eval_1_block_at(points, out);
  }
  std::string attribute() const final { return color_->attribute(); }
  Rgb mean() const final { return color_->mean(); }
  Rgb emission() const final { return emission_; }
  float max() const final { return color_->max(); }
  float min() const final { return color_->min(); }
  Rgb channel_max() const final { return color_->channel_max(); }
  bool is_uniform() const final { return color_->is_uniform(); }
  glm::uvec2 resolution() const final { return color_->resolution(); }

 private:
  std::shared_ptr<Texture> color_;
  Rgb emission_;
};

/// Returns a number or colour, or throws if it is negative.
inline Rgb not_negative(const Properties& props, const char* name, const Rgb& value) {
  const float min_value = std::min({value.x, value.y, value.z});
  if (min_value >= 0) return value;
  throw props.error(name, "must not be negative, got " + std::to_string(min_value));
}

}  // namespace kinome
