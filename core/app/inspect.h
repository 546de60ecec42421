#pragma once

#include <string>

#include "kinome/render_context.h"

namespace kinome::app {

/// Writes where the samples of one pixel go (Åkerlund 2008, 4.3.4 and figure 5.6). For each set of
/// light points, `stem`.png: the environment, or the scene in grey (the film's picture, enlarged
/// where its longer side is less than 768 pixels), with the clusters' boxes outlined and the
/// samples drawn by weight, visible ones in red and shadowed ones in blue, and a legend below;
/// `stem`.csv: a row a cluster. A second set is called `stem`-2. Returns the files' names. Throws
/// Error.
std::string inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    const Vec2& pixel, const std::string& stem);

}  // namespace kinome::app
