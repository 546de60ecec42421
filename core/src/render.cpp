#include "kinome/render_context.h"

#include "kinome/error.h"
#include "kinome/log.h"

namespace kinome {

void warn_without_emitters(const Scene& scene) {
  if (!scene.emitters().empty()) return;
  log_warn(
      Error(Location{scene.file()}, "the scene has no emitter: the picture will be black").what());
}

Image render(const Scene& scene, const Sensor& sensor, RenderContext& context) {
  RenderStats& stats = context.stats();
  Image image;
  {
    const StageTimer timer(stats.render_seconds);
    const Integrator& integrator = scene.integrator();
    Film& film = sensor.film();
    film.prepare(integrator.layers());
    integrator.render(scene, sensor, context);
    image = film.develop();
    stats.non_finite_samples += film.non_finite();
  }
  stats.threads = context.threads();
  stats.peak_memory_bytes = peak_memory_bytes();
  stats.complete = !context.cancelled();
  return image;
}

}  // namespace kinome
