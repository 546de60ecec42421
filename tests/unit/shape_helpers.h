#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "check/random.h"
#include "check/rays.h"
#include "support/render.h"

namespace kinome::test {

using namespace check;

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

/// A direction away from a surface with this normal, the more often the flatter: its cosine is a power
/// of ten, uniform from `least` to 0.
inline Vec3 grazing_direction(Random& random, const Vec3& n, float least) {
  const float z = std::pow(10.f, random.between(least, 0)), phi = random.between(0, 2 * kPi);
  const float r = safe_sqrt(1 - z * z);
  return Frame::from_normal(n).to_world({r * std::cos(phi), r * std::sin(phi), z});
}

/// How many of these rays meet anything.
inline int count_hits(const Scene& scene, std::vector<RayHit> rays) {
  RenderCounters counters;
  scene.intersect(rays, Coherence::kIncoherent, counters);
  return static_cast<int>(std::count_if(rays.begin(), rays.end(),
                                        [](const RayHit& ray) { return ray.hit.valid(); }));
}

}  // namespace kinome::test
