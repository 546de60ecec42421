#pragma once

#include "kinome/error.h"
#include "kinome/render_context.h"
#include "transport/path_parameters.h"

namespace kinome {

/// What longer paths than an integrator renders would add to a picture.
struct LightLeftOut {
  double share = 0;  ///< of the mean luminance of the picture with them
  double error = 0;  ///< standard error of `share`
};

/// Traces some thousand paths of up to PathSettings::length, and counts as left out what those of
/// more than `longest` edges bring. Takes some milliseconds to tens of them; depends on the seed,
/// not on the number of threads. Rays are not counted in the context's stats.
LightLeftOut measure_light_left_out(const PathSettings& settings, uint32_t longest,
                                    const Scene& scene, const Sensor& sensor,
                                    RenderContext& context);

/// A warning where paths of up to `asked` edges are asked for, those of more than `longest` are
/// left out, and that shows. `where` is the integrator's place in the scene file.
void warn_of_light_left_out(const Location& where, const PathSettings& asked, uint32_t longest,
                            const Scene& scene, const Sensor& sensor, RenderContext& context);

}  // namespace kinome
