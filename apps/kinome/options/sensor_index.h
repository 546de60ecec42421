#pragma once

#include <string>

#include "kinome/scene.h"

namespace kinome::app {

/// Returns the index of the sensor with this id or index. Throws Error if there is none.
size_t sensor_index(const Scene& scene, const std::string& wanted);

}  // namespace kinome::app
