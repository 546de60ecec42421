#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "kinome/properties.h"
#include "kinome/texture.h"

namespace kinome {

/// Clamps the values of another texture to [0, upper_bound].
class BoundedTexture final : public Texture {
 public:
  BoundedTexture(std::shared_ptr<const Texture> base, float upper_bound)
      : base_(std::move(base)), upper_bound_(upper_bound) {}

  Rgb eval(const Vec2& uv) const override { return bounded(base_->eval(uv)); }
  float eval_1(const Vec2& uv) const override { return bounded(base_->eval_1(uv)); }
  Rgb eval_at(const SurfaceInteraction& si) const override { return bounded(base_->eval_at(si)); }
  float eval_1_at(const SurfaceInteraction& si) const override {
    return bounded(base_->eval_1_at(si));
  }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    base_->eval_block(uv, count, out);
    bound(out, count);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    base_->eval_1_block(uv, count, out);
    bound(out, count);
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const override {
    base_->eval_block_at(points, out);
    bound(out, points.count);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    base_->eval_1_block_at(points, out);
    bound(out, points.count);
  }
  std::string attribute() const override { return base_->attribute(); }
  Rgb mean() const override { return bounded(base_->mean()); }
  float max() const override { return bounded(base_->max()); }
  float min() const override { return bounded(base_->min()); }
  Rgb channel_max() const override { return bounded(base_->channel_max()); }
  bool is_uniform() const override { return base_->is_uniform(); }
  glm::uvec2 resolution() const override { return base_->resolution(); }

 private:
  float bounded(float value) const { return std::clamp(value, 0.f, upper_bound_); }
  Rgb bounded(const Rgb& value) const { return glm::clamp(value, 0.f, upper_bound_); }
  void bound(float* values, size_t count) const {
    for (size_t i = 0; i < count; ++i) values[i] = bounded(values[i]);
  }
  void bound(const Columns3& columns, size_t count) const {
    for (float* const column : {columns.x, columns.y, columns.z}) bound(column, count);
  }

  std::shared_ptr<const Texture> base_;
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
  const std::string max_value = std::to_string(texture->max());
  if (texture->is_uniform()) throw props.error(name, range + "got " + max_value);
  props.warn(name, range + "but its texture has values up to " + max_value +
                       ": they are clamped to that range");
  return std::make_shared<BoundedTexture>(std::move(texture), upper_bound);
}

}  // namespace kinome
