#pragma once

#include <functional>
#include <optional>
#include <span>

#include "kinome/image.h"
#include "kinome/render_context.h"

namespace kinome {

/// Called by the thread that called render(), which waits for it, after each pass over the whole
/// picture that was not cut short: with the picture so far. Of `stats`, `samples` and, where
/// variances are asked for, `renders` and `variance_of_mean` are this picture's. The picture does
/// not depend on whether there is a callback, nor do the samples that reach an error; the time that
/// it takes is part of a budget of time. What it throws, render() throws.
using PassCallback = std::function<void(Image picture, const RenderStats& stats)>;

/// As render() of render_context.h, while `on_pass` (may be empty) sees the picture grow: once,
/// where the sampler's samples are rendered; after each of RenderBudget::lanes, where these are
/// asked for; by a budget of time or error, after passes that grow, with an error from one sample a
/// pixel.
KINOME_EXPORT Image render(const Scene& scene, const Sensor& sensor, RenderContext& context,
                           const PassCallback& on_pass);

/// What lanes say of the relMSE (see RenderBudget) of the picture that is their mean; nullopt where
/// they can't tell. Differences of two lanes, relative to the brightness of the pixel: half by the
/// mean of all lanes, which sparks among the two raise, so that it alone would make errors too
/// small; half by that of the others, which being noisier alone would make them too large.
/// `samples`: of each lane.
KINOME_EXPORT std::optional<double> estimate_rel_mse(const Film& film,
                                                     std::span<const double> samples);

/// How the user calls a RenderBudget, for messages.
struct BudgetNames {
  const char* seconds = "--time ";
  const char* rel_mse = "--error ";
  const char* work = "load, render {} and write";  ///< what the time was for; {}: the samples
};
/// Warns of what was asked for and was not kept: a time that was exceeded by more than a twentieth,
/// or an error that was not reached. `seconds`: what all took.
KINOME_EXPORT void warn_of_missed_budget(const RenderBudget& budget, const RenderStats& stats,
                                         double seconds, const BudgetNames& names);

}  // namespace kinome
