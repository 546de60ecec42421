#pragma once

#include <cmath>

#include "clustered/cells/channel_mean.h"
#include "kinome/color.h"
#include "kinome/sampler.h"

/// Small helper functions of the estimator.
namespace kinome {

/// Fractional parts of multiples of these numbers are spread evenly (Roberts 2018). They are the
/// inverse golden ratio, and its equivalent for a second dimension, in units of 2^-32, where
/// multiples wrap around exactly.
inline constexpr uint32_t kGolden = 2654435769u;
inline constexpr uint32_t kPlastic = 3242174889u;

/// floor(share x count) for a share in units of 2^-32.
inline uint32_t scaled(uint32_t share, uint32_t count) {
  return static_cast<uint32_t>(static_cast<uint64_t>(share) * count >> 32);
}
/// Counter-based random number (Salmon et al. 2011) of a well-mixed seed. The counter has steps of
/// 2^64 / the golden ratio.
inline uint32_t random_bits(uint64_t seed, uint32_t index) {
  return static_cast<uint32_t>(mix_bits(seed + (index + 1ull) * 0x9e3779b97f4a7c15u) >> 32);
}
inline float random_float(uint64_t seed, uint32_t index) {
  return to_unit_float(random_bits(seed, index));
}
inline Vec3 normalized(const Vec3& v, const Vec3& otherwise) {
  const float length2 = glm::dot(v, v);
  return length2 > 1e-12f ? v / std::sqrt(length2) : otherwise;
}

}  // namespace kinome
