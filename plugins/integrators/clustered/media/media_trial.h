#pragma once

#include "clustered/media/fog_sources.h"
#include "kinome/render_context.h"
#include "transport/media/media_table.h"
#include "transport/path_parameters.h"
#include "transport/scene_table.h"

namespace kinome {

/// True if path tracing as in `volpath` is expected to take less work for the same error than
/// FogBlock. Renders some blocks of the image by both methods, without changing the film. Short
/// renders have no trial: FogBlock renders them only if `max_depth` is at most 3.
///
/// Work is counted in samples and rays, so that the result is the same on every machine and for any
/// number of threads.
bool prefers_paths(const transport::SceneTable& scene, const transport::MediaTable& media,
                   const FogSources& sources, const Sensor& sensor, const PathSettings& settings,
                   RenderContext& context);

}  // namespace kinome
