#pragma once

// Fresnel reflectance of smooth boundaries, for BSDFs and code that samples them: formulas over F,
// float or wide::Float. Not used by the core.

#include "kinome/color.h"
#include "kinome/wide/functions.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {
inline namespace formulas {

/// Unpolarised reflectance of a smooth dielectric boundary for cos_i >= 0, seen from the outside.
/// eta is the interior divided by the exterior index, as float or F; below 1, total internal
/// reflection occurs.
template <class F, class Eta>
KINOME_WIDE F fresnel_dielectric(F cos_i, Eta eta) {
  const F sin2_t = (1.f - cos_i * cos_i) * (1.f / (eta * eta));
  const F cos_t = safe_sqrt(1.f - sin2_t);
  // Computes amplitudes (a - b) / (a + b) of both polarisations over a common denominator.
  const F s = cos_i - eta * cos_t, s_below = cos_i + eta * cos_t;
  const F p = eta * cos_i - cos_t, p_below = eta * cos_i + cos_t;
  const F reflectance = 0.5f * (sqr(s * p_below) + sqr(p * s_below)) / sqr(s_below * p_below);
  // For equal indices, the formula would be 0/0 at cos_i = 0.
  return select(F(eta) == 1.f, F(0.f), select(sin2_t >= 1.f, F(1.f), reflectance));
}

/// Reflection and refraction at a smooth dielectric boundary, from either side.
template <class F>
struct DielectricBoundary {
  F reflectance;
  F cos_t;   ///< cosine of the refraction angle, >= 0; 0 for total internal reflection
  F eta_ti;  ///< index on the incident side divided by that on the other side
};
/// Evaluates a boundary. cos_i is relative to the normal, negative from the inside; eta is the
/// interior divided by the exterior index.
template <class F>
KINOME_WIDE DielectricBoundary<F> dielectric_boundary(F cos_i, float eta) {
  const auto is_outside = cos_i > 0.f;
  const F cosine = min(abs(cos_i), F(1.f));
  const F eta_ti = select(is_outside, F(1 / eta), F(eta));
  return {select(is_outside, fresnel_dielectric(cosine, eta), fresnel_dielectric(cosine, 1 / eta)),
          safe_sqrt(1.f - (1.f - cosine * cosine) * (eta_ti * eta_ti)), eta_ti};
}

/// Unpolarised reflectance of a conductor with index eta + i k, for one channel; exact.
template <class F>
KINOME_WIDE F fresnel_conductor(F cos_i, F eta, F k) {
  const F cos2 = cos_i * cos_i;
  const F sin2 = 1.f - cos2;
  const F t = eta * eta - k * k - sin2;
  const F a2_plus_b2 = safe_sqrt(t * t + 4.f * eta * eta * k * k);
  const F a = safe_sqrt(0.5f * (a2_plus_b2 + t));
  const F c = 2.f * cos_i * a;
  // Mean of s = (s_sum - c) / (s_sum + c) and p = s (p_sum - c sin2) / (p_sum + c sin2).
  // Denominators are 0 only if the numerators are: at grazing incidence on a medium that equals the
  // outside, where everything is reflected.
  const F s_sum = a2_plus_b2 + cos2;
  const F p_sum = a2_plus_b2 * cos2 + sin2 * sin2;
  const F denominator = (s_sum + c) * (p_sum + c * sin2);
  return select(denominator > 0.f, max((s_sum - c) * p_sum / denominator, F(0.f)), F(1.f));
}
template <class F>
RgbOf<F> fresnel_conductor(F cos_i, const RgbOf<F>& eta, const RgbOf<F>& k) {
  return {fresnel_conductor(cos_i, eta.x, k.x), fresnel_conductor(cos_i, eta.y, k.y),
          fresnel_conductor(cos_i, eta.z, k.z)};
}

/// Hemispherical mean of fresnel_dielectric() for diffuse light, by the fits that Mitsuba 3 uses:
/// Egan and Hilgeman 1973 for eta < 1, d'Eon and Irving 2011 otherwise.
inline float fresnel_diffuse_reflectance(float eta) {
  const float r = 1 / eta;
  if (eta < 1) {
    return -1.4399f * eta * eta + 0.7099f * eta + 0.6681f + 0.0636f * r;
  }
  return 0.919317f +
         r * (-3.4793f + r * (6.75335f + r * (-7.80989f + r * (4.98554f - 1.36881f * r))));
}

}  // namespace formulas
}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
