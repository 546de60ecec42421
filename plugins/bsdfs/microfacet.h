#pragma once

#include "kinome/bsdf.h"
#include "kinome/math.h"

namespace kinome {

enum class MicrofacetType { kBeckmann, kGgx };
inline constexpr const char* kMicrofacetTypes[] = {"beckmann", "ggx"};

inline BsdfForm::Glossy glossy_form(MicrofacetType type) {
  return type == MicrofacetType::kBeckmann ? BsdfForm::Glossy::kBeckmann : BsdfForm::Glossy::kGgx;
}

/// Mitsuba's lower bound of a roughness.
inline constexpr float kMinAlpha = 1e-4f;

/// Inverse error function, |relative error| < 1e-6 (Giles 2010, single precision); finite for every
/// float in [-1, 1].
inline float inverse_erf(float x) {
  x = std::clamp(x, -kOneMinusEpsilon, kOneMinusEpsilon);
  float w = -std::log((1 - x) * (1 + x));
  float p;
  if (w < 5) {
    w -= 2.5f;
    p = 2.81022636e-08f;
    p = 3.43273939e-07f + p * w;
    p = -3.5233877e-06f + p * w;
    p = -4.39150654e-06f + p * w;
    p = 0.00021858087f + p * w;
    p = -0.00125372503f + p * w;
    p = -0.00417768164f + p * w;
    p = 0.246640727f + p * w;
    p = 1.50140941f + p * w;
  } else {
    w = std::sqrt(w) - 3;
    p = -0.000200214257f;
    p = 0.000100950558f + p * w;
    p = 0.00134934322f + p * w;
    p = -0.00367342844f + p * w;
    p = 0.00573950773f + p * w;
    p = -0.0076224613f + p * w;
    p = 0.00943887047f + p * w;
    p = 1.00167406f + p * w;
    p = 2.83297682f + p * w;
  }
  return p * x;
}

/// Visible slopes of Beckmann's distribution at alpha = 1 have the density
/// P22(x, y) (cos_theta - x sin_theta) with x toward the viewer's azimuth. y is Gaussian:
inline float beckmann_slope_y(float u) {
  return inverse_erf(2 * u - 1);
}
/// x has the distribution function
/// F(x) = cos_theta (1 + erf x) / 2 + sin_theta exp(-x²) / (2 sqrt pi), x <= cot theta, which is
/// inverted by Newton's method from Jakob 2014's start (exact at grazing angles), in a bracket.
inline float beckmann_visible_slope_x(float cos_theta, float sin_theta, float u) {
  constexpr float kHalfInvSqrtPi = 0.5f * std::numbers::inv_sqrtpi_v<float>;
  const auto f = [&](float x) {
    return cos_theta * 0.5f * std::erfc(-x) + sin_theta * kHalfInvSqrtPi * std::exp(-x * x);
  };
  constexpr float kFar = 5;  // beyond it lies less than 2e-12
  float hi = cos_theta < kFar * sin_theta ? cos_theta / sin_theta : kFar;
  float lo = -kFar;
  const float target = u * f(hi);
  const float top = std::erf(hi);
  const float first = -std::log(std::max(u, 1e-7f));
  float x = inverse_erf(top - (top + 1) * std::erf(std::sqrt(first)));
  for (int i = 0; i < 16; ++i) {
    x = x > lo && x < hi ? x : 0.5f * (lo + hi);
    const float error = f(x) - target;
    (error > 0 ? hi : lo) = x;
    const float density = (cos_theta - x * sin_theta) * 2 * kHalfInvSqrtPi * std::exp(-x * x);
    const float step = density > 0 ? error / density : 0.f;
    x -= step;
    if (std::abs(step) < 1e-6f) {
      break;
    }
  }
  return std::clamp(x, lo, hi);
}

/// Distribution of microfacet normals, anisotropic, with Smith's uncorrelated masking.
///
/// D and G1 are Mitsuba 3's. Its Beckmann G1 is Walter et al. 2007's rational fit, up to 0.35 % off
/// the true one; values of f keep it, for parity. The density of visible normals must not: with the
/// fit it would integrate to something other than 1. So densities take `smith_g1_exact`.
template <MicrofacetType kType>
class Microfacet {
 public:
  Microfacet(float alpha_u, float alpha_v)
      : au_(std::max(alpha_u, kMinAlpha)), av_(std::max(alpha_v, kMinAlpha)) {}

  /// Density of normals: D(m) (m . n) integrates to 1 over the hemisphere.
  float d(const Vec3& m) const {
    const float x2 = sqr(m.x / au_);
    const float y2 = sqr(m.y / av_);
    const float z2 = m.z * m.z;
    float value;
    if constexpr (kType == MicrofacetType::kBeckmann) {
      value = std::exp(-(x2 + y2) / z2) / (kPi * au_ * av_ * z2 * z2);
    } else {
      value = 1 / (kPi * au_ * av_ * sqr(x2 + y2 + z2));
    }
    // Also where m is no direction (wi + wo = 0), which leaves NaN here.
    return value * m.z > 1e-20f ? value : 0.f;
  }

