#pragma once

#include "kinome/scene.h"

namespace kinome::transport {

/// Warns if a medium without a boundary hides an infinitely distant emitter, and if the sensor is
/// inside a shape whose medium isn't the one that its rays start in.
void warn_of_media(const Scene& scene, const Sensor& sensor);

}  // namespace kinome::transport
