#pragma once

#include <vector>

#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome {

/// Checks what the plugins of a scene return at some random places that the sensor sees, and lists
/// what is impossible: values that aren't finite, densities that are negative, exceptions; and at the
/// first 256 places, what doesn't fit together: samples and the densities and values of their
/// directions, directions that are not of unit length, single values and batches, an environment
/// and its cell_grid(), densities that samples don't follow. Agreement is up to rounding
/// (core/plugin/rounding.h), so that sound plugins are never named. Of nested plugins the innermost
/// is named.
///
/// Not looked at: sample_emission(), since some emitters make large tables for it on first use, and
/// whether samples of a surface follow pdf_surface() where both say the same.
///
/// Takes some ten microseconds a place, on this thread; renders have no such checks in their loops.
/// To be called after a render, which has shown by then what its camera sees, and is written
/// whatever is found. The same seed looks at the same places.
KINOME_EXPORT std::vector<PluginFault> audit_plugins(const Scene& scene, const Sensor& sensor,
                                                     uint64_t seed, uint32_t places);

}  // namespace kinome
