#pragma once

#include "path_parameters.h"
#include "kinome/render_context.h"

namespace kinome::transport {

/// Integrator::render of `path`.
void render_paths(const PathSettings& settings, const Scene& scene, const Sensor& sensor,
                  RenderContext& context);

}  // namespace kinome::transport
