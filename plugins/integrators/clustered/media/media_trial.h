#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "clustered/media/sources/fog_sources.h"
#include "kinome/render_context.h"
#include "transport/media/bodies/media_table.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/scene_table.h"

namespace kinome {

/// Returns the number of blocks of a trial before a render of the sensor's samples; 0 for short
/// renders, in which a trial would take too much of the time.
size_t blocks_of_trial(const Sensor& sensor);

/// Error and cost of a method in a block of the trial.
struct BlockWork {
  double error = 0;  ///< sum of the relative variances of the pixels
  double cost = 0;
};
/// Logarithm of the second method's work relative to that of the first, and its standard error.
/// Positive if the first method is better.
struct Gain {
  double log, error;
};
/// Returns the gain of the first method over the second one. `work` has both methods' errors and
/// costs in each block. Work is total error x total cost. The standard error is the jackknife's: it
/// is large if a few blocks decide.
Gain gain_of_first(std::span<const std::array<BlockWork, 2>> work);
/// True if the first method takes less work by a clear factor and by a standard error.
bool is_clear(const Gain& gain);

/// Method for a scene with media.
struct MediaChoice {
  bool uses_paths = false;  ///< true: path tracing as in `volpath`; false: FogBlock
  float paths = 1;          ///< argument of FogBlock

  bool operator==(const MediaChoice&) const = default;
};
/// Relative number of paths of FogBlock if light that is scattered once dominates the noise.
inline constexpr float kReducedPaths = 0.3f;

/// Chooses the method of short renders, without a trial.
MediaChoice choose_untried(const PathSettings& settings, const FogSources& sources);

/// Chooses the method that is expected to take the least work for the same error. Renders
/// `count` > 0 blocks of the image by path tracing and by FogBlock, with all paths and with
/// kReducedPaths of them. Doesn't change the film.
///
/// Work is counted in rays, so that the result is the same on every machine and for any
/// number of threads.
MediaChoice try_methods(const transport::SceneTable& scene, const transport::MediaTable& media,
                        const FogSources& sources, const Sensor& sensor,
                        const PathSettings& settings, size_t count, RenderContext& context);

}  // namespace kinome
