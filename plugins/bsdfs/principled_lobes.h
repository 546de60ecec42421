#pragma once

#include <string>
#include <tuple>
#include <utility>

#include "batch.h"
#include "kinome/wide/fresnel.h"
#include "kinome/wide/microfacet.h"

/// Formulas that the solid and the thin principled BSDF share: Burley 2012, "Physically Based
/// Shading at Disney", and 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface
/// Scattering", with the choices of Mitsuba 3. The number type F is float or wide::Float.
namespace kinome {

/// Parameters of both plugins.
#define KINOME_PRINCIPLED_PARAMETERS                                                               \
  {"base_color", ::kinome::ParameterType::kReflectanceTexture, "0.5", "colour of the material"},   \
      {"roughness", ::kinome::ParameterType::kUnitlessTexture, "0.5",                              \
       "roughness of the main lobes; alpha is its square, at least 0.001"},                        \
      {"anisotropic", ::kinome::ParameterType::kUnitlessTexture, "0",                              \
       "anisotropy, from 0 (isotropic) to 1 (stretched along dp_du)"},                             \
      {"spec_trans", ::kinome::ParameterType::kUnitlessTexture, "0",                               \
       "weight of the glass, which replaces the diffuse base, in [0,1]"},                          \
      {"spec_tint", ::kinome::ParameterType::kUnitlessTexture, "0",                                \
       "weight of base_color in the colour of the reflection, in [0,1]"},                          \
      {"sheen", ::kinome::ParameterType::kUnitlessTexture, "0", "strength of the sheen of cloth"}, \
      {"sheen_tint", ::kinome::ParameterType::kUnitlessTexture, "0",                               \
       "weight of base_color in the colour of the sheen, in [0,1]"},                               \
  {                                                                                                \
    "flatness", ::kinome::ParameterType::kUnitlessTexture, "0",                                    \
        "from 0 (diffuse) to 1 (flat, as if by subsurface scattering)"                             \
  }

/// Reads a texture with values in [0, upper_bound].
inline std::shared_ptr<Texture> share_texture(const Properties& props, const std::string& name,
                                              float upper_bound = 1) {
  return bounded_texture(props, name, nonnegative_texture(props, name), upper_bound);
}

namespace principled {

/// Textures that both plugins have.
struct Inputs {
  explicit Inputs(const Properties& props)
      : base_color(reflectance_texture(props, "base_color")),
        roughness(roughness_texture(props, "roughness")),
        anisotropic(share_texture(props, "anisotropic")),
        spec_trans(share_texture(props, "spec_trans")),
        spec_tint(share_texture(props, "spec_tint")),
        sheen(nonnegative_texture(props, "sheen")),
        sheen_tint(share_texture(props, "sheen_tint")),
        flatness(share_texture(props, "flatness")) {}

  auto tied() const {
    return std::tie(base_color, roughness, anisotropic, spec_trans, spec_tint, sheen, sheen_tint,
                    flatness);
  }

  ColorInput base_color;
  NumberInput roughness, anisotropic, spec_trans, spec_tint, sheen, sheen_tint, flatness;
};
/// Their values at a point.
template <class F>
struct PointParameters {
  RgbOf<F> base_color;
  F roughness, anisotropic, spec_trans, spec_tint, sheen, sheen_tint, flatness;
};

/// (1 - cosine)^5 of Schlick's approximation to the Fresnel equations.
template <class F>
F schlick_weight(const F& cosine) {
  const F m = clamp(1.f - cosine, F(0.f), F(1.f));
  return sqr(sqr(m)) * m;
}
template <class F>
RgbOf<F> towards_white(const RgbOf<F>& r0, const F& weight) {
  return r0 + weight * (RgbOf<F>(1.f) - r0);
}
template <class F>
F towards_white(float r0, const F& weight) {
  return r0 + weight * (1 - r0);
}
/// Fresnel reflectance at normal incidence.
template <class F>
F schlick_r0(const F& eta) {
  return sqr((eta - 1.f) / (eta + 1.f));
}

/// Scales `color` to luminance 1. Black becomes white.
template <class V>
V tint(const V& color) {
  const auto y = luminance(color);
  return select(y > 0.f, color / y, V(1.f));
}

/// alpha_u and alpha_v of the microfacets.
template <class F>
std::pair<F, F> alphas(const F& roughness, const F& anisotropic) {
  const F alpha = sqr(roughness);
  const F aspect = sqrt(1.f - 0.9f * clamped_share(anisotropic));
  return {max(alpha / aspect, F(0.001f)), max(alpha * aspect, F(0.001f))};
}

/// Diffuse reflection with retro-reflection, mixed by `flatness` with an approximation of
/// subsurface scattering. Returns f cos(theta_o) / base_color. cos_d is the cosine of either
/// direction with the half vector.
template <class F>
F diffuse(const F& roughness, const F& flatness, const F& cos_i, const F& cos_o, const F& cos_d) {
  const F i = schlick_weight(cos_i), o = schlick_weight(cos_o);
  const F rr = 2.f * roughness * sqr(cos_d);
  const F base = (1.f - 0.5f * i) * (1.f - 0.5f * o);
  const F retro = rr * (o + i + o * i * (rr - 1.f));
  const F scattered = (1.f + o * (0.5f * rr - 1.f)) * (1.f + i * (0.5f * rr - 1.f));
  // cos_o times 1.25 (scattered (1 / (cos_i + cos_o) - 0.5) + 0.5), without overflow.
  const F share = cos_o / max(cos_i + cos_o, F(1e-30f));
  const F flat = 1.25f * (scattered * (share - 0.5f * cos_o) + 0.5f * cos_o);
  return kInvPi * lerp(cos_o * (base + retro), flat, flatness);
}

/// Returns f cos(theta_o) of sheen with strength 1.
template <class F>
RgbOf<F> sheen(const RgbOf<F>& base_color, const F& sheen_tint, const F& cos_o, const F& cos_d) {
  const RgbOf<F> color = RgbOf<F>(1.f) + sheen_tint * (tint(base_color) - RgbOf<F>(1.f));
  return schlick_weight(cos_d) * cos_o * color;
}

/// Distribution of the clear coat's normals, GTR with exponent 1 (Burley 2012, appendix B).
template <class F>
struct Gtr1 {
  F alpha2;

  /// clearcoat_gloss in [0, 1].
  static Gtr1 of_gloss(const F& gloss) { return {sqr(lerp(F(0.1f), F(0.001f), gloss))}; }
  F d(const F& cosine) const {
    return (alpha2 - 1.f) / (kPi * log(alpha2) * (1.f + (alpha2 - 1.f) * sqr(cosine)));
  }
  /// Samples a normal with density d(m) m.z.
  VecOf<F> sample(const Vec2Of<F>& u) const {
    const F cos2 = clamp((1.f - exp(log(alpha2) * (1.f - u.y))) / (1.f - alpha2), F(0.f), F(1.f));
    const F r = sqrt(1.f - cos2);
    F s, c;
    sincos(2 * kPi * u.x, s, c);
    return {r * c, r * s, sqrt(cos2)};
  }
};

}  // namespace principled

}  // namespace kinome
