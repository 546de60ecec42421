#include "transport/media/bodies/enclosed_media.h"

#include <algorithm>

namespace kinome::transport {

namespace {

bool is_inside(const Vec3& p, const Aabb& box) {
  return glm::all(glm::lessThanEqual(box.lo, p)) && glm::all(glm::lessThanEqual(p, box.hi));
}

/// True if the emitter may be inside of the box.
bool may_be_inside(const Emitter& emitter, const Aabb& box) {
  if (emitter.is_environment()) return false;
  if (emitter.is_surface()) {
    const Aabb own = emitter.shape()->bounds();
    return is_inside(own.lo, box) && is_inside(own.hi, box);
  }
  if (!emitter.is_delta()) return true;
  const auto ray = emitter.sample_emission(Vec2(0.5f), Vec2(0.5f));
  return !ray || is_inside(ray->o, box);
}

}  // namespace

bool is_unbounded(const Medium& medium, const Scene& scene) {
  return medium.box().hi.x == kInfinity &&
         std::none_of(scene.shapes().begin(), scene.shapes().end(),
                      [&](const auto& shape) { return shape->interior() == &medium; });
}

bool is_enclosed(const Medium& medium, const Scene& scene, const Sensor& sensor) {
  if (sensor.medium() == &medium) return false;
  Aabb box;
  for (const auto& shape : scene.shapes()) {
    if (shape->exterior() == &medium) return false;
    if (shape->interior() != &medium) continue;
    if (shape->bsdf().has_null_lobe() || shape->emitter()) return false;
    box.expand(shape->bounds());
  }
  return std::none_of(scene.emitters().begin(), scene.emitters().end(),
                      [&](const auto& emitter) { return may_be_inside(*emitter, box); });
}

}  // namespace kinome::transport
