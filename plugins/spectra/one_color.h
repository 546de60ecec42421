#pragma once

#include <algorithm>

#include "kinome/derived_texture.h"
#include "kinome/plugin.h"

namespace kinome {

/// Base of textures that are a single colour, or the same as another texture. Mitsuba's spectra are
/// such textures, because they reduce to colours in RGB.
class OneColor : public DerivedTexture {
 public:
  explicit OneColor(const Rgb& color) : OneColor(color, color) {}
  /// A spectrum, given by its colours as a reflectance and as emission.
  OneColor(const Rgb& reflectance, const Rgb& emission)
      : DerivedTexture(make_uniform_texture(reflectance)), emission_(emission) {}
  explicit OneColor(std::shared_ptr<Texture> other)
      : DerivedTexture(std::move(other)), emission_(base().emission()) {}

  Vec2 eval_1_gradient(const Vec2& uv) const final { return base().eval_1_gradient(uv); }
  void eval_1_gradient_block(const Columns2& uv, size_t count, const Columns2& out) const final {
    base().eval_1_gradient_block(uv, count, out);
  }
  Rgb emission() const final { return emission_; }

 private:
  Rgb emission_;
};

/// Returns a number or colour, or throws if it is negative.
inline Rgb not_negative(const Properties& props, const char* name, const Rgb& value) {
  const float min_value = std::min({value.x, value.y, value.z});
  if (min_value >= 0) return value;
  throw props.error(name, "must not be negative, got " + format_number(min_value));
}

}  // namespace kinome
