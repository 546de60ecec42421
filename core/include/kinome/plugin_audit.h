#pragma once

#include <vector>

#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome {

/// Looks at what the plugins of a scene say at some random places that the sensor sees, and tells of
/// what can't be: values that aren't finite, densities that are negative, exceptions. Of nested
/// plugins the innermost is named. Takes some microseconds a place, on this thread; renders have no
/// such checks in their loops. The same seed looks at the same places.
KINOME_EXPORT std::vector<PluginFault> audit_plugins(const Scene& scene, const Sensor& sensor,
                                                     uint64_t seed, uint32_t places);

}  // namespace kinome
