#pragma once

#include <memory>
#include <string>
#include <utility>

#include "kinome/texture.h"

namespace kinome {

/// Base class of textures that apply a function to each value of another texture. Default: the
/// identity.
class DerivedTexture : public Texture {
 public:
  explicit DerivedTexture(std::shared_ptr<const Texture> base) : base_(std::move(base)) {}

  Rgb eval(const Vec2& uv) const final { return map_color(base_->eval(uv)); }
  float eval_1(const Vec2& uv) const final { return map_number(base_->eval_1(uv)); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const final {
    base_->eval_block(uv, count, out);
    map_colors(count, out);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const final {
    base_->eval_1_block(uv, count, out);
    map_numbers(count, out);
  }
  Rgb eval_at(const SurfaceInteraction& si) const final { return map_color(base_->eval_at(si)); }
  float eval_1_at(const SurfaceInteraction& si) const final {
    return map_number(base_->eval_1_at(si));
  }
  void eval_block_at(const SurfaceBlock& points, const Columns3& out) const final {
    base_->eval_block_at(points, out);
    map_colors(points.count, out);
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const final {
    base_->eval_1_block_at(points, out);
    map_numbers(points.count, out);
  }
  std::string attribute() const final { return base_->attribute(); }
  Rgb mean() const final { return map_color(base_->mean()); }
  Rgb emission() const override { return map_color(base_->emission()); }
  float max() const override { return map_number(base_->max()); }
  float min() const override { return map_number(base_->min()); }
  Rgb channel_max() const final { return map_color(base_->channel_max()); }
  bool is_uniform() const final { return base_->is_uniform(); }
  glm::uvec2 resolution() const final { return base_->resolution(); }

 protected:
  const Texture& base() const { return *base_; }

 private:
  virtual Rgb map_color(const Rgb& color) const { return color; }
  virtual float map_number(float number) const { return number; }
  virtual void map_colors(size_t /*count*/, const Columns3& /*colors*/) const {}
  virtual void map_numbers(size_t /*count*/, float* /*numbers*/) const {}

  std::shared_ptr<const Texture> base_;
};

}  // namespace kinome
