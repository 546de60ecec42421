#pragma once

#include <cmath>

#include "kinome/color.h"
#include "kinome/sampler.h"

/// Small tools of the estimator.
namespace kinome {

/// Fractional parts of multiples of these spread evenly (Roberts 2018): of the golden ratio, and
/// of its relatives for a second and third number.
inline constexpr float kGolden = 0.61803399f;
inline constexpr float kPlastic = 0.75487767f;
inline constexpr float kPlastic2 = 0.56984029f;

inline float fraction(float x) {
  return x - std::floor(x);
}
inline float random_float(uint64_t seed, uint32_t index) {
  return to_unit_float(static_cast<uint32_t>(hash_words(seed, index) >> 32));
}
inline Vec3 normalized(const Vec3& v, const Vec3& otherwise) {
  const float length2 = glm::dot(v, v);
  return length2 > 1e-12f ? v / std::sqrt(length2) : otherwise;
}
/// What importance is measured by: errors of all channels count alike.
inline float mean_of(const Rgb& c) {
  return (c.x + c.y + c.z) * (1 / 3.f);
}

}  // namespace kinome