  /// The share of the microfacets facing v that is seen from v, v.z > 0.
  float smith_g1(const Vec3& v) const {
    const float slope2 = projected_slope2(v);
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const float a = 1 / std::sqrt(slope2);  // infinite at v = n
      const float fit = (3.535f * a + 2.181f * a * a) / (1 + 2.276f * a + 2.577f * a * a);
      return a >= 1.6f ? 1.f : fit;
    } else {
      return 2 / (1 + std::sqrt(1 + slope2));
    }
  }
  float smith_g1_exact(const Vec3& v) const {
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const float slope = std::sqrt(projected_slope2(v));
      const float a = 1 / slope;
      constexpr float kInvSqrtPi = std::numbers::inv_sqrtpi_v<float>;
      return 2 / (1 + std::erf(a) + std::exp(-a * a) * slope * kInvSqrtPi);
    } else {
      return smith_g1(v);
    }
  }

  /// A normal with density D(m) m.z.
  Vec3 sample_all(const Vec2& u) const {
    float r2;
    if constexpr (kType == MicrofacetType::kBeckmann) {
      r2 = -std::log1p(-u.y);
    } else {
      r2 = u.y / (1 - u.y);
    }
    const float r = std::sqrt(r2);
    const float phi = 2 * kPi * u.x;
    return glm::normalize(Vec3(au_ * r * std::cos(phi), av_ * r * std::sin(phi), 1.f));
  }

  /// A normal among those visible from wi: density G1(wi) D(m) max(0, wi . m) / wi.z.
  Vec3 sample_visible(const Vec3& wi, const Vec2& u) const {
    // Stretched by the roughness the problem is that of alpha = 1.
    const Vec3 stretched = glm::normalize(Vec3(au_ * wi.x, av_ * wi.y, wi.z));
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const float sin_theta = std::sqrt(sqr(stretched.x) + sqr(stretched.y));
      const float c = sin_theta > 0 ? stretched.x / sin_theta : 1.f;
      const float s = sin_theta > 0 ? stretched.y / sin_theta : 0.f;
      const float x = beckmann_visible_slope_x(stretched.z, sin_theta, u.x);
      const float y = beckmann_slope_y(u.y);
      return glm::normalize(Vec3(-au_ * (c * x - s * y), -av_ * (s * x + c * y), 1.f));
    } else {
      // Dupuy and Benyoub 2023: halfway to a uniform point of a spherical cap.
      const float z = (1 - u.y) * (1 + stretched.z) - stretched.z;
      const float r = safe_sqrt(1 - z * z);
      const float phi = 2 * kPi * u.x;
      const Vec3 h = Vec3(r * std::cos(phi), r * std::sin(phi), z) + stretched;
      const Vec3 m(au_ * h.x, av_ * h.y, std::max(h.z, 0.f));
      const float length2 = glm::dot(m, m);
      return length2 > 1e-30f ? m / std::sqrt(length2) : Vec3(0, 0, 1);
    }
  }

 private:
  /// (alpha tan theta)² with alpha along v.
  float projected_slope2(const Vec3& v) const {
    return (sqr(au_ * v.x) + sqr(av_ * v.y)) / (v.z * v.z);
  }

  float au_;
  float av_;
};

/// (wi + wo) / |wi + wo|, or zero where that is undefined.
inline Vec3 half_vector(const Vec3& wi, const Vec3& wo) {
  const Vec3 h = wi + wo;
  const float length2 = glm::dot(h, h);
  return h * (length2 > 1e-30f ? 1 / std::sqrt(length2) : 0.f);
}

/// D and G of reflection between wi and any wo, with the density of what sample() draws: the part
/// that rough conductors and rough plastics share.
template <MicrofacetType kType>
class RoughReflection {
 public:
  /// wi.z > 0.
  RoughReflection(float alpha_u, float alpha_v, bool sample_visible, const Vec3& wi)
      : microfacet_(alpha_u, alpha_v),
        wi_(wi),
        visible_(sample_visible),
        g1_scale_(microfacet_.smith_g1(wi) / (4 * wi.z)),
        pdf_scale_(microfacet_.smith_g1_exact(wi) / (4 * wi.z)) {}

  struct Value {
    float dg = 0;        ///< D G / (4 wi.z): f cos(theta_o) without Fresnel
    float pdf = 0;       ///< per solid angle of wo
    float cos_half = 0;  ///< wi . h, for Fresnel
  };
  /// Zero where wo.z <= 0.
  Value operator()(const Vec3& wo) const {
    const Vec3 h = half_vector(wi_, wo);
    const float d = wo.z > 0 ? microfacet_.d(h) : 0.f;
    const float cos_half = std::clamp(glm::dot(wi_, h), 0.f, 1.f);
    const float g1 = microfacet_.smith_g1(wo);
    // cos_half is positive where d is: both directions lie above the surface.
    const float pdf = visible_ ? d * pdf_scale_ : d * h.z / (4 * cos_half);
    const bool valid = d > 0 && cos_half > 0;
    return {valid ? d * g1 * g1_scale_ : 0.f, valid ? std::min(pdf, 1e18f) : 0.f, cos_half};
  }

  /// wi mirrored at a microfacet; may lie below the horizon.
  Vec3 sample(const Vec2& u) const {
    const Vec3 m = visible_ ? microfacet_.sample_visible(wi_, u) : microfacet_.sample_all(u);
    return glm::normalize(2 * glm::dot(wi_, m) * m - wi_);
  }
  const Microfacet<kType>& microfacet() const { return microfacet_; }

 private:
  Microfacet<kType> microfacet_;
  Vec3 wi_;
  bool visible_;
  float g1_scale_;
  float pdf_scale_;
};

/// Calls f with the distribution's type as a constant.
template <class F>
auto with_microfacet_type(MicrofacetType type, const F& f) {
  if (type == MicrofacetType::kBeckmann) {
    return f(std::integral_constant<MicrofacetType, MicrofacetType::kBeckmann>{});
  }
  return f(std::integral_constant<MicrofacetType, MicrofacetType::kGgx>{});
}

}  // namespace kinome
