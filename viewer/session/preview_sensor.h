#pragma once

#include <memory>

#include "kinome/sensor.h"

namespace kinome::viewer {

/// A sensor that sees what another one does, on a film of its own: so that a picture of other
/// resolution, or one that is rendered beside another, doesn't touch the film of the scene. What
/// the film's crop window shows is spread over `width` x `height` pixels. The sensor must outlive
/// it, and may be used by others at the same time.
std::unique_ptr<Sensor> with_own_film(const Sensor& sensor, int width, int height,
                                      uint32_t samples);

}  // namespace kinome::viewer
