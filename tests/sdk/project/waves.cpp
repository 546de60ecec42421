#include "kinome/plugin.h"
#include "kinome/texture.h"
#include "kinome/wide/functions.h"

/// Waves along u, built for several instruction sets. Its formula is written once, for a point and
/// for as many as a vector holds.
namespace {

using namespace kinome;
using namespace kinome::wide::formulas;

constexpr Parameter kParameters[] = {
    {"waves", ParameterType::kFloat, "4", "How many there are from u = 0 to 1."},
};

template <class F>
F wave(F u, float waves) {
  return mul_add(F(0.4f), cos(2 * kPi * waves * u), F(0.5f));
}

class Waves final : public Texture {
 public:
  explicit Waves(const Properties& props) : waves_(props.real("waves")) {
    // What a vector's lanes hold is what points do.
    float u[wide::kLanes], values[wide::kLanes];
    for (size_t i = 0; i < wide::kLanes; ++i) u[i] = static_cast<float>(i) / kBlockLanes;
    wave(wide::Float::load(u), waves_).store(values);
    for (size_t i = 0; i < wide::kLanes; ++i) {
      if (!(std::abs(values[i] - wave(u[i], waves_)) < 1e-6f * (1 + waves_))) {
        throw props.error("waves", "lane " + std::to_string(i) + " differs");
      }
    }
  }
  Rgb eval(const Vec2& uv) const override { return Rgb(wave(uv.x, waves_)); }
  Rgb mean() const override { return Rgb(0.5f); }
  float max() const override { return 0.9f; }
  float min() const override { return 0.1f; }

 private:
  float waves_;
};

}  // namespace

KINOME_PLUGIN(Waves, Category::kTexture, "waves", "Waves, built for " KINOME_ABI_ISA ".",
              kParameters);
