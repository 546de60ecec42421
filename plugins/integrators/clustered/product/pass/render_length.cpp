#include "clustered/product/pass/render_length.h"

#include <algorithm>

namespace kinome {
namespace {

/// Rays per pixel that are assumed if a render ends at an error.
constexpr double kRaysOfUnknown = 100;

}  // namespace

RenderLength expected_length(const ProductSettings& settings, const Sensor& sensor,
                             const RenderContext& context, double seconds) {
  const RenderBudget& budget = context.budget();
  const double pixels = std::max(1, sensor.film().sampled().area());
  if (budget.seconds > 0) {
    return {seconds * kCarefulSpeed * context.all_threads() / pixels, seconds};
  }
  return {budget.rel_mse > 0 ? kRaysOfUnknown : settings.rays_per_pixel};
}

}  // namespace kinome
