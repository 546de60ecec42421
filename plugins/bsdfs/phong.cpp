#include "energy.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"

/// Modified Phong reflection, normalised, after Lafortune and Willems 1994 and Mitsuba 0.6:
///
///     f = kd / pi + ks (n + 2) / (2 pi) max(0, wo . R)^n,   R = wi mirrored at the normal.
///
/// (Åkerlund 2008, eq. 3.5 leaves the normalisation out: another convention, not this one.) The
/// lobe is sampled with density (n + 1) / (2 pi) (wo . R)^n; what falls below the horizon is lost.
///
///     <bsdf type="phong">
///       <rgb name="diffuse_reflectance" value="0.3 0.3 0.5"/>
///       <float name="specular_reflectance" value="0.3"/>
///       <float name="exponent" value="100"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"exponent", ParameterType::kUnitlessTexture, "30", "the lobe's exponent n, at least 0"},
    KINOME_REFLECTANCE_PAIR_PARAMETERS,
};

class Phong final : public Bsdf {
 public:
  explicit Phong(const Properties& props)
      : reflectances_(props), exponent_(nonnegative_texture(props, "exponent")) {
    lobes_ = reflectances_.lobes();
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
    const float n = exponent_->eval_1(si.uv);
    const float p = glossy_probability(mask);
    const Rgb diffuse = has_diffuse ? reflectances_.diffuse(si.uv) * kInvPi : Rgb(0.f);
    const float diffuse_pdf = (1 - p) * kInvPi;
    if (!has_glossy) {
      evaluate_batch(wo, out, [=](const Vec3& d) {
        const float c = std::max(d.z, 0.f);
        return BsdfValue{diffuse * c, diffuse_pdf * c};
      });
      return;
    }
    const Rgb glossy = reflectances_.specular(si.uv) * ((n + 2) * 0.5f * kInvPi);
    const float glossy_pdf = p * (n + 1) * 0.5f * kInvPi;
    const Vec3 r = mirrored(si.wi);
    evaluate_batch(wo, out, [=](const Vec3& d) {
      // cos alpha = 1 - s; the dot product itself would lose the digits that a large n magnifies.
      const Vec3 difference = r - d;
      const float s = 0.5f * glm::dot(difference, difference);
      float lobe = 0;
      if (d.z > 0 && s < 1) {
        lobe = std::exp(n * std::log1p(-s));
        // Below this the density could round to zero before f does.
        lobe = lobe > 1e-20f ? lobe : 0.f;
      }
      const float c = std::max(d.z, 0.f);
      return BsdfValue{(diffuse + glossy * lobe) * c, diffuse_pdf * c + glossy_pdf * lobe};
    });
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    mask = mask & lobes_;
    if (!(si.wi.z > 0) || !any(mask & (Lobe::kDiffuse | Lobe::kGlossy))) {
      return std::nullopt;
    }
    if (u1 >= glossy_probability(mask)) {
      return weighted_sample(*this, si, mask, square_to_cosine_hemisphere(u2), Lobe::kDiffuse);
    }
    const Vec3 local = square_to_cosine_power(u2, exponent_->eval_1(si.uv));
    const Vec3 wo = glm::normalize(Frame::from_normal(mirrored(si.wi)).to_world(local));
    return weighted_sample(*this, si, mask, wo, Lobe::kGlossy);
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    BsdfForm form;
    form.diffuse = reflectances_.diffuse(si.uv);
    form.glossy = any(lobes_ & Lobe::kGlossy) ? BsdfForm::Glossy::kOther : BsdfForm::Glossy::kNone;
    return form;
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {reflectances_.diffuse(si.uv), reflectances_.specular(si.uv)};
  }

 private:
  static Vec3 mirrored(const Vec3& w) { return {-w.x, -w.y, w.z}; }

  float glossy_probability(Lobe mask) const {
    const float p = reflectances_.specular_probability();
    return lobe_probability(any(mask & Lobe::kGlossy), any(mask & Lobe::kDiffuse), p, 1 - p);
  }

  ReflectancePair reflectances_;
  std::shared_ptr<Texture> exponent_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Phong, kinome::Category::kBsdf, "phong",
              "Normalised Phong lobe over a diffuse base, as in Mitsuba 0.6.", kinome::kParameters);
