#include <array>

#include "batch.h"
#include "dielectric_index.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"

/// A fibre of hair or fur after Chiang et al. 2016, "A Practical and Controllable Hair and Fur
/// Model for Production Path Tracing", as in Mitsuba 3. Light is reflected (p = 0), transmitted
/// (1), transmitted after one internal reflection (2) or after more (3). Each of these lobes is
///
///     f |cos(theta_o)| = A_p M_p(theta_i, theta_o) N_p(phi_o - phi_i)
///
/// theta is the angle with the plane perpendicular to the fibre, phi the azimuth around the fibre.
/// The shape's v must run along the fibre, as on curves: y is the fibre's direction in the shading
/// frame. Light leaves the fibre at the point where it entered.
///
///     <bsdf type="hair"><float name="eumelanin" value="0.2"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"eumelanin", ParameterType::kFloat, "1.3", "concentration of the pigment of black hair"},
    {"pheomelanin", ParameterType::kFloat, "0.2", "concentration of the pigment of red hair"},
    {"sigma_a", ParameterType::kUnitlessTexture, nullptr,
     "absorption coefficient per radius of the fibre, instead of the pigments"},
    {"scale", ParameterType::kFloat, "1", "scale factor of sigma_a"},
    {"int_ior", ParameterType::kFloatOrName, "amber", "index of refraction of the fibre"},
    {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},
    {"longitudinal_roughness", ParameterType::kFloat, "0.3",
     "roughness along the fibre, in [0,1]; values below 0.01 are raised to it"},
    {"azimuthal_roughness", ParameterType::kFloat, "0.3",
     "roughness around the fibre, in [0,1]; values below 0.01 are raised to it"},
    {"scale_tilt", ParameterType::kFloat, "2", "tilt of the fibre's scales, in degrees"},
};

/// The last lobe contains all paths with two or more internal reflections.
constexpr int kLobes = 4, kLastLobe = kLobes - 1;

/// exp(-x) I0(x) of the modified Bessel function I0, x >= 0, with a relative error of 2e-7
/// (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2). Mitsuba 3.9.1 uses a series of 11 terms up to
/// x = 12, where it is 0.55 % too small: its densities don't integrate to 1.
template <class F>
F scaled_bessel(const F& x) {
  const F small = sqr(min(x, F(3.75f)) * (1 / 3.75f)), large = 3.75f / max(x, F(3.75f));
  const F near = exp(-min(x, F(3.75f))) * polynomial(small, 0.0045813f, 0.0360768f, 0.2659732f,
                                                     1.2067492f, 3.0899424f, 3.5156229f, 1.f);
  const F far = polynomial(large, 0.00392377f, -0.01647633f, 0.02635537f, -0.02057706f, 0.00916281f,
                           -0.00157565f, 0.00225319f, 0.01328592f, 0.39894228f) /
                sqrt(max(x, F(3.75f)));
  return select(x < 3.75f, near, far);
}

/// Angle of a direction with the plane perpendicular to the fibre.
template <class F>
struct Inclination {
  F sine, cosine;
};

/// M_p / (2 pi): density per solid angle of longitudinal scattering with variance v and a uniform
/// azimuth (d'Eon et al. 2011, "An Energy-Conserving Hair Reflectance Model").
template <class F>
F longitudinal_density(const Inclination<F>& i, const Inclination<F>& o, float v) {
  const float kappa = 1 / v;
  const float scale = kappa / (2 * kPi) / (1 - std::exp(-2 * kappa));
  const F exponent = kappa * (i.cosine * o.cosine - i.sine * o.sine - 1.f);
  return scale * exp(exponent) * scaled_bessel(kappa * i.cosine * o.cosine);
}
/// Samples the sine of an inclination with that density.
template <class F>
F sample_longitudinal(const Inclination<F>& i, const F& v, const Vec2Of<F>& u) {
  const F cosine =
      clamp(1.f + v * log(max(u.x + (1.f - u.x) * exp(-2.f / v), F(1e-38f))), F(-1.f), F(1.f));
  return i.cosine * safe_sqrt(1.f - sqr(cosine)) * cos(2 * kPi * u.y) - cosine * i.sine;
}

/// Logistic distribution of angles with scale s, trimmed to [-pi, pi].
class TrimmedLogistic {
 public:
  explicit TrimmedLogistic(float s)
      : s_(s), below_(1 / (1 + std::exp(kPi / s))), mass_(1 - 2 * below_) {}
  /// phi may be outside [-pi, pi].
  template <class F>
  F density(const F& phi) const {
    const F wrapped = phi - 2 * kPi * round(phi * (0.5f * kInvPi));
    const F e = exp(-abs(wrapped) / s_);
    return e / (s_ * mass_ * sqr(1.f + e));
  }
  template <class F>
  F sample(const F& u) const {
    return clamp(-s_ * log(max(1.f / max(u * mass_ + below_, F(1e-30f)) - 1.f, F(1e-38f))), F(-kPi),
                 F(kPi));
  }

