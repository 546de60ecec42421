#pragma once

#include <functional>
#include <optional>
#include <span>

#include "kinome/image.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"

namespace kinome {

/// Prepares the film and renders with the scene's integrator until the context's budget is spent,
/// or the sampler's samples are rendered if there is no budget. Fills the context's stats. With
/// RenderBudget::lanes, the image includes the channels of film_noise().
KINOME_EXPORT Image render(const Scene& scene, const Sensor& sensor, RenderContext& context);

/// Called after each completed pass over the image, with the image so far, on the thread that
/// called render(). In `stats`, `samples` refers to this image, and so do `renders` and
/// `variance_of_mean` if variances were requested. Neither the image nor the number of samples for
/// an error target depends on the callback; its time counts toward a time budget. render() rethrows
/// its exceptions.
using PassCallback = std::function<void(Image image, const RenderStats& stats)>;

/// Renders as above, and calls `on_pass` (may be empty) with intermediate images: once for a fixed
/// sample count; after each of RenderBudget::lanes; or, for a budget of time or error, after passes
/// of growing size. For an error, the first pass has one sample per pixel.
KINOME_EXPORT Image render(const Scene& scene, const Sensor& sensor, RenderContext& context,
                           const PassCallback& on_pass);

/// Estimates the relMSE (see RenderBudget) of the film's image from the differences between its
/// lanes. `samples` has the number of samples per pixel of each lane. Returns nullopt if the lanes
/// are too few or lack samples.
///
/// Squared differences of two lanes are divided by the mean of two squared brightness values of the
/// pixel: that of all lanes, and that of all other lanes. The first one alone would underestimate
/// errors, because fireflies in the two lanes raise it; the second alone would overestimate them,
/// because it is noisier.
KINOME_EXPORT std::optional<double> estimate_rel_mse(const Film& film,
                                                     std::span<const double> samples);

/// Names of a RenderBudget's fields as the user knows them, for messages.
struct BudgetNames {
  const char* seconds = "--time ";
  const char* rel_mse = "--error ";
  const char* work = "load, render {} and write";  ///< task that the time was for; {}: the samples
};
/// Warns if the render exceeded its time budget by more than 5 % (and 0.05 s), or missed its error
/// target. `seconds` is the total time.
KINOME_EXPORT void warn_of_missed_budget(const RenderBudget& budget, const RenderStats& stats,
                                         double seconds, const BudgetNames& names);

}  // namespace kinome
