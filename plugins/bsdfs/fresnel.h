#pragma once

#include <array>
#include <iterator>

#include "kinome/color.h"
#include "kinome/properties.h"

namespace kinome {

/// Unpolarised reflectance of a smooth dielectric boundary, seen at cos_i >= 0 from the outside;
/// eta = interior over exterior index (below 1: total reflection happens).
inline float fresnel_dielectric(float cos_i, float eta) {
  const float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  const float cos_t = safe_sqrt(1 - sin2_t);
  const float s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  const float p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
  const float reflectance = 0.5f * (s * s + p * p);
  // Equal indices reflect nothing; at cos_i = 0 the formula would be 0/0 there.
  return eta == 1 ? 0.f : sin2_t >= 1 ? 1.f : reflectance;
}

/// Unpolarised reflectance of a conductor of index eta + i k (one channel), exact.
inline float fresnel_conductor(float cos_i, float eta, float k) {
  const float cos2 = cos_i * cos_i;
  const float sin2 = 1 - cos2;
  const float t = eta * eta - k * k - sin2;
  const float a2_plus_b2 = safe_sqrt(t * t + 4 * eta * eta * k * k);
  const float a = safe_sqrt(0.5f * (a2_plus_b2 + t));
  const float c = 2 * cos_i * a;
  // The pairs of sums differ by positive terms, so denominators vanish only together with
  // numerators: at grazing incidence on a medium like the outside, where all is reflected.
  const float s_numerator = a2_plus_b2 + cos2 - c;
  const float s_denominator = a2_plus_b2 + cos2 + c;
  const float s = s_denominator > 0 ? s_numerator / s_denominator : 1.f;
  const float p_sum = a2_plus_b2 * cos2 + sin2 * sin2;
  const float p_denominator = p_sum + c * sin2;
  const float p = p_denominator > 0 ? (p_sum - c * sin2) / p_denominator : 1.f;
  return std::max(0.5f * (s + s * p), 0.f);
}
inline Rgb fresnel_conductor(float cos_i, const Rgb& eta, const Rgb& k) {
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

/// Indices of refraction by name (those that Mitsuba knows).
inline constexpr NamedNumber kIndicesOfRefraction[] = {
    {"vacuum", 1.f},       {"helium", 1.000036f},        {"hydrogen", 1.000132f},
    {"air", 1.000277f},    {"carbon dioxide", 1.00045f}, {"water", 1.333f},
    {"acetone", 1.36f},    {"ethanol", 1.361f},          {"carbon tetrachloride", 1.461f},
    {"glycerol", 1.4729f}, {"benzene", 1.501f},          {"silicone oil", 1.52045f},
    {"bromine", 1.661f},   {"water ice", 1.31f},         {"fused quartz", 1.458f},
    {"pyrex", 1.47f},      {"acrylic glass", 1.49f},     {"polypropylene", 1.49f},
    {"bk7", 1.5046f},      {"sodium chloride", 1.544f},  {"amber", 1.55f},
    {"pet", 1.575f},       {"diamond", 2.419f},
};

/// int_ior / ext_ior of a dielectric's properties, both within what has squares and inverses.
inline float relative_ior(const Properties& props) {
  constexpr float kLeast = 1e-3f, kMost = 1e3f;
  const auto index = [&](const char* name) {
    const float value = props.number_or_name(name, kIndicesOfRefraction);
    if (!(value > 0) || !std::isfinite(value)) {
      throw props.error(name, "must be positive, got " + std::to_string(value));
    }
    if (value < kLeast || value > kMost) {
      throw props.error(name, "must be from 0.001 to 1000, got " + std::to_string(value));
    }
    return value;
  };
  return index("int_ior") / index("ext_ior");
}

}  // namespace kinome
