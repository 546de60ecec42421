#pragma once

#include <string>

#include "kinome/scene.h"

namespace kinome::app {

/// The index of one of a scene's sensors, by its id or by that index. Throws Error where there is
/// none.
size_t sensor_index(const Scene& scene, const std::string& wanted);

}  // namespace kinome::app
