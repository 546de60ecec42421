#include "transport/media/bodies/boundaries.h"

#include <algorithm>
#include <optional>

#include "kinome/sampler.h"
#include "kinome/warp.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

namespace {

constexpr int kRays = 32;
/// Number of surfaces of a ray; rays through more of them are not counted.
constexpr int kMaxCrossings = 64;
/// Boundaries are closed if fewer than this part of the rays find something else. Rays may miss one
/// of two surfaces at the same position.
constexpr int kMinPart = 8;
/// Smaller boundaries, relative to their coordinates, are lost in rounding errors.
constexpr float kMinSize = 1e-5f;

/// Balance of a ray.
struct Crossings {
  int depth = 0;                 ///< number of times that it entered the medium, minus that it left
  int min_depth = 0;             ///< smallest depth on the way
  const Shape* shape = nullptr;  ///< the last one where it entered or left the medium
};

/// Returns nullopt for a ray through too many surfaces.
std::optional<Crossings> crossings_of(const Medium& medium, const Scene& scene, Ray ray) {
  Crossings found;
  RenderCounters counters;
  for (int i = 0; i < kMaxCrossings; ++i) {
    RayHit hit{ray, {}};
    scene.intersect({&hit, 1}, Coherence::kIncoherent, counters);
    if (!hit.hit.valid()) return found;
    const SurfaceInteraction si = scene.interaction(hit);
    if (!si.shape->curves()) {
      const int side = (si.shape->interior() == &medium) - (si.shape->exterior() == &medium);
      const int change = glm::dot(si.n, ray.d) < 0 ? side : -side;
      found.depth += change;
      found.min_depth = std::min(found.min_depth, found.depth);
      if (change != 0) found.shape = si.shape;
    }
    const float distance = distance_behind(ray, si.p, si.n, si.p_error);
    ray.o += distance * ray.d;
    ray.tmax -= distance;
  }
  return std::nullopt;
}

}  // namespace

Boundary boundary_of(const Medium& medium, const Scene& scene) {
  Aabb box;
  for (const auto& shape : scene.shapes()) {
    if (shape->interior() == &medium && shape->exterior() != &medium) box.expand(shape->bounds());
  }
  if (box.empty()) return {};
  const float size = glm::length(box.extent());
  if (!(size > kMinSize * glm::length(glm::max(glm::abs(box.lo), glm::abs(box.hi))))) return {};
  int met = 0, open = 0, inside_out = 0;
  Boundary found;
  for (uint64_t i = 0; i < kRays; ++i) {
    const auto unit = [i](uint64_t use) {
      return to_unit_float(static_cast<uint32_t>(hash_words(i, use) >> 32));
    };
    const Vec3 d = square_to_uniform_sphere(Vec2(unit(0), unit(1)));
    const Vec3 p = box.lo + Vec3(unit(2), unit(3), unit(4)) * box.extent();
    const auto crossings = crossings_of(medium, scene, Ray(p - 2 * size * d, d, 0, 4 * size));
    if (!crossings || !crossings->shape) continue;
    ++met;
    open += crossings->depth != 0;
    inside_out += crossings->depth == 0 && crossings->min_depth < 0;
    if (crossings->depth != 0 || crossings->min_depth < 0) found.shape = crossings->shape;
  }
  if (kMinPart * open > met) {
    found.kind = Boundary::Kind::kOpen;
  } else if (kMinPart * inside_out > met) {
    found.kind = Boundary::Kind::kInverted;
  } else {
    return {};
  }
  return found;
}

}  // namespace kinome::transport
