// Schlick's phase function (1993), similar to that of Henyey and Greenstein without the power of
// 3/2:
//
//     p = (1 - k²) / (4 pi (1 - k cos)²)
//
//     <phase type="schlick"> <float name="k" value="0.6"/> </phase>

#include <cmath>

#include <kinome/phase.h>
#include <kinome/plugin.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"k", ParameterType::kFloat, "0.6", "From -0.99 to 0.99; positive values scatter forward."},
};

class Schlick final : public Phase {
 public:
  explicit Schlick(const Properties& props)
      : k_(props.real("k", "must be from -0.99 to 0.99",
                      [](float k) { return std::abs(k) <= 0.99f; })) {}

  // The cosine of the deflection is -wo.z, because wo points away from the point.
  float eval(const MediumPoint& /*point*/, const Vec3& wo) const override {
    return (1 - k_ * k_) * 0.25f * kInvPi / sqr(1 + k_ * wo.z);
  }
  PhaseSample sample(const MediumPoint& point, float /*u1*/, const Vec2& u2) const override {
    const float u = 2 * u2.x - 1;
    const float cosine = (u + k_) / (1 + k_ * u);
    const float sine = safe_sqrt((1 - cosine) * (1 + cosine));
    const float azimuth = 2 * kPi * u2.y;
    const Vec3 wo(sine * std::cos(azimuth), sine * std::sin(azimuth), -cosine);
    return {wo, eval(point, wo)};
  }
  // A guess is enough: it only guides the search for light.
  std::array<HgLobe, 2> lobes() const override { return {HgLobe{0.65f * k_, 1}, HgLobe{0, 0}}; }

 private:
  float k_;
};

}  // namespace

KINOME_PLUGIN(Schlick, Category::kPhase, "schlick", "Schlick's phase function.", kParameters);
