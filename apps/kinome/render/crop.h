#pragma once

#include "kinome/sensor.h"
#include "options/options.h"

namespace kinome::app {

/// Makes the sensor's film render only the window of --crop, as if the scene set the film's crop_*
/// parameters. Does nothing without --crop. Throws Error if the window isn't within the film. Call
/// before anything depends on the film's crop window.
void apply_crop(const Options& options, const Sensor& sensor);

}  // namespace kinome::app
