#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "kit/scenes/rays.h"
#include "kit/statistics/random.h"
#include "support/render.h"

namespace kinome::test {

using namespace check;

/// Returns the message of the Error that `action` throws, or "" if it throws none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

/// Samples a direction away from a surface with this normal. Grazing directions are frequent,
/// because the cosine is a power of ten whose exponent is uniform from `min_exponent` to 0.
inline Vec3 grazing_direction(Random& random, const Vec3& n, float min_exponent) {
  const float z = std::pow(10.f, random.between(min_exponent, 0)), phi = random.between(0, 2 * kPi);
  const float r = safe_sqrt(1 - z * z);
  return Frame::from_normal(n).to_world({r * std::cos(phi), r * std::sin(phi), z});
}

/// Counts the rays that hit anything.
inline int count_hits(const Scene& scene, std::vector<RayHit> rays) {
  RenderCounters counters;
  scene.intersect(rays, Coherence::kIncoherent, counters);
  return static_cast<int>(std::count_if(rays.begin(), rays.end(),
                                        [](const RayHit& ray) { return ray.hit.valid(); }));
}

}  // namespace kinome::test
