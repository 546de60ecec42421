#pragma once

#include "kinome/integrator.h"
#include "kinome/render.h"

namespace kinome {

/// Returns the number of lanes that a film needs for a budget.
KINOME_EXPORT uint32_t lanes_for(const RenderBudget& budget, const Film& film);

/// Renders passes into the film, which is prepared with lanes_for() lanes, until the job's
/// budget is spent. Sets RenderStats::samples and rel_mse. The budget determines the rounds:
///
/// - Neither time nor error: one round with the scene's samples, divided among the lanes.
/// - Error: the first round has one sample per lane, the minimum for an error estimate. The second
///   one has at most four times as many samples, and each later one at most as many as all before
///   it. Each round adds at least a quarter of the samples before it. Rounds end when the estimate
///   from the lanes' differences reaches the target. Because the end depends on the samples, the
///   image is biased, but by far less than its noise. Logs a message if the error is better than
///   the target by a factor of 1.5.
/// - Time: each round has as many samples as fit the remaining time at the speed of the previous
///   round; rounds become smaller toward the end. At the deadline, no more tiles are started.
KINOME_EXPORT void render_passes(Passes& passes, Film& film, RenderJob& job,
                                 const PassCallback& on_pass = nullptr);

/// Develops the film's image. If the budget requests lanes, appends the channels of film_noise()
/// and sets RenderStats::renders and variance_of_mean. Uses the threads of `scheduler` if it isn't
/// nullptr.
KINOME_EXPORT Image develop(const Film& film, const RenderBudget& budget, RenderStats& stats,
                            const Scheduler* scheduler = nullptr);

}  // namespace kinome
