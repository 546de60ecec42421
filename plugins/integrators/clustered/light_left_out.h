#pragma once

#include "kinome/error.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "transport/path_parameters.h"

namespace kinome {

/// Light of paths that are longer than those an integrator renders.
struct LightLeftOut {
  double share = 0;  ///< share of the mean luminance of the image with this light
  double error = 0;  ///< standard error of `share`
};

/// Traces some thousand paths of up to PathSettings::length, and measures the share of light from
/// paths of more than `longest` edges. Takes milliseconds to tens of milliseconds. The result
/// depends on the seed, not on the number of threads. Rays are not counted in the context's stats.
LightLeftOut measure_light_left_out(const PathSettings& settings, uint32_t longest,
                                    const Scene& scene, const Sensor& sensor,
                                    RenderContext& context);

/// Warns if paths of up to `requested` edges are enabled, those of more than `longest` edges are
/// left out, and their light is significant. `where`: location of the integrator in the scene file.
void warn_of_ignored_light(const Location& where, const PathSettings& requested, uint32_t longest,
                           const Scene& scene, const Sensor& sensor, RenderContext& context);

}  // namespace kinome
