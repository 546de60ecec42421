#include "kinome/texture.h"

#include <algorithm>

namespace kinome {
namespace {

class UniformTexture final : public Texture {
 public:
  explicit UniformTexture(const Rgb& value) : value_(value) {}
  Rgb eval(const Vec2&) const override { return value_; }
  /// Returns a grey value exactly; its luminance would have rounding errors.
  float eval_1(const Vec2&) const override { return min() == max() ? value_.x : luminance(value_); }
  void eval_block(const Columns2&, size_t count, const Columns3& out) const override {
    std::fill_n(out.x, count, value_.x);
    std::fill_n(out.y, count, value_.y);
    std::fill_n(out.z, count, value_.z);
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    std::fill_n(out, count, eval_1(uv.at(0)));
  }
  Vec2 eval_1_gradient(const Vec2&) const override { return Vec2(0); }
  Rgb mean() const override { return value_; }
  float max() const override { return max_component(value_); }
  float min() const override { return -max_component(-value_); }
  bool is_uniform() const override { return true; }

 private:
  Rgb value_;
};

}  // namespace

Vec2 Texture::eval_1_gradient(const Vec2& uv) const {
  constexpr float kHalf = 5e-4f;
  const auto slope = [&](const Vec2& step) {
    return (eval_1(uv + step) - eval_1(uv - step)) / (2 * kHalf);
  };
  return {slope({kHalf, 0}), slope({0, kHalf})};
}

std::shared_ptr<Texture> make_uniform_texture(const Rgb& value) {
  return std::make_shared<UniformTexture>(value);
}

}  // namespace kinome
