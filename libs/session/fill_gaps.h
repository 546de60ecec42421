#pragma once

#include "kinome/film.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"

namespace kinome {

/// Renders one sample for each pixel that has none after an interrupted render, if the time per
/// camera ray so far predicts that this takes at most two seconds. `begun` is the time of the
/// context's clock at which the render started. Checkpoints don't include these samples. Sets
/// RenderStats::filled and RenderStats::missing.
void fill_gaps(const Scene& scene, const Sensor& sensor, RenderContext& context, double begun);

/// Returns the fraction of pixels without samples in at least one layer.
double share_of_gaps(const Integrator& integrator, const Film& film);

/// If there are pixels without samples and the image has no alpha channel, adds one that is 0 at
/// these pixels and 1 elsewhere. An existing alpha channel is 0 there already.
KINOME_EXPORT void mark_gaps(const Film& film, Image& image);

}  // namespace kinome
