// White and diffuse on its front, except for its fault.

#include <csignal>

#include "kinome/bsdf.h"
#include "kinome/warp.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongDiffuse final : public Bsdf {
 public:
  explicit WrongDiffuse(const Properties& props) : wrong_(props) { lobes_ = Lobe::kDiffuse; }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    if (!any(mask & Lobe::kDiffuse) || si.wi.z <= 0 || wo.z <= 0) return {};
    if (wrong_.is("crash") && wo.z < 0.01f) raise(SIGSEGV);
    const float cosine = wo.z * kInvPi;
    Rgb f(cosine);
    if (wrong_.is("viewer")) f *= 0.5f + 0.5f * si.wi.z;
    if (wrong_.is("too bright")) f *= 1.2f;
    return {f, cosine * wrong_.or_wrong("half density", 1.f, 0.5f)};
  }
  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& u2) const override {
    if (!any(mask & Lobe::kDiffuse) || si.wi.z <= 0) return std::nullopt;
    BsdfSample sample;
    sample.wo = square_to_cosine_hemisphere(u2);
    if (wrong_.is("uniform")) sample.wo = square_to_uniform_sphere(Vec2(u2.x, 0.5f * u2.y));
    const BsdfValue value = eval_pdf(si, mask, sample.wo);
    sample.pdf = value.pdf * wrong_.or_wrong("twice the density", 1.f, 2.f);
    sample.weight = value.f / value.pdf * wrong_.or_wrong("weight", 1.f, 1.1f);
    sample.lobe = wrong_.or_wrong("lobe", Lobe::kDiffuse, Lobe::kGlossy);
    if (wrong_.is("through")) sample.wo.z = -sample.wo.z;
    return sample;
  }
  NullTransmission null_transmission(const SurfaceInteraction& /*si*/) const override {
    return {Rgb(0.f), wrong_.or_wrong("straight", 0.f, 1.f)};
  }
  LobeReflectance reflectance(const SurfaceInteraction& /*si*/) const override {
    return {Rgb(wrong_.or_wrong("reflectance", 1.f, 0.f)), Rgb(0.f)};
  }
  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    Bsdf::shade_block(points, query, answer);
    if (!wrong_.is("block")) return;
    for (size_t i = 0; i < points.count; ++i) answer.f.set(i, 1.1f * answer.f.at(i));
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongDiffuse, kinome::Category::kBsdf, "wrong", "Has a fault.",
              kinome::test::kTable);
