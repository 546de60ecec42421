#pragma once

#include "kinome/image.h"
#include "kinome/render.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kit/statistics/statistics.h"

/// Test scene for sensors, films and integrators.
namespace kinome::check {

/// A sphere on a floor that fills the image, because not all integrators show the emitters.
inline constexpr const char* kLitScene =
    "<shape type='rectangle'><transform name='to_world'><scale value='3'/></transform></shape>"
    "<shape type='sphere'><point name='center' x='0' y='0' z='0.7'/><float name='radius' "
    "value='0.6'/><bsdf type='roughplastic'><float name='alpha' value='0.3'/></bsdf></shape>"
    "<shape type='rectangle'><transform name='to_world'><scale value='0.7'/><rotate x='1' "
    "angle='180'/><translate x='2.6' z='3'/></transform><emitter type='area'><float name='radiance' "
    "value='5'/></emitter></shape><emitter type='constant'><float name='radiance' value='0.3'/>"
    "</emitter>";

inline Image render_image(const Scene& scene, uint64_t seed, unsigned threads, uint64_t order = 0) {
  RenderOptions options;
  options.threads = threads;
  options.seed = seed;
  options.tile_order_seed = order;
  RenderContext context(options);
  return render(scene, *scene.sensors().at(0), context);
}

}  // namespace kinome::check
