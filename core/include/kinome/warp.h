#pragma once

#include "kinome/math.h"

/// Maps from uniform random numbers in [0, 1)² to distributions over disks and spheres, each with
/// its density. All are continuous and defined for every float in [0, 1].
namespace kinome {

/// Uniform over the unit disk; keeps neighbours together and strata compact (Shirley and Chiu
/// 1997, without branches over the four triangles). Density 1/pi per area.
inline Vec2 square_to_disk_concentric(const Vec2& u) {
  const float x = 2 * u.x - 1;
  const float y = 2 * u.y - 1;
  const bool x_larger = std::abs(x) > std::abs(y);
  const float r = x_larger ? x : y;
  const float ratio = r == 0 ? 0.f : (x_larger ? y : x) / r;
  const float angle = (kPi / 4) * ratio;
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  return x_larger ? Vec2(r * c, r * s) : Vec2(r * s, r * c);
}

/// Its inverse, for points of the disk.
inline Vec2 disk_to_square_concentric(const Vec2& p) {
  const bool x_larger = std::abs(p.x) > std::abs(p.y);
  const float large = x_larger ? p.x : p.y, small = x_larger ? p.y : p.x;
  const float r = std::copysign(glm::length(p), large);
  const float other = large == 0 ? 0.f : r * std::atan(small / large) * (4 / kPi);
  return 0.5f * (Vec2(x_larger ? r : other, x_larger ? other : r) + 1.f);
}

/// Density cos(theta)/pi per solid angle around +Z; never returns a direction with z = 0.
inline Vec3 square_to_cosine_hemisphere(const Vec2& u) {
  const Vec2 p = square_to_disk_concentric(u);
  return {p.x, p.y, std::max(safe_sqrt(1 - glm::dot(p, p)), 1e-7f)};
}
inline float cosine_hemisphere_pdf(float cos_theta) {
  return std::max(cos_theta, 0.f) * kInvPi;
}

/// The direction with cos(theta) = z and azimuth phi.
inline Vec3 spherical_direction(float z, float phi) {
  const float r = safe_sqrt(1 - z * z);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Uniform over the upper hemisphere: density 1/(2 pi) per solid angle.
inline Vec3 square_to_uniform_hemisphere(const Vec2& u) {
  return spherical_direction(1 - u.y, 2 * kPi * u.x);
}
inline constexpr float kUniformHemispherePdf = 0.5f * kInvPi;

/// Uniform over the sphere: density 1/(4 pi) per solid angle.
inline Vec3 square_to_uniform_sphere(const Vec2& u) {
  // r from 1 - z² = 4 v (1 - v): no cancellation near the poles.
  const float r = 2 * safe_sqrt(u.y * (1 - u.y));
  const float phi = 2 * kPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), 1 - 2 * u.y};
}
inline constexpr float kUniformSpherePdf = 0.25f * kInvPi;

/// Uniform over the cone of directions with cos(theta) >= cos_max around +Z: density
/// 1/(2 pi (1 - cos_max)) per solid angle.
inline Vec3 square_to_uniform_cone(const Vec2& u, float cos_max) {
  // 1 - z is kept as it is, so that narrow cones don't lose their digits.
  const float d = u.y * (1 - cos_max);
  const float r = safe_sqrt(d * (2 - d));
  const float phi = 2 * kPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), 1 - d};
}
inline float uniform_cone_pdf(float cos_max) {
  return 1 / (2 * kPi * (1 - cos_max));
}

/// Density (n + 1)/(2 pi) cos(theta)^n per solid angle around +Z: Phong's lobe.
inline Vec3 square_to_cosine_power(const Vec2& u, float n) {
  // 1 - cos² as expm1, or large exponents lose all digits of the sine.
  const float log_cos = std::log(1 - u.y) / (n + 1);
  const float r = safe_sqrt(-std::expm1(2 * log_cos));
  const float phi = 2 * kPi * u.x;
  return {r * std::cos(phi), r * std::sin(phi), std::exp(log_cos)};
}

}  // namespace kinome