 private:
  float s_, below_, mass_;
};

class Hair final : public wide::FormulaBsdf<Hair> {
 public:
  static constexpr bool kSeenFromBehind = true;

  explicit Hair(const Properties& props)
      : absorption_(read_absorption(props)),
        scale_(props.has("sigma_a") ? nonnegative_number(props, "scale") : 1),
        eta_(bending_ior(props)),
        azimuthal_(azimuthal_scale(roughness(props, "azimuthal_roughness"))) {
    const float b = roughness(props, "longitudinal_roughness");
    v_[0] = sqr(0.726f * b + 0.812f * b * b + 3.7f * std::pow(b, 20.f));
    v_[1] = 0.25f * v_[0];
    v_[2] = v_[3] = 4 * v_[0];
    // Scales with tilt a rotate wi by -2 a for reflection, a for transmission, and 4 a for
    // transmission after one internal reflection (Chiang et al. 2016, section 2).
    const float tilt = props.real("scale_tilt") * (kPi / 180);
    if (!std::isfinite(tilt)) throw props.error("scale_tilt", "must be finite");
    tilt_ = {-2 * tilt, tilt, 4 * tilt, 0};
    lobes_ = Lobe::kGlossy;
    transmits_ = has_rough_transmission_ = true;
  }

  auto inputs() const { return std::tie(absorption_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([this](const VecOf<F>& wi, const RgbOf<F>& absorption) {
      return Lobes<F>(*this, wi, absorption);
    });
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {Rgb(0.f), Lobes<float>(*this, si.wi, absorption_.at(si.uv)).albedo()};
  }
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.frame_toward_viewer();
  }

 private:
  static float roughness(const Properties& props, const char* name) {
    return std::max(0.01f, props.real(name, "must be between 0 and 1",
                                      [](float value) { return value >= 0 && value <= 1; }));
  }
  /// Chiang et al. 2016, eq. 8.
  static float azimuthal_scale(float b) {
    return std::sqrt(kPi / 8) * (0.265f * b + 1.194f * b * b + 5.372f * std::pow(b, 22.f));
  }
  static std::shared_ptr<Texture> read_absorption(const Properties& props) {
    if (props.has("sigma_a")) {
      for (const char* const name : {"eumelanin", "pheomelanin"}) props.exclude(name, "sigma_a");
      return nonnegative_texture(props, "sigma_a");
    }
    if (props.has("scale")) nonnegative_number(props, "scale");
    // d'Eon et al. 2011.
    return make_uniform_texture(
        nonnegative_number(props, "eumelanin") * Rgb(0.419f, 0.697f, 1.37f) +
        nonnegative_number(props, "pheomelanin") * Rgb(0.187f, 0.4f, 1.05f));
  }

  template <class F>
  class Lobes {
   public:
    Lobes(const Hair& hair, const VecOf<F>& wi, const RgbOf<F>& absorption)
        : hair_(hair), i_(inclination(wi)), phi_i_(atan2(wi.z, wi.x)) {
      // Offset across the fibre of the point where wi hits it, from -1 to 1.
      const F r = sqrt(sqr(wi.x) + sqr(wi.z));
      const F h = select(r > 0.f, clamp(-wi.x / r, F(-1.f), F(1.f)), F(0.f));
      gamma_i_ = select(r > 0.f, -atan2(wi.x, wi.z), F(0.f));
      const F cos_t = max(safe_sqrt(1.f - sqr(i_.sine / hair.eta_)), F(1e-6f));
      // Modified index of refraction in the plane perpendicular to the fibre (Marschner et al.
      // 2003).
      const F index = max(safe_sqrt(sqr(hair.eta_) - sqr(i_.sine)), F(1e-6f));
      const F sin_gamma_t = clamp(h * i_.cosine / index, F(-1.f), F(1.f));
      gamma_t_ = asin(sin_gamma_t);
      const F length = 2.f * safe_sqrt(1.f - sqr(sin_gamma_t)) / cos_t;
      const RgbOf<F> depth = (-hair.scale_ * length) * absorption;
      const RgbOf<F> transmittance(exp(depth.x), exp(depth.y), exp(depth.z));
      const F fresnel = fresnel_dielectric(i_.cosine * safe_sqrt(1.f - sqr(h)), hair.eta_);
      attenuation_[0] = RgbOf<F>(fresnel);
      attenuation_[1] = sqr(1.f - fresnel) * transmittance;
      attenuation_[2] = fresnel * attenuation_[1] * transmittance;
      attenuation_[3] =
          fresnel * attenuation_[2] * transmittance / (RgbOf<F>(1.f) - fresnel * transmittance);
      F sum = 0.f;
      for (int p = 0; p < kLobes; ++p) {
        // All grazing light is reflected. The other lobes are 0, or 0/0 without this.
        attenuation_[p] = select(fresnel < 1.f, attenuation_[p], RgbOf<F>(p == 0 ? 1.f : 0.f));
        probability_[p] = luminance(attenuation_[p]);
        sum += probability_[p];
      }
      for (F& probability : probability_) probability = probability / sum;
    }

