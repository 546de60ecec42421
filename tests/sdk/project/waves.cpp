// Waves along u, computed for a whole vector at a time. The formula is written once, for one point
// and for a vector of points.
//
//     <texture type="waves"> <float name="waves" value="4"/> </texture>

#include <kinome/plugin.h>
#include <kinome/texture.h>
#include <kinome/wide/functions.h>
#include <kinome/wide/vectors.h>

namespace {

using namespace kinome;
using namespace kinome::wide::formulas;

constexpr Parameter kParameters[] = {
    {"waves", ParameterType::kFloat, "4", "Number of waves from u = 0 to 1."},
};

class Waves final : public Texture {
 public:
  explicit Waves(const Properties& props) : waves_(props.real("waves")) {}

  Rgb eval(const Vec2& uv) const override { return Rgb(wave(uv.x)); }
  void eval_block(const Columns2& uv, size_t count, const Columns3& out) const override {
    wide::for_lanes(count,
                    [&](size_t i) { wide::Rgb(wave(wide::Float::load(uv.x + i))).store(out, i); });
  }
  void eval_1_block(const Columns2& uv, size_t count, float* out) const override {
    wide::for_lanes(count, [&](size_t i) { wave(wide::Float::load(uv.x + i)).store(out + i); });
  }
  Rgb mean() const override { return Rgb(0.5f); }
  float max() const override { return 0.9f; }
  float min() const override { return 0.1f; }

 private:
  template <class F>
  F wave(F u) const {
    return mul_add(F(0.4f), cos(2 * kPi * waves_ * u), F(0.5f));
  }

  float waves_;
};

}  // namespace

KINOME_PLUGIN(Waves, Category::kTexture, "waves", "Waves, built for " KINOME_ABI_ISA ".",
              kParameters);
