#pragma once

#include <cstdint>

#include "kinome/math.h"

namespace kinome {

/// Ray segment o + t d, tmin <= t <= tmax, in the layout of Embree's RTCRay, so that batches need
/// no copies. d need not have unit length. Scene::occluded() sets tmax to -infinity if the segment
/// is occluded.
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

/// Index of a hit that doesn't exist.
inline constexpr uint32_t kNoHit = ~0u;

/// Ray hit in the layout of Embree's RTCHit.
struct alignas(16) Hit {
  Vec3 ng{0.f};  ///< geometric normal as Embree computes it; not normalised
  float u = 0;   ///< barycentric or surface coordinates, as defined by the shape
  float v = 0;
  uint32_t primitive = kNoHit;
  uint32_t shape = kNoHit;  ///< index into Scene::shapes(), or kNoHit
  uint32_t instance = kNoHit;
  bool valid() const { return shape != kNoHit; }
};

/// Ray and hit in the layout of Embree's RTCRayHit. Scene::intersect() sets ray.tmax to the
/// distance of the hit.
struct RayHit {
  Ray ray;
  Hit hit;
};

}  // namespace kinome
