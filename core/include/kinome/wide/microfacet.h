#pragma once

// Microfacet distributions for rough BSDFs and code that samples them: formulas over F, float or
// wide::Float. Not used by the core.

#include "kinome/bsdf.h"
#include "kinome/math.h"
#include "kinome/wide/near_zero.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {
inline namespace formulas {

enum class MicrofacetType { kBeckmann, kGgx };
inline constexpr const char* kMicrofacetTypes[] = {"beckmann", "ggx"};

inline BsdfForm::Glossy glossy_form(MicrofacetType type) {
  return type == MicrofacetType::kBeckmann ? BsdfForm::Glossy::kBeckmann : BsdfForm::Glossy::kGgx;
}

/// Lower bound of the roughness, as in Mitsuba.
inline constexpr float kMinAlpha = 1e-4f;

/// e^(a²) erfc(a) for a in [0, 5], with a relative error of 4e-7.
template <class F>
F scaled_erfc(F a) {
  const F t = 1.f / (1.f + 0.4f * a);
  return t * polynomial(t, 0.0773075745f, -0.40898186f, 0.713600874f, -0.40634644f, 0.429975688f,
                        0.131497726f, 0.238144174f, 0.224802271f);
}

/// Returns inverse_erf(), but finite for every float in [-1, 1].
template <class F>
F finite_inverse_erf(F y) {
  return inverse_erf(clamp(y, F(-kOneMinusEpsilon), F(kOneMinusEpsilon)));
}

/// Samples the y slope of visible normals for Beckmann with alpha = 1. Visible slopes have the
/// density P22(x, y) (cos_theta - x sin_theta), with x toward the viewer's azimuth; y is Gaussian.
template <class F>
F beckmann_slope_y(F u) {
  return finite_inverse_erf(2.f * u - 1.f);
}
/// Samples the x slope, with the distribution function F(x) = cos_theta (1 + erf x) / 2 + sin_theta
/// exp(-x²) / (2 sqrt pi) for x <= cot theta. Inverts it by Halley's method, to 3e-7 of its range.
template <class F>
F beckmann_visible_slope_x(F cos_theta, F sin_theta, F u) {
  constexpr float kHalfInvSqrtPi = 0.5f * std::numbers::inv_sqrtpi_v<float>;
  constexpr float kFar = 5;  // the probability beyond is less than 2e-12
  const F most = select(cos_theta < kFar * sin_theta, cos_theta / sin_theta, F(kFar));
  const F above_max = exp(-most * most);
  const F top = 2.f - above_max * scaled_erfc(most);  // 1 + erf
  const F target = u * (cos_theta * 0.5f * top + sin_theta * (kHalfInvSqrtPi * above_max));
  // Initial guess: 1 + erf x is about top u along the normal, and top erfc(sqrt(-log u)) at grazing
  // angles (Jakob 2014). Interpolated by the sine, F has an error below 0.03.
  const F v = max(u, F(1e-7f));
  const F grazing = scaled_erfc(safe_sqrt(-log(v)));  // erfc(...) / u
  F x = finite_inverse_erf(top * v * (1.f - sin_theta + sin_theta * grazing) - 1.f);
  // Each step cubes the error. The number of steps is fixed, so that lanes don't wait for each
  // other.
  for (int i = 0; i < 3; ++i) {
    x = clamp(x, F(-kFar), most);
    const F e = exp(-x * x);
    const F tail = e * scaled_erfc(abs(x));
    const F below = select(x < 0.f, tail, 2.f - tail);  // 1 + erf x
    const F error = cos_theta * 0.5f * below + sin_theta * (kHalfInvSqrtPi * e) - target;
    const F facing = cos_theta - x * sin_theta;  // F' = facing e / sqrt pi
    const F scale = 2.f * facing * facing * (2 * kHalfInvSqrtPi * e) +
                    error * (sin_theta + 2.f * x * facing);
    x = x - select(scale > 0.f, error * 2.f * facing / scale, F(0.f));
  }
  return clamp(x, F(-kFar), most);
}

/// Anisotropic distribution of microfacet normals, with Smith's uncorrelated masking.
///
/// D and G1 are those of Mitsuba 3. Its Beckmann G1 is the rational fit of Walter et al. 2007, with
/// an error of up to 0.35 %; values of f use it, for parity. Densities of visible normals use
/// `smith_g1_exact`, because they would not integrate to 1 with the fit.
template <MicrofacetType kType, class F = float>
class Microfacet {
 public:
  using Vector = VecOf<F>;

  Microfacet(const F& alpha_u, const F& alpha_v)
      : au_(max(alpha_u, F(kMinAlpha))),
        av_(max(alpha_v, F(kMinAlpha))),
        inverse_(1.f / (au_ * av_)) {}

  /// Returns (x / alpha_u)² + (y / alpha_v)², or the same with products: the arguments of D and G1.
  /// For isotropic roughness, x² + y² suffices.
  F over_alpha2(const Vector& v) const {
    return sqr(v.x * (av_ * inverse_)) + sqr(v.y * (au_ * inverse_));
  }
  F over_alpha2(const F& xy2) const { return xy2 * inverse_; }
  F times_alpha2(const Vector& v) const { return sqr(au_ * v.x) + sqr(av_ * v.y); }
  F times_alpha2(const F& xy2) const { return xy2 * (au_ * av_); }

  /// D divided by |h|⁴ for the normal along h; h may have any length.
  F d_along(const F& over_alpha2, const F& z) const {
    const F z2 = z * z;
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const F inverse = 1.f / z2;
      return exp(-over_alpha2 * inverse) * (kInvPi * inverse_) * sqr(inverse);
    } else {
      return kInvPi * inverse_ / sqr(over_alpha2 + z2);
    }
  }
  F d_along(const Vector& h) const { return d_along(over_alpha2(h), h.z); }
  /// Density of normals: D(m) (m . n) integrates to 1 over the hemisphere.
  F d(const Vector& m) const {
    const F value = d_along(m);
    // Returns 0 for NaN, too: m is not a direction if wi + wo = 0.
    return select(value * m.z > 1e-20f, value, F(0.f));
  }

  /// Fraction of the microfacets facing v that is visible from v, v.z > 0.
  F smith_g1(const F& times_alpha2, const F& z) const {
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const F s = sqrt(times_alpha2);  // z / s = 1 / (alpha tan theta) is a in the paper
      const F fit = z * (3.535f * s + 2.181f * z) / (times_alpha2 + z * (2.276f * s + 2.577f * z));
      return select(z >= 1.6f * s, F(1.f), fit);
    } else {
      return 2.f * z / (z + sqrt(z * z + times_alpha2));
    }
  }
  F smith_g1(const Vector& v) const { return smith_g1(times_alpha2(v), v.z); }
  F smith_g1_exact(const Vector& v) const {
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const F s = sqrt(times_alpha2(v));
      const F a = min(v.z / s, F(5.f));  // G1 is 1 above
      constexpr float kInvSqrtPi = std::numbers::inv_sqrtpi_v<float>;
      return 2.f * v.z / (2.f * v.z + exp(-a * a) * (s * kInvSqrtPi - v.z * scaled_erfc(a)));
    } else {
      return smith_g1(v);
    }
  }

  /// Samples a normal with density D(m) m.z. The `_along` version returns an unnormalised vector
  /// with z = 1.
  Vector sample_all(const Vec2Of<F>& u) const { return normalize(sample_all_along(u)); }
  Vector sample_all_along(const Vec2Of<F>& u) const {
    F r2;
    if constexpr (kType == MicrofacetType::kBeckmann) {
      r2 = -log1p(-u.y);
    } else {
      r2 = u.y / (1.f - u.y);
    }
    const F r = sqrt(r2);
    F s, c;
    sincos(2 * kPi * u.x, s, c);
    return {au_ * r * c, av_ * r * s, F(1.f)};
  }
  /// Density per solid angle of a direction reflected at such normals, where h is the sum of wi and
  /// that direction: D(m) m.z / (4 wi . m), using 4 (wi . h)² = |h|⁴.
  F mirrored_density(const F& over_alpha2, const F& z, const F& length2) const {
    return 0.5f * d_along(over_alpha2, z) * length2 * z;
  }

  /// Quantities of h = wi + wo that reflection needs.
  struct HalfVector {
    F over_alpha2;  ///< see over_alpha2()
    F z;
    F length2;  ///< squared length
  };
  struct Reflected {
    F dg;        ///< D G / (4 cos_i): f cos(theta_o) without Fresnel; 0 if not valid
    F d;         ///< density of the normal along h
    F cos_half;  ///< wi . h / |h|, for Fresnel
    MaskOf<F> is_valid;
  };
  /// Factor of dg that depends only on wi.
  F viewer_g1(const F& times_alpha2, const F& cos_i) const {
    return smith_g1(times_alpha2, cos_i) / (4.f * cos_i);
  }
  /// Evaluates reflection between wi and wo; times_alpha2 and cos_o belong to wo. Not valid if wo
  /// is below the horizon, or if both lie in the surface and are opposite; d may then overflow or
  /// be NaN.
  Reflected reflect(const HalfVector& h, const F& times_alpha2, const F& cos_o,
                    const F& viewer_g1) const {
    const F d = d_along(h.over_alpha2, h.z) * sqr(h.length2);
    const auto is_valid = cos_o > 0.f && h.length2 > 1e-12f && d * h.z > 1e-20f;
    const F dg = d * smith_g1(times_alpha2, cos_o) * viewer_g1;
    return {select(is_valid, dg, F(0.f)), d, min(0.5f * sqrt(h.length2), F(1.f)), is_valid};
  }

  /// Samples a normal visible from wi, with density G1(wi) D(m) max(0, wi . m) / wi.z.
  Vector sample_visible(const Vector& wi, const Vec2Of<F>& u) const {
    // Stretching by the roughness reduces the problem to alpha = 1.
    const Vector stretched = normalize(Vector(au_ * wi.x, av_ * wi.y, wi.z));
    if constexpr (kType == MicrofacetType::kBeckmann) {
      const F sin_theta = sqrt(sqr(stretched.x) + sqr(stretched.y));
      const F c = select(sin_theta > 0.f, stretched.x / sin_theta, F(1.f));
      const F s = select(sin_theta > 0.f, stretched.y / sin_theta, F(0.f));
      const F x = beckmann_visible_slope_x(stretched.z, sin_theta, u.x);
      const F y = beckmann_slope_y(u.y);
      return normalize(Vector(-au_ * (c * x - s * y), -av_ * (s * x + c * y), F(1.f)));
    } else {
      // Dupuy and Benyoub 2023: half vector of a uniform point on a spherical cap.
      const F z = (1.f - u.y) * (1.f + stretched.z) - stretched.z;
      const F r = safe_sqrt(1.f - z * z);
      F sine, cosine;
      sincos(2 * kPi * u.x, sine, cosine);
      const Vector h = Vector(r * cosine, r * sine, z) + stretched;
      const Vector m(au_ * h.x, av_ * h.y, max(h.z, F(0.f)));
      const F length2 = dot(m, m);
      return select(length2 > 1e-30f, m / sqrt(length2), Vector(0.f, 0.f, 1.f));
    }
  }

 private:
  F au_;
  F av_;
  F inverse_;  ///< 1 / (au av)
};

