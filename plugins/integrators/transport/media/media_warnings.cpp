#include "media_warnings.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "../rays.h"
#include "kinome/error.h"
#include "kinome/log.h"
#include "media_table.h"

namespace kinome::transport {

namespace {

/// Medium in which a camera ray starts, by the first shape on its way that separates media.
enum class Start { kUnknown, kAsGiven, kOther };

Start start_of(const Scene& scene, const Sensor& sensor, Ray ray) {
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
      return medium == sensor.medium() ? Start::kAsGiven : Start::kOther;
    }
    if (!si.shape->bsdf().passes_straight()) return Start::kUnknown;
    ray.o += distance_behind(ray, si.p, si.n, si.p_error) * ray.d;
    ray.tmin = 0;
  }
  return Start::kUnknown;
}

void warn_of_start(const Scene& scene, const Sensor& sensor) {
  constexpr int kSide = 4;  // rays along each axis of the film
  const Vec2 size(sensor.film().width(), sensor.film().height());
  int given = 0, other = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 at(static_cast<float>(i % kSide) + 0.5f, static_cast<float>(i / kSide) + 0.5f);
    const Ray ray = sensor.sample_ray(at / static_cast<float>(kSide) * size, Vec2(0.5f));
    const Start start = start_of(scene, sensor, ray);
    given += start == Start::kAsGiven;
    other += start == Start::kOther;
  }
  if (other <= given) return;
  log_warn(Error(Location{scene.file()},
                 sensor.medium()
                     ? "the sensor's medium isn't that of the shape around it: nest a "
                       "<ref> to that shape's medium in the sensor"
                     : "the sensor is in a medium but has none itself, so that its rays "
                       "start in empty space: nest a <ref> to the medium in the sensor")
               .what());
}

/// True if rays that leave the scene may be in the medium.
bool is_endless(const Scene& scene, const Sensor& sensor, const Medium& medium) {
  if (!medium.is_uniform()) return false;
  bool is_outside = &medium == sensor.medium();
  for (const auto& shape : scene.shapes()) {
    if (shape->interior() == &medium) return false;
    is_outside = is_outside || shape->exterior() == &medium;
  }
  return is_outside;
}

}  // namespace

void warn_of_media(const Scene& scene, const Sensor& sensor) {
  if (scene.media().empty()) return;
  warn_of_start(scene, sensor);
  if (!has_light_from_infinity(scene)) return;
  for (const Medium* const medium : scene.media()) {
    if (!is_endless(scene, sensor, *medium)) continue;
    log_warn(Error(Location{scene.file()},
                   "a medium without a boundary surrounds the scene: it ends at the sphere around "
                   "all shapes and the sensor, because light from infinity couldn't pass it")
                 .what());
    return;
  }
}

}  // namespace kinome::transport
