// A BSDF with a fault, for tests of the program's reaction.

#include <cmath>
#include <new>
#include <vector>

#include "faulty.h"
#include "kinome/bsdf.h"
#include "kinome/warp.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_FAULT_PARAMETER};

/// White and diffuse, except for its fault.
class FaultyBsdf final : public Bsdf {
 public:
  explicit FaultyBsdf(const Properties& props) : fault_(props) { lobes_ = Lobe::kDiffuse; }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    fault_.throw_if("eval", "evaluate");
    fault_.crash_if("in eval");
    if (fault_.is("no exception")) throw 42;
    if (fault_.is("memory")) throw std::bad_alloc();
    if (fault_.is("range")) static_cast<void>(std::vector<int>().at(1));
    const bool is_lit = any(mask & Lobe::kDiffuse) && si.wi.z > 0 && wo.z > 0;
    const float f = is_lit ? wo.z * kInvPi : 0.f;
    return {Rgb(is_lit && fault_.is("nan") ? kNan : f),
            fault_.is("negative pdf") ? -f : fault_.is("no pdf") ? 0 : f};
  }
  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& u2) const override {
    if (!any(mask & Lobe::kDiffuse) || si.wi.z <= 0) return std::nullopt;
    BsdfSample sample;
    sample.wo = square_to_cosine_hemisphere(u2);
    sample.pdf = cosine_hemisphere_pdf(sample.wo.z) * (fault_.is("negative pdf") ? -1.f : 1.f);
    sample.weight = Rgb(fault_.is("nan") ? kNan : 1.f);
    if (fault_.is("pdf")) sample.pdf *= 1.02f;
    if (fault_.is("weight")) sample.weight *= 1.02f;
    if (fault_.is("length")) sample.wo *= 1.01f;
    if (fault_.is("half")) sample.wo.x = std::abs(sample.wo.x);
    sample.lobe = Lobe::kDiffuse;
    return sample;
  }
  LobeReflectance reflectance(const SurfaceInteraction& /*si*/) const override {
    return {Rgb(1.f), Rgb(0.f)};
  }

 private:
  Fault fault_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyBsdf, kinome::Category::kBsdf, "faulty", "Has a fault.",
              kinome::test::kTable);