    RgbOf<F> albedo() const {
      return attenuation_[0] + attenuation_[1] + attenuation_[2] + attenuation_[3];
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const Inclination<F> o = inclination(wo);
      const F delta_phi = atan2(wo.z, wo.x) - phi_i_;
      BsdfValueOf<F> value{RgbOf<F>(0.f), F(0.f)};
      for (int p = 0; p < kLobes; ++p) {
        F density = longitudinal_density(tilted(p), o, hair_.v_[p]);
        if (p < kLastLobe) {
          density = density * (2 * kPi) * hair_.azimuthal_.density(delta_phi - mean_azimuth(p));
        }
        value.f += density * attenuation_[p];
        value.pdf += density * probability_[p];
      }
      value.pdf = min(value.pdf, F(kMaxPdf));
      value.f = select(value.pdf > 0.f, value.f);
      return value;
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      Inclination<F> i = tilted(0);
      F v = hair_.v_[0], mean = mean_azimuth(0);
      F before = 0.f, share = probability_[0], sum = probability_[0];
      MaskOf<F> is_last = u1 < 0.f;  // nowhere
      for (int p = 1; p < kLobes; ++p) {
        const auto is_further = !(u1 < sum);
        const Inclination<F> next = tilted(p);
        i = {select(is_further, next.sine, i.sine), select(is_further, next.cosine, i.cosine)};
        v = select(is_further, F(hair_.v_[p]), v);
        mean = select(is_further, mean_azimuth(p), mean);
        before = select(is_further, sum, before);
        share = select(is_further, probability_[p], share);
        sum += probability_[p];
        is_last = is_further;
      }
      // u1, rescaled to its lobe, samples the azimuth.
      const F u = clamp((u1 - before) / share, F(0.f), F(kOneMinusEpsilon));
      const F delta_phi = select(is_last, 2 * kPi * u, mean + hair_.azimuthal_.sample(u));
      const F sine = clamp(sample_longitudinal(i, v, u2), F(-1.f), F(1.f));
      const F cosine = safe_sqrt(1.f - sqr(sine));
      F s, c;
      sincos(phi_i_ + delta_phi, s, c);
      return weighted_sample<F>(*this, normalize(VecOf<F>(cosine * c, sine, cosine * s)),
                                IntOf<F>(lobe_number(Lobe::kGlossy)));
    }

   private:
    static Inclination<F> inclination(const VecOf<F>& w) {
      const F sine = clamp(w.y, F(-1.f), F(1.f));
      return {sine, safe_sqrt(1.f - sqr(sine))};
    }
    /// Inclination of wi, rotated by the tilt of the scales.
    Inclination<F> tilted(int p) const {
      const float s = std::sin(hair_.tilt_[p]), c = std::cos(hair_.tilt_[p]);
      return {clamp(i_.sine * c + i_.cosine * s, F(-1.f), F(1.f)),
              abs(i_.cosine * c - i_.sine * s)};
    }
    /// Azimuth, relative to wi, of light that a smooth fibre scatters into lobe p.
    F mean_azimuth(int p) const {
      return 2.f * static_cast<float>(p) * gamma_t_ - 2.f * gamma_i_ + static_cast<float>(p) * kPi;
    }

    const Hair& hair_;
    Inclination<F> i_;
    F phi_i_, gamma_i_, gamma_t_;
    std::array<RgbOf<F>, kLobes> attenuation_;  ///< A_p
    std::array<F, kLobes> probability_;
  };

  ColorInput absorption_;
  float scale_;
  float eta_;
  TrimmedLogistic azimuthal_;
  std::array<float, kLobes> v_, tilt_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Hair, kinome::Category::kBsdf, "hair",
              "Hair and fur: fibres that reflect and transmit light.", kinome::kParameters);
