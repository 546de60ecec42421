#pragma once

#include <cmath>
#include <vector>

#include "kinome/bsdf.h"
#include "kit/statistics/random.h"

/// Points and lobe masks for checks of BSDFs.
namespace kinome::check {

struct Outcome;
class Subject;

/// Returns a point that is seen from wi. Its shading frame is the identity.
inline SurfaceInteraction seen_from(const Vec3& wi) {
  SurfaceInteraction si;
  si.wi = glm::normalize(wi);
  si.uv = Vec2(0.25f);
  return si;
}
/// The same, with wi given by angles in degrees.
inline SurfaceInteraction seen_at(float theta, float phi) {
  const float t = theta * kPi / 180;
  const float p = phi * kPi / 180;
  return seen_from(Vec3(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)));
}

/// Returns a random direction. It is often near the mirror direction of wi or near -wi.
inline Vec3 direction_for(const Vec3& wi, int i, Random& random) {
  const Vec3 d = random.direction();
  if (i % 3 == 0) return glm::normalize(Vec3(-wi.x, -wi.y, wi.z) + 0.1f * d);
  if (i % 3 == 1) return glm::normalize(-wi + 0.1f * d);
  return d;
}

/// Returns the lobe masks to test: each of the BSDF's lobes that isn't a delta, and all together.
inline std::vector<Lobe> masks_of(const Bsdf& bsdf) {
  std::vector<Lobe> masks;
  for (const Lobe lobe : {Lobe::kDiffuse, Lobe::kGlossy}) {
    if (any(bsdf.lobes() & lobe)) masks.push_back(lobe);
  }
  masks.push_back(Lobe::kAll);
  return masks;
}

/// Compares blocks with single points, for each instruction set that the plugin is built for.
Outcome bsdf_blocks(const Subject& subject);

}  // namespace kinome::check
