#pragma once

#include <cstddef>

#include "clustered/media/fog_sources.h"
#include "kinome/render_context.h"
#include "transport/media/media_table.h"
#include "transport/path_parameters.h"
#include "transport/scene_table.h"

namespace kinome {

/// Returns the number of blocks of a trial before a render of the sensor's samples. 0 for short
/// renders, of which a trial would take too large a share.
size_t blocks_of_trial(const Sensor& sensor);

/// Chooses the method of short renders: returns true for path tracing as in `volpath`.
bool prefers_paths_untried(const PathSettings& settings);

/// True if path tracing as in `volpath` is expected to take less work for the same error than
/// FogBlock. Renders `count` > 0 blocks of the image by both methods, without changing the film.
///
/// Work is counted in rays, so that the result is the same on every machine and for any
/// number of threads.
bool prefers_paths(const transport::SceneTable& scene, const transport::MediaTable& media,
                   const FogSources& sources, const Sensor& sensor, const PathSettings& settings,
                   size_t count, RenderContext& context);

}  // namespace kinome
