// A ramp along u, but for its fault.

#include <cmath>

#include "kinome/texture.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongRamp final : public Texture {
 public:
  explicit WrongRamp(const Properties& props) : wrong_(props) {}

  Rgb eval(const Vec2& uv) const override { return Rgb(uv.x - std::floor(uv.x)); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    Texture::eval_block(uv, count, out);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) out.y[i] *= 0.9f;
  }
  Rgb mean() const override { return Rgb(wrong_.or_wrong("mean", 0.5f, 0.6f)); }
  float max() const override { return wrong_.or_wrong("max", 1.f, 0.7f); }
  float min() const override { return 0; }
  bool is_uniform() const override { return wrong_.is("uniform"); }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongRamp, kinome::Category::kTexture, "wrong", "Has a fault.",
              kinome::test::kTable);
