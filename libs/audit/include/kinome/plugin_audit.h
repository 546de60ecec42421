#pragma once

#include <vector>

#include "kinome/scene.h"
#include "kinome/scheduler.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome {

/// Checks results of the scene's plugins at `places` random points that the sensor sees, and
/// returns a list of invalid ones: non-finite values, negative densities, exceptions.
///
/// At the first 256 points, also checks consistency: samples against the densities and values of
/// their directions, unit length of directions, scalar against block functions, an environment
/// against its cell_grid(), and the distribution of samples against their densities. Tolerances
/// allow for rounding (libs/audit/rounding.h), so that correct plugins are never reported. Of
/// nested plugins, the innermost is reported.
///
/// Not checked: sample_emission(), because some emitters build large tables for it on first use,
/// and whether samples of a surface follow pdf_surface() if both agree on their densities.
///
/// Takes about ten microseconds per point; render loops contain no such checks. Call it after a
/// render: by then the camera's view is known, and the image can be written whatever the result.
/// The same seed checks the same points, with the same result on any number of threads.
///
/// Uses the threads of `scheduler`, or the calling thread alone if it is nullptr.
KINOME_EXPORT std::vector<PluginFault> audit_plugins(const Scene& scene, const Sensor& sensor,
                                                     uint64_t seed, uint32_t places,
                                                     const Scheduler* scheduler = nullptr);

}  // namespace kinome
