#pragma once

#include "kinome/integrator.h"
#include "kinome/render.h"

namespace kinome {

/// Lanes that a film needs for a budget.
KINOME_EXPORT uint32_t lanes_for(const RenderBudget& budget, const Film& film);

/// Renders passes into the film, which is prepared with the budget's lanes, until the context's
/// budget is spent. Fills RenderStats::samples and rel_mse.
///
/// - Neither time nor error asked for: the scene's samples, divided among the lanes.
/// - Error: a first round of one sample for each lane, the fewest that tell an error; then others,
///   each at most as large as all before it together (the second: four times that), until the lanes
///   differ by little enough. A quarter more is the least that they add, which at first is a sample
///   for some of the lanes. When it ends depends on what the lanes found: by so much the picture is
///   biased, far less than its noise. What is better than asked by 1.5 is told as info.
/// - Time: rounds as large as the speed of the last one promises to be in time, smaller toward the
///   end. What is not in time all the same is cut short, tile by tile.
KINOME_EXPORT void render_passes(Passes& passes, Film& film, RenderContext& context,
                                 const PassCallback& on_pass = nullptr);

/// The film's picture. Where the budget asks for variances, with their channels; what else is known
/// of them goes to RenderStats::renders and variance_of_mean.
KINOME_EXPORT Image develop(const Film& film, const RenderBudget& budget, RenderStats& stats);

}  // namespace kinome
