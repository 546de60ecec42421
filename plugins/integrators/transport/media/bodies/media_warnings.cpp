#include "transport/media/bodies/media_warnings.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "kinome/error.h"
#include "kinome/log.h"
#include "transport/media/bodies/boundaries.h"
#include "transport/media/bodies/enclosed_media.h"
#include "transport/media/bodies/media_table.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

namespace {

/// Number of media whose boundaries are examined.
constexpr size_t kMaxExaminedMedia = 64;
/// Free paths must be longer than this part of the coordinates. Rounding errors are a tenth of it.
constexpr float kMinFreePath = 1e-6f;

using FaultyMedia = std::set<const Medium*>;

/// Plugin and id of a shape.
std::string name_of(const Shape& shape) {
  return shape.plugin() + (shape.id().empty() ? "" : " '" + shape.id() + "'");
}

void warn_at(const Scene& scene, const std::string& message) {
  log_warn(Error(Location{scene.file()}, message).what());
}

/// Warns of media whose shapes aren't closed, or inside out. Returns these media.
FaultyMedia warn_of_boundaries(const Scene& scene) {
  FaultyMedia faulty;
  const size_t count = std::min(scene.media().size(), kMaxExaminedMedia);
  for (size_t i = 0; i < count; ++i) {
    const Boundary boundary = boundary_of(*scene.media()[i], scene);
    if (boundary.kind == Boundary::Kind::kClosed) continue;
    faulty.insert(scene.media()[i]);
    warn_at(
        scene,
        boundary.kind == Boundary::Kind::kOpen
            ? name_of(*boundary.shape) +
                  " has a medium inside but isn't closed, so that the medium doesn't end behind "
                  "it: close the shape, or all shapes with this medium together"
            : "the geometric normals of " + name_of(*boundary.shape) +
                  " point into its medium, which is therefore around it: flip the normals, or "
                  "name the medium 'exterior'");
  }
  return faulty;
}

/// Warns of the first medium whose free paths are too short for the coordinates of its shape.
void warn_of_short_paths(const Scene& scene) {
  for (const auto& shape : scene.shapes()) {
    const Aabb box = shape->bounds();
    const Vec3 farthest = glm::max(glm::abs(box.lo), glm::abs(box.hi));
    const float coordinate = std::max({farthest.x, farthest.y, farthest.z});
    for (const Medium* const medium : {shape->interior(), shape->exterior()}) {
      if (!medium || !(medium->max_extinction() * coordinate * kMinFreePath > 1)) continue;
      return warn_at(scene,
                     "the mean free path in the medium of " + name_of(*shape) + ", " +
                         format_number(1 / medium->max_extinction()) +
                         ", is near the rounding errors of its coordinates, which are up to " +
                         format_number(coordinate) +
                         ": light may be lost or added; lower the extinction, or move the "
                         "scene to the origin");
    }
  }
}

/// Medium in which a camera ray starts, by the first shape on its way that separates media.
enum class Start { kUnknown, kAsGiven, kOther };

Start start_of(const Scene& scene, const Sensor& sensor, const FaultyMedia& faulty, Ray ray) {
  constexpr int kMaxSurfaces = 16;
  RenderCounters counters;
  for (int i = 0; i < kMaxSurfaces; ++i) {
    RayHit hit{ray, {}};
    scene.intersect({&hit, 1}, Coherence::kIncoherent, counters);
    if (!hit.hit.valid()) return Start::kUnknown;
    const SurfaceInteraction si = scene.interaction(hit);
    if (si.shape->separates_media()) {
      const bool is_outside = glm::dot(si.n, ray.d) < 0;
      const Medium* const medium = is_outside ? si.shape->exterior() : si.shape->interior();
      if (faulty.contains(si.shape->interior())) return Start::kUnknown;
      return medium == sensor.medium() ? Start::kAsGiven : Start::kOther;
    }
    if (!si.shape->bsdf().has_null_lobe()) return Start::kUnknown;
    ray.o += distance_behind(ray, si.p, si.n, si.p_error) * ray.d;
    ray.tmin = 0;
  }
  return Start::kUnknown;
}

void warn_of_start(const Scene& scene, const Sensor& sensor, const FaultyMedia& faulty) {
  constexpr int kSide = 4;  // rays along each axis of the film
  const Vec2 size(sensor.film().width(), sensor.film().height());
  int given = 0, other = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 at(static_cast<float>(i % kSide) + 0.5f, static_cast<float>(i / kSide) + 0.5f);
    const Ray ray = sensor.sample_ray(at / static_cast<float>(kSide) * size, Vec2(0.5f));
    const Start start = start_of(scene, sensor, faulty, ray);
    given += start == Start::kAsGiven;
    other += start == Start::kOther;
  }
  if (other <= given) return;
  warn_at(scene,
          sensor.medium()
              ? "the sensor's medium isn't that of the shape around it: nest a <ref> to that "
                "shape's medium in the sensor"
              : "the sensor is in a medium but has none itself, so that its rays start in "
                "empty space: nest a <ref> to the medium, or to the BSDF that defines it, in "
                "the sensor");
}

/// True if rays that leave the scene may be in the medium.
bool surrounds_scene(const Scene& scene, const Sensor& sensor, const Medium& medium) {
  if (!medium.is_uniform() || !is_unbounded(medium, scene)) return false;
  return &medium == sensor.medium() ||
         std::any_of(scene.shapes().begin(), scene.shapes().end(),
                     [&](const auto& shape) { return shape->exterior() == &medium; });
}

}  // namespace

void warn_of_media(const Scene& scene, const Sensor& sensor) {
  if (scene.media().empty()) return;
  warn_of_start(scene, sensor, warn_of_boundaries(scene));
  warn_of_short_paths(scene);
  if (!has_light_from_infinity(scene)) return;
  for (const Medium* const medium : scene.media()) {
    if (!surrounds_scene(scene, sensor, *medium)) continue;
    return warn_at(
        scene,
        "a medium without a boundary surrounds the scene: it ends at the sphere around all "
        "shapes and the sensor, because it would absorb all light from infinity");
  }
}

}  // namespace kinome::transport
