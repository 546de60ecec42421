#pragma once

#include <algorithm>
#include <cmath>

#include "kinome/math.h"

namespace kinome {

/// Distances along a ray, 0 <= t <= length, whose density is proportional to 1/r², where r is the
/// distance to a point p (Kulla and Fajardo 2012). Nearer than `nearest`, p is moved away from the
/// ray, so that the density is finite.
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
    // The tangent changes its sign at a right angle, beyond which t keeps growing.
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

}  // namespace kinome
