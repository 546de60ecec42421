#include "batch.h"
#include "kinome/plugin.h"

/// Rough diffuse reflection, as in Mitsuba 0.6: Lambertian facets that shadow, mask and illuminate
/// one another. Source: Oren and Nayar 1994, "Generalization of Lambert's Reflectance Model",
/// equations 27 to 31. With `use_fast_approx`, their qualitative model, equation 30. `alpha` is the
/// roughness of a Beckmann distribution; sigma in the paper is alpha / sqrt(2).
///
///     <bsdf type="roughdiffuse">
///       <rgb name="reflectance" value="0.6 0.5 0.4"/><float name="alpha" value="0.5"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo of the facets"},
    {"alpha", ParameterType::kUnitlessTexture, "0.2", "roughness, root mean square of the slopes"},
    {"use_fast_approx", ParameterType::kBoolean, "false", "ignore interreflections between facets"},
};

class RoughDiffuse final : public wide::FormulaBsdf<RoughDiffuse> {
 public:
  explicit RoughDiffuse(const Properties& props)
      : reflectance_(reflectance_texture(props, "reflectance")),
        alpha_(roughness_texture(props, "alpha")),
        is_fast_(props.boolean("use_fast_approx")) {
    lobes_ = Lobe::kDiffuse;
  }

  auto inputs() const { return std::tie(reflectance_, alpha_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([this](const VecOf<F>& wi, const RgbOf<F>& albedo, const F& alpha) {
      return Lobes<F>(is_fast_, wi, albedo, alpha);
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return reflectance_.at(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {reflectance_.at(si), Rgb(0.f)};
  }

 private:
  template <class F>
  class Lobes {
   public:
    Lobes(bool is_fast, const VecOf<F>& wi, const RgbOf<F>& albedo, const F& alpha)
        : is_fast_(is_fast), wi_(wi), albedo_(albedo), sigma2_(0.5f * alpha * alpha) {}

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F pdf = warp::cosine_hemisphere_pdf(wo.z);
      const RgbOf<F> factor = is_fast_ ? albedo_ * first_bounce(wo, true) : whole_factor(wo);
      return {factor * pdf, pdf};
    }
    BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& u2) const {
      return diffuse_sample<F>(*this, u2);
    }

   private:
    /// Functions of theta_i and theta_o, the angles of wi and wo to the normal, and of phi, the
    /// difference of their azimuths.
    struct Angles {
      F larger_sine, smaller_tangent, cos_phi;
    };
    Angles angles(const VecOf<F>& wo) const {
      constexpr float kMin = 1e-6f;
      const F sin_i = sqrt(max(1.f - wi_.z * wi_.z, F(0.f)));
      const F sin_o = sqrt(max(1.f - wo.z * wo.z, F(0.f)));
      const F sines = sin_i * sin_o;
      const F cos_phi = select(
          sines > kMin, clamp((wi_.x * wo.x + wi_.y * wo.y) / max(sines, F(kMin)), F(-1.f), F(1.f)),
          F(0.f));
      const F larger_cosine = max(max(wi_.z, wo.z), F(kMin));
      return {max(sin_i, sin_o), min(sin_i, sin_o) / larger_cosine, cos_phi};
    }

    /// Returns the reflection without interreflection, relative to a Lambertian surface of the same
    /// albedo. `is_qualitative` selects the qualitative model.
    F first_bounce(const VecOf<F>& wo, bool is_qualitative) const {
      const Angles a = angles(wo);
      const F c1 = 1.f - 0.5f * sigma2_ / (sigma2_ + 0.33f);
      const F c2 = 0.45f * sigma2_ / (sigma2_ + 0.09f);
      if (is_qualitative) {
        return c1 + c2 * max(a.cos_phi, F(0.f)) * a.larger_sine * a.smaller_tangent;
      }
      const F theta_i = acos(clamp(wi_.z, F(0.f), F(1.f)));
      const F theta_o = acos(clamp(wo.z, F(0.f), F(1.f)));
      // The angles alpha and beta of the paper; this alpha isn't the roughness.
      const F alpha = max(theta_i, theta_o), beta = min(theta_i, theta_o);
      const F of_beta = 2.f * kInvPi * beta;
      // Nonzero only if wi and wo are on opposite sides of the normal.
      const F behind = select(a.cos_phi < 0.f, of_beta * of_beta * of_beta, F(0.f));
      const F of_both = 4.f * kInvPi * kInvPi * alpha * beta;
      const F c3 = 0.125f * sigma2_ / (sigma2_ + 0.09f) * of_both * of_both;
      // tan((alpha + beta) / 2) by the sum-to-product formulas, accurate at grazing angles.
      const F sin_i = sqrt(max(1.f - wi_.z * wi_.z, F(0.f)));
      const F sin_o = sqrt(max(1.f - wo.z * wo.z, F(0.f)));
      const F tangent = (sin_i + sin_o) / max(wi_.z + wo.z, F(1e-6f));
      return c1 + a.cos_phi * c2 * (a.larger_sine - behind) * a.smaller_tangent +
             (1.f - abs(a.cos_phi)) * c3 * tangent;
    }

    /// Returns pi times the BSDF of the full model, which includes one interreflection.
    RgbOf<F> whole_factor(const VecOf<F>& wo) const {
      const F cos_phi = angles(wo).cos_phi;
      const F beta = acos(clamp(max(wi_.z, wo.z), F(0.f), F(1.f)));
      const F of_beta = 2.f * kInvPi * beta;
      const F second =
          0.17f * sigma2_ / (sigma2_ + 0.13f) * (1.f - cos_phi * of_beta * of_beta);
      return albedo_ * max(first_bounce(wo, false), F(0.f)) + albedo_ * albedo_ * second;
    }

    bool is_fast_;
    VecOf<F> wi_;
    RgbOf<F> albedo_;
    F sigma2_;
  };

  ColorInput reflectance_;
  NumberInput alpha_;
  bool is_fast_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::RoughDiffuse, kinome::Category::kBsdf, "roughdiffuse",
              "Rough diffuse reflection (Oren and Nayar), as in Mitsuba 0.6.",
              kinome::kParameters);
