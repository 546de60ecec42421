#pragma once

#include <string>

#include "kinome/render_context.h"
#include "kinome/scene.h"

namespace kinome::app {

/// Shows where the light samples of a pixel go (Åkerlund 2008, 4.3.4 and figure 5.6). Writes two
/// files for each set of light points and returns their names. Throws Error.
///
/// `stem`.png shows the environment, or the scene in grey (enlarged if the film's longer side is
/// less than 768 pixels). It outlines the clusters' boxes and draws the samples by weight, visible
/// ones in red and shadowed ones in blue, with a legend below. `stem`.csv has a row per cluster.
/// Files of a second set begin with `stem`-2.
std::string inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    const Vec2& pixel, const std::string& stem);

}  // namespace kinome::app
