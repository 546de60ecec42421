// Isotropic scattering, except for its fault.

#include "kinome/phase.h"
#include "kinome/warp.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongIsotropic final : public Phase {
 public:
  explicit WrongIsotropic(const Properties& props) : wrong_(props) {}

  float eval(const MediumPoint&, const Vec3&) const override {
    return kUniformSpherePdf * wrong_.or_wrong("half", 1.f, 0.5f);
  }
  PhaseSample sample(const MediumPoint& point, float, const Vec2& u2) const override {
    Vec3 wo = square_to_uniform_sphere(u2);
    if (wrong_.is("forward")) wo.z = -std::abs(wo.z);
    return {wo, eval(point, wo) * wrong_.or_wrong("density", 1.f, 2.f)};
  }
  void eval_block(const MediumPointBlock& points, const Columns3& wo, float* value) const override {
    Phase::eval_block(points, wo, value);
    for (size_t i = 0; wrong_.is("block") && i < points.count; ++i) value[i] *= 1.1f;
  }
  std::array<HgLobe, 2> lobes() const override {
    return {HgLobe{0, wrong_.or_wrong("lobes", 1.f, 0.5f)}, HgLobe{0, 0}};
  }
  float projected_area(const Vec3&, const Vec3&) const override {
    return wrong_.or_wrong("area", 1.f, 0.9f);
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongIsotropic, kinome::Category::kPhase, "wrong", "Has a fault.",
              kinome::test::kTable);
