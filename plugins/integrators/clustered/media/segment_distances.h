#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/color.h"
#include "kinome/math.h"

namespace kinome {

/// Distances along a ray, 0 <= t <= length, whose density is proportional to 1/r², where r is the
/// distance to a point p (Kulla and Fajardo 2012). If p is nearer to the ray than `nearest`, it is
/// moved to this distance, so that the density is finite.
class EquiangularDistances {
 public:
  EquiangularDistances(const Vec3& o, const Vec3& d, float length, const Vec3& p, float nearest)
      : length_(length) {
    const Vec3 to = p - o;
    centre_ = glm::dot(to, d);
    distance_ = std::max(glm::length(to - centre_ * d), nearest);
    // atan2 of the difference of the tangents, exact even if both angles are nearly equal.
    const float last = length - centre_;
    angle_ = std::atan2(distance_ * length, distance_ * distance_ - centre_ * last);
  }

  /// Integral of 1/r² along the ray.
  float integral() const { return angle_ / distance_; }
  /// Maps u in [0, 1] to a distance.
  float at(float u) const {
    const float tangent = std::tan(u * angle_);
    const float r2 = distance_ * distance_ + centre_ * centre_;
    const float t = tangent * r2 / (distance_ + centre_ * tangent);
    // If rounding moves the angle beyond that of an infinite distance, t is negative.
    return t >= 0 ? std::min(t, length_) : length_;
  }
  /// Density of at(u) for uniform u, per unit of length.
  float density(float t) const {
    const float along = t - centre_;
    return distance_ / (angle_ * (distance_ * distance_ + along * along));
  }

 private:
  float length_, centre_, distance_, angle_;
};

/// Distances along a ray, 0 <= t <= length, whose density is proportional to exp(-extinction t).
/// The extinction must be positive.
class AttenuatedDistances {
 public:
  AttenuatedDistances(float extinction, float length)
      : extinction_(extinction), length_(length), absorbed_(-std::expm1(-extinction * length)) {}

  /// 1 - exp(-extinction length).
  float absorbed() const { return absorbed_; }
  float at(float u) const { return std::min(-std::log1p(-u * absorbed_) / extinction_, length_); }
  float density(float t) const { return extinction_ * std::exp(-extinction_ * t) / absorbed_; }

 private:
  float extinction_, length_, absorbed_;
};

/// Returns the smallest positive extinction of the channels. Densities of distances in proportion
/// to its transmittance decrease no faster than the transmittance of any other channel with
/// extinction.
inline float min_extinction(const Rgb& extinction) {
  float least = kInfinity;
  for (int c = 0; c < 3; ++c) {
    if (extinction[c] > 0) least = std::min(least, extinction[c]);
  }
  return least;
}

}  // namespace kinome
