#pragma once

#include <cstdint>

#include "kinome/math.h"

namespace kinome {

/// A ray segment o + t d, tmin <= t <= tmax, laid out as Embree's RTCRay, so that batches need no
/// copying. d need not be of unit length. After Scene::occluded, tmax is -infinity where something
/// lies on the segment.
struct alignas(16) Ray {
  Vec3 o{0.f};
  float tmin = 0;
  Vec3 d{0, 0, 1};
  float time = 0;
  float tmax = kInfinity;
  uint32_t mask = ~0u;
  uint32_t id = 0;
  uint32_t flags = 0;

  Ray() = default;
  Ray(const Vec3& origin, const Vec3& direction, float first_t = 0, float last_t = kInfinity)
      : o(origin), tmin(first_t), d(direction), tmax(last_t) {}

  Vec3 at(float t) const { return o + d * t; }
  bool is_occluded() const { return tmax < 0; }
};

inline constexpr uint32_t kNoHit = ~0u;

/// Laid out as Embree's RTCHit.
struct alignas(16) Hit {
  Vec3 ng{0.f};  ///< geometric normal as Embree leaves it: not normalised
  float u = 0;   ///< barycentric or surface coordinates, as the shape defines them
  float v = 0;
  uint32_t primitive = kNoHit;
  uint32_t shape = kNoHit;  ///< index into Scene::shapes(), or kNoHit
  uint32_t instance = kNoHit;
  bool valid() const { return shape != kNoHit; }
};

/// Laid out as Embree's RTCRayHit. After Scene::intersect, ray.tmax is the distance of the hit.
struct RayHit {
  Ray ray;
  Hit hit;
};

}  // namespace kinome