/// Reflects wi at the normal m.
template <class V>
V mirrored_at(const V& wi, const V& m) {
  return 2.f * dot(wi, m) * m - wi;
}
/// Reflects wi at the normal along h, which may have any length.
template <class V>
V mirrored_along(const V& wi, const V& h) {
  return 2.f * dot(wi, h) / dot(h, h) * h - wi;
}

/// Reflection between wi and any wo, with the density of sample(): the part that rough conductors
/// and rough plastics share.
template <MicrofacetType kType, class F = float>
class RoughReflection {
 public:
  using Vector = VecOf<F>;

  /// Sets the viewing direction; wi.z must be positive.
  RoughReflection(const F& alpha_u, const F& alpha_v, bool sample_visible, const Vector& wi)
      : microfacet_(alpha_u, alpha_v),
        wi_(wi),
        visible_(sample_visible),
        viewer_g1_(microfacet_.viewer_g1(microfacet_.times_alpha2(wi), wi.z)),
        pdf_scale_(microfacet_.smith_g1_exact(wi) / (4.f * wi.z)) {}

  struct Value {
    F dg;        ///< D G / (4 wi.z): f cos(theta_o) without Fresnel
    F pdf;       ///< per solid angle of wo
    F cos_half;  ///< wi . h, for Fresnel
  };
  /// Returns 0 if wo.z <= 0.
  Value operator()(const Vector& wo) const {
    const Vector sum = wi_ + wo;
    const typename Microfacet<kType, F>::HalfVector h{microfacet_.over_alpha2(sum), sum.z,
                                                      dot(sum, sum)};
    const auto r = microfacet_.reflect(h, microfacet_.times_alpha2(wo), wo.z, viewer_g1_);
    const F pdf = visible_ ? r.d * pdf_scale_
                           : microfacet_.mirrored_density(h.over_alpha2, h.z, h.length2);
    return {r.dg, select(r.is_valid, min(pdf, F(1e18f)), F(0.f)), r.cos_half};
  }

  /// Samples a reflection of wi at a microfacet; it may be below the horizon.
  Vector sample(const Vec2Of<F>& u) const {
    return normalize(mirrored_at(
        wi_, visible_ ? microfacet_.sample_visible(wi_, u) : microfacet_.sample_all(u)));
  }
  const Microfacet<kType, F>& microfacet() const { return microfacet_; }

 private:
  Microfacet<kType, F> microfacet_;
  Vector wi_;
  bool visible_;
  F viewer_g1_;
  F pdf_scale_;
};

/// Calls fn with the distribution's type as a constant.
template <class Fn>
auto with_microfacet_type(MicrofacetType type, const Fn& fn) {
  if (type == MicrofacetType::kBeckmann) {
    return fn(std::integral_constant<MicrofacetType, MicrofacetType::kBeckmann>{});
  }
  return fn(std::integral_constant<MicrofacetType, MicrofacetType::kGgx>{});
}

}  // namespace formulas
}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
