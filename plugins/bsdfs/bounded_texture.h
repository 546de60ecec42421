#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "kinome/derived_texture.h"
#include "kinome/properties.h"

namespace kinome {

/// Clamps the values of another texture to [0, upper_bound].
class BoundedTexture final : public DerivedTexture {
 public:
  BoundedTexture(std::shared_ptr<const Texture> base, float upper_bound)
      : DerivedTexture(std::move(base)), upper_bound_(upper_bound) {}

 private:
  Rgb map_color(const Rgb& color) const override { return glm::clamp(color, 0.f, upper_bound_); }
  float map_number(float number) const override { return std::clamp(number, 0.f, upper_bound_); }
  void map_colors(size_t count, const Columns3& colors) const override {
    for (float* const column : {colors.x, colors.y, colors.z}) map_numbers(count, column);
  }
  void map_numbers(size_t count, float* numbers) const override {
    for (size_t i = 0; i < count; ++i) numbers[i] = map_number(numbers[i]);
  }

  float upper_bound_;
};

/// Returns `texture` if it stays below `upper_bound`. Otherwise logs a warning at the parameter
/// `name` and returns a BoundedTexture; throws if the texture is a single value.
inline std::shared_ptr<Texture> bounded_texture(const Properties& props, const std::string& name,
                                                std::shared_ptr<Texture> texture,
                                                float upper_bound) {
  // Half floats and filtering round; 1e-3 is their precision at 1.
  if (!(texture->max() > 1.001f * upper_bound)) return texture;
  const std::string range =
      "must be between 0 and " + std::to_string(static_cast<int>(upper_bound)) + ", ";
  const std::string max_value = format_number(texture->max());
  if (texture->is_uniform()) throw props.error(name, range + "got " + max_value);
  props.warn(name, range + "but its texture has values up to " + max_value +
                       ": they are clamped to that range");
  return std::make_shared<BoundedTexture>(std::move(texture), upper_bound);
}

}  // namespace kinome
