#pragma once

// Reflectance of smooth boundaries (Fresnel), for BSDFs and for what samples them: formulas over
// numbers F, float or wide::Float. The core has no use for them.

#include "kinome/color.h"
#include "kinome/wide/functions.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {
inline namespace formulas {

/// Unpolarised reflectance of a smooth dielectric boundary, seen at cos_i >= 0 from the outside;
/// eta = interior over exterior index (below 1: total reflection happens).
template <class F>
KINOME_WIDE F fresnel_dielectric(F cos_i, float eta) {
  const F sin2_t = (1.f - cos_i * cos_i) / (eta * eta);
  const F cos_t = safe_sqrt(1.f - sin2_t);
  const F s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const F p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const F reflectance = 0.5f * (s * s + p * p);
  // Equal indices reflect nothing; at cos_i = 0 the formula would be 0/0 there.
  return eta == 1 ? F(0.f) : select(sin2_t >= 1.f, F(1.f), reflectance);
}

/// Unpolarised reflectance of a conductor of index eta + i k (one channel), exact.
template <class F>
KINOME_WIDE F fresnel_conductor(F cos_i, F eta, F k) {
  const F cos2 = cos_i * cos_i;
  const F sin2 = 1.f - cos2;
  const F t = eta * eta - k * k - sin2;
  const F a2_plus_b2 = safe_sqrt(t * t + 4.f * eta * eta * k * k);
  const F a = safe_sqrt(0.5f * (a2_plus_b2 + t));
  const F c = 2.f * cos_i * a;
  // The pairs of sums differ by positive terms, so denominators vanish only together with
  // numerators: at grazing incidence on a medium like the outside, where all is reflected.
  const F s_numerator = a2_plus_b2 + cos2 - c;
  const F s_denominator = a2_plus_b2 + cos2 + c;
  const F s = select(s_denominator > 0.f, s_numerator / s_denominator, F(1.f));
  const F p_sum = a2_plus_b2 * cos2 + sin2 * sin2;
  const F p_denominator = p_sum + c * sin2;
  const F p = select(p_denominator > 0.f, (p_sum - c * sin2) / p_denominator, F(1.f));
  return max(0.5f * (s + s * p), F(0.f));
}
template <class F>
RgbOf<F> fresnel_conductor(F cos_i, const RgbOf<F>& eta, const RgbOf<F>& k) {
  return {fresnel_conductor(cos_i, eta.x, k.x), fresnel_conductor(cos_i, eta.y, k.y),
          fresnel_conductor(cos_i, eta.z, k.z)};
}

/// Hemispherical mean of fresnel_dielectric under diffuse light. The fits that Mitsuba 3 uses: Egan
/// and Hilgeman 1973 below eta = 1, d'Eon and Irving 2011 above.
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
