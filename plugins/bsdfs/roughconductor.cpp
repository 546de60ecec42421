#include "conductor_index.h"
#include "fresnel.h"
#include "kinome/plugin.h"
#include "microfacet.h"

/// Rough metal after Walter et al. 2007, as in Mitsuba 3:
///
///     f cos(theta_o) = specular_reflectance F(wi . h) D(h) G(wi, wo) / (4 cos(theta_i))
///
/// with Beckmann's or the GGX distribution of slopes, anisotropic where alpha_u and alpha_v differ.
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
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1", "factor on the reflection"},
    {"distribution", ParameterType::kString, "beckmann", "of microfacet slopes: beckmann or ggx"},
    {"alpha", ParameterType::kUnitlessTexture, "0.1",
     "roughness, root mean square of the slopes; at least 1e-4 is used"},
    {"alpha_u", ParameterType::kUnitlessTexture, nullptr, "along dp_du, together with alpha_v"},
    {"alpha_v", ParameterType::kUnitlessTexture, nullptr, "along dp_dv, together with alpha_u"},
    {"sample_visible", ParameterType::kBoolean, "true", "sample visible normals only"},
};

class RoughConductor final : public Bsdf {
 public:
  explicit RoughConductor(const Properties& props)
      : index_(props),
        specular_(reflectance_texture(props, "specular_reflectance")),
        type_(static_cast<MicrofacetType>(props.choice("distribution", kMicrofacetTypes))),
        sample_visible_(props.boolean("sample_visible")) {
    lobes_ = Lobe::kGlossy;
    if (!props.has("alpha_u") && !props.has("alpha_v")) {
      alpha_u_ = alpha_v_ = nonnegative_texture(props, "alpha");
      return;
    }
    if (props.has("alpha")) {
      throw props.error("alpha", "excludes alpha_u and alpha_v: give either, not both");
    }
    for (const char* name : {"alpha_u", "alpha_v"}) {
      if (!props.has(name)) {
        throw props.error(name, "is missing: alpha_u and alpha_v come together");
      }
    }
    alpha_u_ = nonnegative_texture(props, "alpha_u");
    alpha_v_ = nonnegative_texture(props, "alpha_v");
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    if (!any(mask & Lobe::kGlossy) || !(si.wi.z > 0)) {
      zero_batch(wo, out);
      return;
    }
    const Rgb eta = index_.eta(si.uv);
    const Rgb k = index_.k(si.uv);
    const Rgb specular = specular_->eval(si.uv);
    with_reflection(si, [&](const auto& reflection) {
      evaluate_batch(wo, out, [=](const Vec3& d) {
        const auto v = reflection(d);
        return BsdfValue{specular * fresnel_conductor(v.cos_half, eta, k) * v.dg, v.pdf};
      });
    });
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& u2) const override {
    if (!any(mask & Lobe::kGlossy) || !(si.wi.z > 0)) {
      return std::nullopt;
    }
    Vec3 wo;
    with_reflection(si, [&](const auto& reflection) { wo = reflection.sample(u2); });
    return weighted_sample(*this, si, mask, wo, Lobe::kGlossy);
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    BsdfForm form;
    form.glossy = glossy_form(type_);
    form.specular = specular_->eval(si.uv);
    form.alpha_u = std::max(alpha_u_->eval_1(si.uv), kMinAlpha);
    form.alpha_v =
        alpha_u_ == alpha_v_ ? form.alpha_u : std::max(alpha_v_->eval_1(si.uv), kMinAlpha);
    form.is_conductor = true;
    form.eta = index_.eta(si.uv);
    form.k = index_.k(si.uv);
    return form;
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // Shadowing is left out: an estimate.
    const float cos_i = std::clamp(si.wi.z, 0.f, 1.f);
    return {Rgb(0.f),
            specular_->eval(si.uv) * fresnel_conductor(cos_i, index_.eta(si.uv), index_.k(si.uv))};
  }

 private:
  template <class F>
  void with_reflection(const SurfaceInteraction& si, const F& f) const {
    const float au = alpha_u_->eval_1(si.uv);
    const float av = alpha_u_ == alpha_v_ ? au : alpha_v_->eval_1(si.uv);
    with_microfacet_type(type_, [&](auto type) {
      f(RoughReflection<decltype(type)::value>(au, av, sample_visible_, si.wi));
    });
  }

  ConductorIndex index_;
  std::shared_ptr<Texture> specular_;
  std::shared_ptr<Texture> alpha_u_;
  std::shared_ptr<Texture> alpha_v_;
  MicrofacetType type_;
  bool sample_visible_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughConductor, kinome::Category::kBsdf, "roughconductor",
              "Rough metal: microfacets with Beckmann's or the GGX distribution.",
              kinome::kParameters);
