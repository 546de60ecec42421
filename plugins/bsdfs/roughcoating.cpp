#include "coat.h"
#include "kinome/plugin.h"
#include "rough_transmittance.h"

/// A rough dielectric coat over another BSDF, as in Mitsuba 0.6; see coat.h. Directions inside the
/// coat are refracted as by a smooth boundary.
///
///     <bsdf type="roughcoating">
///       <float name="alpha" value="0.05"/>
///       <bsdf type="diffuse"><rgb name="reflectance" value="0.5 0.1 0.1"/></bsdf>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    choice_of("distribution", kMicrofacetTypes, "beckmann",
              "distribution of microfacet normals: beckmann or ggx"),
    {"alpha", ParameterType::kFloat, "0.1", "roughness; values below 1e-4 are raised to it"},
    {"sample_visible", ParameterType::kBoolean, "true", "sample visible normals only"},
    KINOME_COAT_PARAMETERS,
};

/// Boundary that reflects at microfacets.
class RoughCoatBoundary {
 public:
  RoughCoatBoundary(const Properties& props, float eta)
      : eta_(eta),
        type_(static_cast<MicrofacetType>(props.choice("distribution"))),
        alpha_(roughness_number(props, "alpha")),
        sample_visible_(props.boolean("sample_visible")),
        transmittance_(type_, alpha_, eta) {}

  float transmittance(float cosine) const { return transmittance_.external(cosine); }
  Lobe lobe() const { return Lobe::kGlossy; }

  BsdfValue value(const Vec3& wi, const Vec3& wo) const {
    BsdfValue value;
    with_reflection(wi, [&](const auto& reflection) {
      const auto v = reflection(wo);
      value = {Rgb(fresnel_dielectric(v.cos_half, eta_) * v.dg), v.pdf};
    });
    return value;
  }
  std::optional<BsdfSample> sample(const Vec3& wi, const Vec2& u) const {
    BsdfSample sample;
    sample.lobe = Lobe::kGlossy;
    with_reflection(wi, [&](const auto& reflection) { sample.wo = reflection.sample(u); });
    if (!(sample.wo.z > 0)) return std::nullopt;
    return sample;
  }

 private:
  template <class Fn>
  void with_reflection(const Vec3& wi, const Fn& fn) const {
    with_microfacet_type(type_, [&](auto type) {
      fn(RoughReflection<decltype(type)::value, float>(alpha_, alpha_, sample_visible_, wi));
    });
  }

  float eta_;
  MicrofacetType type_;
  float alpha_;
  bool sample_visible_;
  RoughTransmittance transmittance_;
};

class RoughCoating final : public Coat<RoughCoatBoundary> {
 public:
  explicit RoughCoating(const Properties& props) : RoughCoating(props, relative_ior(props)) {}

 private:
  RoughCoating(const Properties& props, float eta)
      : Coat(props, eta, RoughCoatBoundary(props, eta)) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughCoating, kinome::Category::kBsdf, "roughcoating",
              "A rough dielectric coat over another BSDF, as in Mitsuba 0.6.", kinome::kParameters);
