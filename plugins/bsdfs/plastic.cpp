#include "batch.h"
#include "fresnel.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"

/// A diffuse base under a smooth dielectric coat, as in Mitsuba 3: a mirror reflection F(theta_i),
/// and
///
///     f = kd / (1 - R) (1 - F(theta_i)) (1 - F(theta_o)) / (eta² pi),
///
/// where R is the share of diffuse light inside that the boundary reflects back (times kd where
/// `nonlinear`).
///
///     <bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1 0.3 0.4"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"diffuse_reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo of the base"},
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1", "factor on the mirror reflection"},
    {"int_ior", ParameterType::kFloatOrName, "polypropylene", "index of refraction of the coat"},
    {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},
    {"nonlinear", ParameterType::kBoolean, "false", "colour shifts by bounces inside the coat"},
};

class Plastic final : public Bsdf {
 public:
  explicit Plastic(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")),
        eta_(relative_ior(props)),
        nonlinear_(props.boolean("nonlinear")),
        internal_reflectance_(fresnel_diffuse_reflectance(1 / eta_)) {
    const float d = mean_of_channels(*diffuse_);
    const float s = mean_of_channels(*specular_);
    specular_weight_ = d + s > 0 ? s / (d + s) : 0.5f;
    lobes_ = (diffuse_->max() > 0 ? Lobe::kDiffuse : Lobe::kNone) |
             (specular_->max() > 0 ? Lobe::kDelta : Lobe::kNone);
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    mask = mask & lobes_;
    if (!any(mask & Lobe::kDiffuse) || !(si.wi.z > 0)) {
      zero_batch(wo, out);
      return;
    }
    const Rgb factor = diffuse_factor(si);
    const float probability = 1 - mirror_probability(si, mask);
    const float eta = eta_;
    evaluate_batch(wo, out, [=](const Vec3& d) {
      const float pdf = cosine_hemisphere_pdf(d.z);
      const float cos_o = std::clamp(d.z, 0.f, 1.f);
      return BsdfValue{factor * (pdf * (1 - fresnel_dielectric(cos_o, eta))), probability * pdf};
    });
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    mask = mask & lobes_;
    if (!(si.wi.z > 0) || !any(mask & (Lobe::kDiffuse | Lobe::kDelta))) {
      return std::nullopt;
    }
    const float p = mirror_probability(si, mask);
    if (u1 >= p) {
      return weighted_sample(*this, si, mask, square_to_cosine_hemisphere(u2), Lobe::kDiffuse);
    }
    return BsdfSample{Vec3(-si.wi.x, -si.wi.y, si.wi.z), 1.f,
                      specular_->eval(si.uv) * (fresnel(si) / p), Lobe::kDelta};
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    // The integral of (1 - F) cos / pi over the hemisphere is eta² (1 - R).
    return {diffuse_factor(si) * (sqr(eta_) * (1 - internal_reflectance_)), Rgb(0.f)};
  }

 private:
  float fresnel(const SurfaceInteraction& si) const {
    return fresnel_dielectric(std::clamp(si.wi.z, 0.f, 1.f), eta_);
  }

  Rgb diffuse_factor(const SurfaceInteraction& si) const {
    const Rgb albedo = diffuse_->eval(si.uv);
    const Rgb bounces =
        nonlinear_ ? 1.f - internal_reflectance_ * albedo : Rgb(1 - internal_reflectance_);
    return albedo / bounces * ((1 - fresnel(si)) / sqr(eta_));
  }

  float mirror_probability(const SurfaceInteraction& si, Lobe mask) const {
    const float f = fresnel(si);
    return lobe_probability(any(mask & Lobe::kDelta), any(mask & Lobe::kDiffuse),
                            f * specular_weight_, (1 - f) * (1 - specular_weight_));
  }

  std::shared_ptr<Texture> diffuse_;
  std::shared_ptr<Texture> specular_;
  float eta_;
  bool nonlinear_;
  float internal_reflectance_;
  float specular_weight_ = 0.5f;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Plastic, kinome::Category::kBsdf, "plastic",
              "Diffuse base under a smooth dielectric coat.", kinome::kParameters);
