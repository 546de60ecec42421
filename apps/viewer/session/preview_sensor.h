#pragma once

#include <memory>

#include "kinome/sensor.h"

namespace kinome::viewer {

/// Returns a sensor with the same view as `sensor`, but with its own film. Use it to render another
/// image or resolution without touching the scene's film. The view of the crop window is scaled to
/// `width` x `height` pixels. `sensor` must outlive the result, and can be used at the same time.
/// With `has_box_filter`, the film's filter is a box of one pixel, as denoisers need it.
std::unique_ptr<Sensor> with_own_film(const Sensor& sensor, int width, int height,
                                      uint32_t samples, bool has_box_filter = false);

}  // namespace kinome::viewer
