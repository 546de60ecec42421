// A ramp along u, except for its fault.

#include <algorithm>
#include <cmath>

#include "kinome/texture.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
    {"gain", ParameterType::kFloat, "1", "Factor of the values."},
    {"dims", ParameterType::kBoolean, "false", "Whether `dimming` has an effect."},
    {"dimming", ParameterType::kFloat, "0", "Share of the values that is lost; read beside `dims`."},
    ignored_row("depth", ParameterType::kInteger, "a ramp has no depth"),
};

class WrongRamp final : public Texture {
 public:
  explicit WrongRamp(const Properties& props) : wrong_(props) {
    if (!wrong_.is("unread")) gain_ = props.real("gain");
    if (props.boolean("dims")) gain_ *= 1 - props.real("dimming");
  }

  Rgb eval(const Vec2& uv) const override { return Rgb(gain_ * (uv.x - std::floor(uv.x))); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    Texture::eval_block(uv, count, out);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) out.y[i] *= 0.9f;
  }
  void eval_1_block_at(const SurfaceBlock& points, float* out) const override {
    Texture::eval_1_block_at(points, out);
    for (size_t i = 0; wrong_.is("block of points") && i < points.count; ++i) out[i] *= 0.9f;
  }
  Rgb mean() const override { return Rgb(gain_ * wrong_.or_wrong("mean", 0.5f, 0.6f)); }
  float max() const override {
    return std::max(0.f, gain_) * wrong_.or_wrong("max", 1.f, 0.7f);
  }
  float min() const override { return std::min(0.f, gain_); }
  bool is_uniform() const override { return wrong_.is("uniform"); }

 private:
  Wrong wrong_;
  float gain_ = 1;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongRamp, kinome::Category::kTexture, "wrong", "Has a fault.",
              kinome::test::kTable);
