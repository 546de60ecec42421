#include "batch.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"
#include "rough_transmittance.h"

/// A diffuse base under a rough dielectric coat, as in Mitsuba 3:
///
///     f cos(theta_o) = ks F(wi . h) D(h) G(wi, wo) / (4 cos(theta_i))
///                    + kd / (1 - R) T(wi) T(wo) / eta² cos(theta_o) / pi
///
/// T: share of light that passes the rough boundary from outside; R: of diffuse light inside the
/// share that is reflected back (times kd where `nonlinear`: light bounces inside and takes on
/// colour each time).
///
///     <bsdf type="roughplastic">
///       <string name="distribution" value="ggx"/><float name="alpha" value="0.15"/>
///       <rgb name="diffuse_reflectance" value="0.7 0.1 0.05"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"diffuse_reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo of the base"},
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1", "factor on the coat's reflection"},
    {"int_ior", ParameterType::kFloatOrName, "polypropylene", "index of refraction of the coat"},
    {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},
    {"distribution", ParameterType::kString, "beckmann", "of microfacet slopes: beckmann or ggx"},
    {"alpha", ParameterType::kFloat, "0.1", "roughness; at least 1e-4 is used"},
    {"sample_visible", ParameterType::kBoolean, "true", "sample visible normals only"},
    {"nonlinear", ParameterType::kBoolean, "false", "colour shifts by bounces inside the coat"},
};

class RoughPlastic final : public Bsdf {
 public:
  explicit RoughPlastic(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")),
        eta_(relative_ior(props)),
        type_(static_cast<MicrofacetType>(props.choice("distribution", kMicrofacetTypes))),
        alpha_(valid_alpha(props)),
        sample_visible_(props.boolean("sample_visible")),
        nonlinear_(props.boolean("nonlinear")),
        transmittance_(type_, alpha_, eta_) {
    const float d = mean_of_channels(*diffuse_);
    const float s = mean_of_channels(*specular_);
    specular_weight_ = d + s > 0 ? s / (d + s) : 0.5f;
    lobes_ = (diffuse_->max() > 0 ? Lobe::kDiffuse : Lobe::kNone) |
             (specular_->max() > 0 ? Lobe::kGlossy : Lobe::kNone);
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    mask = mask & lobes_;
    const bool has_diffuse = any(mask & Lobe::kDiffuse);
    const bool has_glossy = any(mask & Lobe::kGlossy);
    if (!(si.wi.z > 0) || (!has_diffuse && !has_glossy)) {
      zero_batch(wo, out);
      return;
    }
    const float p = glossy_probability(si, mask);
    const Rgb diffuse = has_diffuse ? diffuse_factor(si) : Rgb(0.f);
    if (!has_glossy) {
      evaluate_batch(wo, out, [&](const Vec3& d) { return diffuse_part(diffuse, 1.f, d); });
      return;
    }
    const Rgb specular = specular_->eval(si.uv);
    with_microfacet_type(type_, [&](auto type) {
      const RoughReflection<decltype(type)::value> reflection(alpha_, alpha_, sample_visible_,
                                                              si.wi);
      evaluate_batch(wo, out, [&, reflection](const Vec3& d) {
        const auto v = reflection(d);
        BsdfValue value = diffuse_part(diffuse, 1 - p, d);
        value.f += specular * (fresnel_dielectric(v.cos_half, eta_) * v.dg);
        value.pdf += p * v.pdf;
        return value;
      });
    });
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    mask = mask & lobes_;
    if (!(si.wi.z > 0) || !any(mask & (Lobe::kDiffuse | Lobe::kGlossy))) {
      return std::nullopt;
    }
    if (u1 >= glossy_probability(si, mask)) {
      return weighted_sample(*this, si, mask, square_to_cosine_hemisphere(u2), Lobe::kDiffuse);
    }
    Vec3 wo;
    with_microfacet_type(type_, [&](auto type) {
      wo =
          RoughReflection<decltype(type)::value>(alpha_, alpha_, sample_visible_, si.wi).sample(u2);
    });
    return weighted_sample(*this, si, mask, wo, Lobe::kGlossy);
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    BsdfForm form;
    if (any(lobes_ & Lobe::kDiffuse)) form.diffuse = diffuse_factor(si);
    form.transmittance = transmittance_.table().data();
    if (any(lobes_ & Lobe::kGlossy)) {
      form.glossy = glossy_form(type_);
      form.specular = specular_->eval(si.uv);
      form.alpha_u = form.alpha_v = std::max(alpha_, kMinAlpha);
      form.eta = Rgb(eta_);
    }
    return form;
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const float t = transmittance_.external(std::max(si.wi.z, 0.f));
    // The integral of T(wo) cos / pi is eta² (1 - R) for a smooth boundary.
    const Rgb inside = diffuse_->eval(si.uv);
    return {inside * t * (1 - transmittance_.internal_reflectance()) / bounces(inside),
            specular_->eval(si.uv) * (1 - t)};
  }

 private:
  static float valid_alpha(const Properties& props) {
    const float alpha = props.real("alpha");
    if (!(alpha >= 0) || !std::isfinite(alpha)) {
      throw props.error("alpha", "must not be negative, got " + std::to_string(alpha));
    }
    return alpha;
  }

  /// 1 - R: what the geometric series of bounces inside divides by.
  Rgb bounces(const Rgb& albedo) const {
    const float r = transmittance_.internal_reflectance();
    return nonlinear_ ? 1.f - r * albedo : Rgb(1 - r);
  }

  Rgb diffuse_factor(const SurfaceInteraction& si) const {
    const Rgb albedo = diffuse_->eval(si.uv);
    return albedo / bounces(albedo) * (transmittance_.external(si.wi.z) / (eta_ * eta_));
  }

  BsdfValue diffuse_part(const Rgb& factor, float probability, const Vec3& wo) const {
    const float pdf = cosine_hemisphere_pdf(wo.z);
    return {factor * (pdf * transmittance_.external(std::max(wo.z, 0.f))), probability * pdf};
  }

  float glossy_probability(const SurfaceInteraction& si, Lobe mask) const {
    const float t = transmittance_.external(si.wi.z);
    return lobe_probability(any(mask & Lobe::kGlossy), any(mask & Lobe::kDiffuse),
                            (1 - t) * specular_weight_, t * (1 - specular_weight_));
  }

  std::shared_ptr<Texture> diffuse_;
  std::shared_ptr<Texture> specular_;
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
