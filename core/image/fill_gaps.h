#pragma once

#include "kinome/film.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"

namespace kinome {

/// After a render that was interrupted, `begun` at that time of the context's clock: pixels that
/// have no samples yet get one, if all of them will in two seconds, by what camera rays took so
/// far. A render of its own, by the scene's integrator, that no checkpoint knows of. Fills
/// RenderStats::filled and missing.
void fill_gaps(const Scene& scene, const Sensor& sensor, RenderContext& context, double begun);

/// The share of the pixels that lack samples of any layer.
double share_of_gaps(const Integrator& integrator, const Film& film);

/// Marks what has no samples, if there is any, in the picture's alpha channel, which it is given
/// where it has none.
KINOME_EXPORT void mark_gaps(const Film& film, Image& picture);

}  // namespace kinome
