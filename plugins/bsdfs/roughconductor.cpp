#include "conductor_index.h"
#include "kinome/block_points.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"
#include "roughness.h"

/// Rough metal after Walter et al. 2007, as in Mitsuba 3:
///
///     f cos(theta_o) = specular_reflectance F(wi . h) D(h) G(wi, wo) / (4 cos(theta_i))
///
/// with the Beckmann or the GGX distribution, anisotropic if alpha_u and alpha_v differ.
///
///     <bsdf type="roughconductor">
///       <string name="material" value="Cu"/>
///       <string name="distribution" value="ggx"/>
///       <float name="alpha_u" value="0.05"/><float name="alpha_v" value="0.3"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_CONDUCTOR_PARAMETERS,
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1",
     "scale factor of the reflection"},
    KINOME_MICROFACET_PARAMETERS,
};

class RoughConductor final : public wide::FormulaBsdf<RoughConductor> {
 public:
  explicit RoughConductor(const Properties& props)
      : index_(props),
        specular_(reflectance_texture(props, "specular_reflectance")),
        alpha_u_(alpha_texture(props, "alpha_u", "alpha_v")),
        alpha_v_(alpha_texture(props, "alpha_v", "alpha_u")),
        type_(static_cast<MicrofacetType>(props.choice("distribution"))),
        sample_visible_(props.boolean("sample_visible")) {
    lobes_ = Lobe::kGlossy;
  }

  auto inputs() const { return std::tie(specular_, alpha_u_, alpha_v_, index_.eta(), index_.k()); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    with_microfacet_type(type_, [&](auto type) {
      fn([this](const VecOf<F>& wi, const RgbOf<F>& specular, const F& alpha_u, const F& alpha_v,
                const RgbOf<F>& eta, const RgbOf<F>& k) {
        return Lobes<F, decltype(type)::value>{
            {alpha_u, alpha_v, sample_visible_, wi},
            specular,
            ConductorIndex::bounded(eta),
            ConductorIndex::bounded(k)};
      });
    });
  }

  BsdfForm form_kind() const { return form_kind_at({}); }
  template <class F>
  wide::FormOf<F> form_of(const VecOf<F>& /*wi*/, const RgbOf<F>& specular, const F& alpha_u,
                          const F& alpha_v, const RgbOf<F>& /*eta*/, const RgbOf<F>& /*k*/) const {
    return {RgbOf<F>(0.f), specular, max(alpha_u, F(kMinAlpha)), max(alpha_v, F(kMinAlpha))};
  }
  void describe_block(const SurfaceBlock& points, const BsdfFormBlock& out) const override {
    if (index_.eta()->is_uniform() && index_.k()->is_uniform()) {
      return FormulaBsdf::describe_block(points, out);
    }
    // If the index varies over the surface, each point has a kind of its own.
    store_forms(points, out);
    for (size_t i = 0; i < points.count; ++i) {
      out.kind[i] = out.kinds->number_of(form_kind_at(interaction_of(points, i)));
      if (out.kind[i] == BsdfFormKinds::kNone) describe_by_colours(points, i, out);
    }
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // An estimate without shadowing and masking.
    const float cos_i = std::clamp(si.wi.z, 0.f, 1.f);
    return {Rgb(0.f),
            specular_.at(si) * fresnel_conductor(
                                   cos_i, ConductorIndex::bounded(index_.eta().at(si)),
                                   ConductorIndex::bounded(index_.k().at(si)))};
  }

 private:
  template <class F, MicrofacetType kType>
  struct Lobes {
    RoughReflection<kType, F> reflection;
    RgbOf<F> specular, eta, k;

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const auto v = reflection(wo);
      return {specular * fresnel_conductor(v.cos_half, eta, k) * v.dg, v.pdf};
    }
    BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& u2) const {
      return weighted_sample<F>(*this, reflection.sample(u2), lobe_number(Lobe::kGlossy));
    }
  };

  BsdfForm form_kind_at(const SurfaceInteraction& si) const {
    BsdfForm form;
    form.glossy = glossy_form(type_);
    form.is_conductor = true;
    form.eta = ConductorIndex::bounded(index_.eta().at(si));
    form.k = ConductorIndex::bounded(index_.k().at(si));
    return form;
  }

  ConductorIndex index_;
  ColorInput specular_;
  NumberInput alpha_u_;
  NumberInput alpha_v_;
  MicrofacetType type_;
  bool sample_visible_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughConductor, kinome::Category::kBsdf, "roughconductor",
              "Rough metal: microfacets with the Beckmann or GGX distribution.",
              kinome::kParameters);
