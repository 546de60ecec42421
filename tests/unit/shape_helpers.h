#pragma once

#include <string>
#include <utility>
#include <vector>

#include "kinome/sampler.h"
#include "kinome/scene.h"
#include "support/render.h"

namespace kinome::test {

/// Repeatable random numbers.
class Random {
 public:
  explicit Random(uint64_t seed) : seed_(seed) {}
  float unit() { return to_unit_float(static_cast<uint32_t>(hash_words(seed_, counter_++))); }
  float between(float lo, float hi) { return lo + (hi - lo) * unit(); }
  Vec3 direction() {
    const float z = between(-1, 1);
    const float phi = between(0, 2 * kPi);
    const float r = safe_sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  uint64_t seed_;
  uint64_t counter_ = 0;
};

inline RayHit ray_hit(const Vec3& o, const Vec3& d) {
  RayHit ray;
  ray.ray.o = o;
  ray.ray.d = d;
  return ray;
}

/// The nearest hit of one ray.
inline RayHit trace(const Scene& scene, const Vec3& o, const Vec3& d) {
  RayHit ray = ray_hit(o, d);
  RenderCounters counters;
  scene.intersect({&ray, 1}, Coherence::kIncoherent, counters);
  return ray;
}

/// Message of the Error that `action` throws; "" where it throws none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace kinome::test
