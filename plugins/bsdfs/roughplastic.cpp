#include "batch.h"
#include "dielectric_index.h"
#include "kinome/plugin.h"
#include "rough_transmittance.h"

/// A diffuse base under a rough dielectric coat, as in Mitsuba 3:
///
///     f cos(theta_o) = ks F(wi . h) D(h) G(wi, wo) / (4 cos(theta_i))
///                    + kd / (1 - R) T(wi) T(wo) / eta² cos(theta_o) / pi
///
/// T is the fraction of light that passes the rough boundary from outside, R the fraction of
/// diffuse light inside that is reflected back. With `nonlinear`, R is multiplied by kd: each
/// internal reflection colours the light.
///
///     <bsdf type="roughplastic">
///       <string name="distribution" value="ggx"/><float name="alpha" value="0.15"/>
///       <rgb name="diffuse_reflectance" value="0.7 0.1 0.05"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"diffuse_reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo of the base"},
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1",
     "scale factor of the coat's reflection"},
    {"int_ior", ParameterType::kFloatOrName, "polypropylene", "index of refraction of the coat"},
    {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},
    choice_of("distribution", kMicrofacetTypes, "beckmann",
              "distribution of microfacet normals: beckmann or ggx"),
    {"alpha", ParameterType::kFloat, "0.1", "roughness; values below 1e-4 are raised to it"},
    {"sample_visible", ParameterType::kBoolean, "true", "sample visible normals only"},
    {"nonlinear", ParameterType::kBoolean, "false",
     "include colour shifts due to internal reflections"},
};

class RoughPlastic final : public wide::FormulaBsdf<RoughPlastic> {
 public:
  explicit RoughPlastic(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")),
        eta_(relative_ior(props)),
        type_(static_cast<MicrofacetType>(props.choice("distribution"))),
        alpha_(roughness_number(props, "alpha")),
        sample_visible_(props.boolean("sample_visible")),
        nonlinear_(props.boolean("nonlinear")),
        transmittance_(type_, alpha_, eta_) {
    specular_weight_ = specular_share(mean_of_channels(*diffuse_), mean_of_channels(*specular_));
    lobes_ = (diffuse_->max() > 0 ? Lobe::kDiffuse : Lobe::kNone) |
             (specular_->max() > 0 ? Lobe::kGlossy : Lobe::kNone);
  }

  auto inputs() const { return std::tie(diffuse_, specular_); }
  template <class F, class Fn>
  void with_lobes(Lobe mask, const Fn& fn) const {
    with_microfacet_type(type_, [&](auto type) {
      fn([this, mask](const VecOf<F>& wi, const RgbOf<F>& albedo, const RgbOf<F>& specular) {
        return Lobes<F, decltype(type)::value>(*this, mask, wi, albedo, specular);
      });
    });
  }

  BsdfForm form_kind() const {
    BsdfForm form;
    form.transmittance = transmittance_.table().data();
    if (any(lobes_ & Lobe::kGlossy)) {
      form.glossy = glossy_form(type_);
      form.eta = Rgb(eta_);
    }
    return form;
  }
  template <class F>
  wide::FormOf<F> form_of(const VecOf<F>& wi, const RgbOf<F>& albedo,
                          const RgbOf<F>& specular) const {
    const RgbOf<F> diffuse =
        any(lobes_ & Lobe::kDiffuse) ? diffuse_factor(wi.z, albedo) : RgbOf<F>(0.f);
    if (!any(lobes_ & Lobe::kGlossy)) return {diffuse, RgbOf<F>(0.f), 1.f, 1.f};
    const float alpha = std::max(alpha_, kMinAlpha);
    return {diffuse, specular, alpha, alpha};
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return diffuse_.at(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const float t = transmittance_.external(std::max(si.wi.z, 0.f));
    // The integral of T(wo) cos / pi is eta² (1 - R) for a smooth boundary.
    const Rgb inside = diffuse_.at(si);
    return {inside * t * (1 - transmittance_.internal_reflectance()) / bounces(inside),
            specular_.at(si) * (1 - t)};
  }

 private:
  template <class F, MicrofacetType kType>
  class Lobes {
   public:
    Lobes(const RoughPlastic& bsdf, Lobe mask, const VecOf<F>& wi, const RgbOf<F>& albedo,
          const RgbOf<F>& specular)
        : bsdf_(bsdf),
          has_glossy_(any(mask & Lobe::kGlossy)),
          specular_(specular),
          reflection_(bsdf.alpha_, bsdf.alpha_, bsdf.sample_visible_, wi) {
      const bool has_diffuse = any(mask & Lobe::kDiffuse);
      glossy_probability_ = bsdf.glossy_probability(wi.z, has_glossy_, has_diffuse);
      diffuse_ = has_diffuse ? bsdf.diffuse_factor(wi.z, albedo) : RgbOf<F>(0.f);
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F cosine_pdf = warp::cosine_hemisphere_pdf(wo.z);
      BsdfValueOf<F> value{
          diffuse_ * (cosine_pdf * bsdf_.transmittance_.external(max(wo.z, F(0.f)))),
          (1.f - glossy_probability_) * cosine_pdf};
      if (has_glossy_) {
        const auto v = reflection_(wo);
        value.f += specular_ * (fresnel_dielectric(v.cos_half, bsdf_.eta_) * v.dg);
        value.pdf += glossy_probability_ * v.pdf;
      }
      return value;
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      const auto is_glossy = u1 < glossy_probability_;
      const VecOf<F> wo = choose(
          is_glossy, [&] { return reflection_.sample(u2); },
          [&] { return warp::square_to_cosine_hemisphere<VecOf<F>>(u2); });
      return weighted_sample<F>(*this, wo,
                                select(is_glossy, IntOf<F>(lobe_number(Lobe::kGlossy)),
                                       IntOf<F>(lobe_number(Lobe::kDiffuse))));
    }

   private:
    const RoughPlastic& bsdf_;
    bool has_glossy_;
    RgbOf<F> specular_, diffuse_;
    F glossy_probability_;
    RoughReflection<kType, F> reflection_;
  };

  /// 1 - R, the denominator of the geometric series of internal reflections.
  template <class V>
  V bounces(const V& albedo) const {
    const float r = transmittance_.internal_reflectance();
    return nonlinear_ ? V(1.f) - r * albedo : V(1.f - r);
  }

  template <class F, class V>
  V diffuse_factor(const F& cos_i, const V& albedo) const {
    return albedo / bounces(albedo) * (transmittance_.external(cos_i) / (eta_ * eta_));
  }

  template <class F>
  F glossy_probability(const F& cos_i, bool has_glossy, bool has_diffuse) const {
    const F t = transmittance_.external(cos_i);
    return lobe_probability<F>(has_glossy, has_diffuse, (1.f - t) * specular_weight_,
                               t * (1.f - specular_weight_));
  }

  ColorInput diffuse_;
  ColorInput specular_;
  float eta_;
  MicrofacetType type_;
  float alpha_;
  bool sample_visible_;
  bool nonlinear_;
  RoughTransmittance transmittance_;
  float specular_weight_ = 0.5f;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughPlastic, kinome::Category::kBsdf, "roughplastic",
              "Diffuse base under a rough dielectric coat.", kinome::kParameters);
