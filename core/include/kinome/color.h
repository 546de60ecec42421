#pragma once

#include <cmath>

#include "kinome/math.h"

namespace kinome {

/// Radiance, irradiance, reflectance or weight per channel, with linear Rec.709 (sRGB) primaries
/// and white D65.
using Rgb = glm::vec3;

/// Relative luminance: CIE Y of linear Rec.709, with Mitsuba's coefficients. (Åkerlund 2008, 3.1.1
/// rounds them to four digits.)
inline float luminance(const Rgb& c) {
  return 0.212671f * c.x + 0.715160f * c.y + 0.072169f * c.z;
}
/// Converts linear Rec.709 to CIE XYZ; Y is luminance().
inline glm::dvec3 xyz(const glm::dvec3& c) {
  return {0.412453 * c.x + 0.357580 * c.y + 0.180423 * c.z,
          0.212671 * c.x + 0.715160 * c.y + 0.072169 * c.z,
          0.019334 * c.x + 0.119193 * c.y + 0.950227 * c.z};
}
inline bool is_black(const Rgb& c) {
  return c.x == 0 && c.y == 0 && c.z == 0;
}

inline float srgb_to_linear(float v) {
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
inline float linear_to_srgb(float v) {
  return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

}  // namespace kinome
