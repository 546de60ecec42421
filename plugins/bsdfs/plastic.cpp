#include "batch.h"
#include "dielectric_index.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"

/// A diffuse base under a smooth dielectric coat, as in Mitsuba 3: a mirror reflection F(theta_i),
/// and
///
///     f = kd / (1 - R) (1 - F(theta_i)) (1 - F(theta_o)) / (eta² pi),
///
/// where R is the fraction of diffuse light inside that the boundary reflects back. With
/// `nonlinear`, R is multiplied by kd.
///
///     <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1 0.3 0.4"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"diffuse_reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo of the base"},
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1",
     "scale factor of the mirror reflection"},
    {"int_ior", ParameterType::kFloatOrName, "polypropylene", "index of refraction of the coat"},
    {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},
    {"nonlinear", ParameterType::kBoolean, "false",
     "include colour shifts due to internal reflections"},
};

class Plastic final : public wide::FormulaBsdf<Plastic> {
 public:
  explicit Plastic(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")),
        eta_(relative_ior(props)),
        nonlinear_(props.boolean("nonlinear")),
        internal_reflectance_(fresnel_diffuse_reflectance(1 / eta_)) {
    specular_weight_ = specular_share(mean_of_channels(*diffuse_), mean_of_channels(*specular_));
    lobes_ = (diffuse_->max() > 0 ? Lobe::kDiffuse : Lobe::kNone) |
             (specular_->max() > 0 ? Lobe::kDelta : Lobe::kNone);
  }

  auto inputs() const { return std::tie(diffuse_, specular_); }
  template <class F, class Fn>
  void with_lobes(Lobe mask, const Fn& fn) const {
    fn([this, mask](const VecOf<F>& wi, const RgbOf<F>& albedo, const RgbOf<F>& specular) {
      return Lobes<F>(*this, mask, wi, albedo, specular);
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return diffuse_.at(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // The integral of (1 - F) cos / pi over the hemisphere is eta² (1 - R).
    const float f = fresnel_dielectric(std::clamp(si.wi.z, 0.f, 1.f), eta_);
    return {diffuse_factor(f, diffuse_.at(si)) * (sqr(eta_) * (1 - internal_reflectance_)),
            Rgb(0.f)};
  }

 private:
  template <class F>
  class Lobes {
   public:
    Lobes(const Plastic& bsdf, Lobe mask, const VecOf<F>& wi, const RgbOf<F>& albedo,
          const RgbOf<F>& specular)
        : bsdf_(bsdf), wi_(wi), specular_(specular) {
      const bool has_diffuse = any(mask & Lobe::kDiffuse);
      fresnel_ = fresnel_dielectric(clamp(wi.z, F(0.f), F(1.f)), bsdf.eta_);
      diffuse_ = has_diffuse ? bsdf.diffuse_factor(fresnel_, albedo) : RgbOf<F>(0.f);
      mirror_probability_ = lobe_probability<F>(any(mask & Lobe::kDelta), has_diffuse,
                                                fresnel_ * bsdf.specular_weight_,
                                                (1.f - fresnel_) * (1.f - bsdf.specular_weight_));
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F pdf = warp::cosine_hemisphere_pdf(wo.z);
      const F cos_o = clamp(wo.z, F(0.f), F(1.f));
      return {diffuse_ * (pdf * (1.f - fresnel_dielectric(cos_o, bsdf_.eta_))),
              (1.f - mirror_probability_) * pdf};
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      return choose(
          u1 < mirror_probability_,
          [&] { return mirror_sample<F>(wi_, specular_ * (fresnel_ / mirror_probability_)); },
          [&] { return diffuse_sample<F>(*this, u2); });
    }

   private:
    const Plastic& bsdf_;
    VecOf<F> wi_;
    RgbOf<F> specular_, diffuse_;
    F fresnel_;  ///< of wi
    F mirror_probability_;
  };

  template <class F, class V>
  V diffuse_factor(const F& fresnel, const V& albedo) const {
    const V bounces =
        nonlinear_ ? V(1.f) - internal_reflectance_ * albedo : V(1.f - internal_reflectance_);
    return albedo / bounces * ((1.f - fresnel) / sqr(eta_));
  }

  ColorInput diffuse_;
  ColorInput specular_;
  float eta_;
  bool nonlinear_;
  float internal_reflectance_;
  float specular_weight_ = 0.5f;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Plastic, kinome::Category::kBsdf, "plastic",
              "Diffuse base under a smooth dielectric coat.", kinome::kParameters);
