#pragma once

#include <type_traits>

#include "kinome/math.h"

/// Maps from uniform random numbers in [0, 1)² to distributions over disks and spheres, with their
/// densities. All are continuous, and defined for every float in [0, 1].
namespace kinome {

/// Formulas for scalar and wide numbers: V3, V2 and F are Vec3, Vec2 and float, or the types of
/// kinome/wide.
namespace warp {

template <class V2>
V2 square_to_disk_concentric(const V2& u) {
  using plain::select, std::abs, std::cos, std::sin;
  using F = std::remove_cvref_t<decltype(u.x)>;
  const F x = 2.f * u.x - 1.f;
  const F y = 2.f * u.y - 1.f;
  const auto x_larger = abs(x) > abs(y);
  const F r = select(x_larger, x, y);
  const F ratio = select(r == 0.f, F(0.f), select(x_larger, y, x) / r);
  const F angle = (kPi / 4) * ratio;
  const F c = cos(angle);
  const F s = sin(angle);
  return {r * select(x_larger, c, s), r * select(x_larger, s, c)};
}

template <class F>
F cosine_hemisphere_pdf(F cos_theta) {
  using std::max;
  return max(cos_theta, F(0.f)) * kInvPi;
}

template <class V3, class V2>
V3 square_to_cosine_hemisphere(const V2& u) {
  using std::max;
  using F = std::remove_cvref_t<decltype(u.x)>;
  const V2 p = square_to_disk_concentric(u);
  return {p.x, p.y, max(safe_sqrt(1.f - dot(p, p)), F(1e-7f))};
}

template <class V3, class V2>
V3 square_to_uniform_sphere(const V2& u) {
  using std::cos, std::sin;
  using F = std::remove_cvref_t<decltype(u.x)>;
  // Computes r from 1 - z² = 4 v (1 - v), which avoids cancellation near the poles.
  const F r = 2.f * safe_sqrt(u.y * (1.f - u.y));
  const F phi = (2 * kPi) * u.x;
  return {r * cos(phi), r * sin(phi), 1.f - 2.f * u.y};
}

template <class V3, class V2, class F>
V3 square_to_cosine_power(const V2& u, F n) {
  using std::cos, std::exp, std::expm1, std::log, std::sin;
  // Computes 1 - cos² by expm1(); otherwise large exponents lose all digits of the sine.
  const F log_cos = log(1.f - u.y) / (n + 1.f);
  const F r = safe_sqrt(-expm1(2.f * log_cos));
  const F phi = (2 * kPi) * u.x;
  return {r * cos(phi), r * sin(phi), exp(log_cos)};
}

/// Returns the unit vector with cos(theta) = z and azimuth phi.
template <class V3, class F>
V3 spherical_direction(F z, F phi) {
  using std::cos, std::sin;
  const F r = safe_sqrt(1.f - z * z);
  return {r * cos(phi), r * sin(phi), z};
}

template <class V3, class V2>
V3 square_to_uniform_hemisphere(const V2& u) {
  using F = std::remove_cvref_t<decltype(u.x)>;
  return spherical_direction<V3, F>(1.f - u.y, (2 * kPi) * u.x);
}

}  // namespace warp

/// Uniform over the unit disk, with density 1/pi per area. Preserves neighbourhoods and compact
/// strata (Shirley and Chiu 1997, without branches over the four triangles).
inline Vec2 square_to_disk_concentric(const Vec2& u) {
  return warp::square_to_disk_concentric(u);
}

/// Inverse of square_to_disk_concentric(), for points of the disk.
inline Vec2 disk_to_square_concentric(const Vec2& p) {
  const bool x_larger = std::abs(p.x) > std::abs(p.y);
  const float large = x_larger ? p.x : p.y, small = x_larger ? p.y : p.x;
  const float r = std::copysign(glm::length(p), large);
  const float other = large == 0 ? 0.f : r * std::atan(small / large) * (4 / kPi);
  return 0.5f * (Vec2(x_larger ? r : other, x_larger ? other : r) + 1.f);
}

/// Density cos(theta)/pi per solid angle around +Z. Never returns a direction with z = 0.
inline Vec3 square_to_cosine_hemisphere(const Vec2& u) {
  return warp::square_to_cosine_hemisphere<Vec3>(u);
}
inline float cosine_hemisphere_pdf(float cos_theta) {
  return warp::cosine_hemisphere_pdf(cos_theta);
}

inline Vec3 spherical_direction(float z, float phi) {
  return warp::spherical_direction<Vec3>(z, phi);
}

/// Uniform over the upper hemisphere: density 1/(2 pi) per solid angle.
inline Vec3 square_to_uniform_hemisphere(const Vec2& u) {
  return warp::square_to_uniform_hemisphere<Vec3>(u);
}
inline constexpr float kUniformHemispherePdf = 0.5f * kInvPi;

/// Uniform over the sphere: density 1/(4 pi) per solid angle.
inline Vec3 square_to_uniform_sphere(const Vec2& u) {
  return warp::square_to_uniform_sphere<Vec3>(u);
}
inline constexpr float kUniformSpherePdf = 0.25f * kInvPi;

/// Density (n + 1)/(2 pi) cos(theta)^n per solid angle around +Z: the Phong lobe.
inline Vec3 square_to_cosine_power(const Vec2& u, float n) {
  return warp::square_to_cosine_power<Vec3>(u, n);
}

}  // namespace kinome
