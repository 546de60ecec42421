// Trials of product sampling: renders of some tiles, from which the method of an image is chosen.

#include <algorithm>
#include <cmath>

#include "clustered/product/pass/product_renderer.h"
#include "kinome/sampler.h"

namespace kinome {
namespace {

/// Factor of the pilot's rays in a trial, relative to an image's pilot. A tile can learn only from
/// few tiles around it.
constexpr uint32_t kPilotRayFactor = 2;

}  // namespace

bool ProductRenderer::can_use_paths() const {
  return local_ && !local_->has_lamp_caustics();
}

double ProductRenderer::learn_for_trial(double rays_per_pixel, const MethodTrial& trial) {
  Pilot::Effort effort = effort_of_pilot(rays_per_pixel);
  const double rays = effort.rays_per_pixel();
  effort.rays *= kPilotRayFactor;
  const LargeArray<PixelForecast> forecast = send_pilot(
      effort, [&](const TileGrid::Tile& tile) { return trial.is_wanted(tile); }, 0);
  // The plan of the trial's tiles alone, laid out as a strip.
  trial_pixels_ = trial.pixels();
  std::vector<PixelForecast> strip;
  for (const size_t i : trial_pixels_) strip.push_back(forecast[i]);
  if (!context_.job.cancelled()) {
    allocate(effort, strip, kTileSide, static_cast<int>(strip.size()) / kTileSide);
  }
  return rays;
}

/// Renders the tiles of the trial into `image`. The first render uses the light points of the
/// pilot.
void ProductRenderer::try_tiles(const MethodTrial& trial, double rays, uint64_t index,
                                uint64_t seed, std::span<Rgb> image) {
  if (index > 0) pilot_light_.emplace(make_light(hash_words(seed, 1), rays * trial.share()));
  const LargeArray<PixelPlan> strip = plan_pass(rays);
  LargeArray<PixelPlan> plan(static_cast<size_t>(grid_.crop().area()));
  for (size_t k = 0; k < trial_pixels_.size(); ++k) plan[trial_pixels_[k]] = strip[k];
  trial.for_each_tile<BlockRenderer>(
      context_.scheduler, image,
      [&] { return std::make_unique<BlockRenderer>(pass_view(*pilot_light_)); },
      [&](int chosen, BlockRenderer& renderer, RenderCounters& counters) {
        size_t next = 0;
        const auto is_wanted = [&](const TileGrid::Tile& tile) { return tile.index == chosen; };
        const int block = grid_.block_of(chosen);
        renderer.render(block, plan, seed, counters, is_wanted);
        grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
          if (!is_wanted(tile)) return;
          tile.for_each_pixel(
              [&](int x, int y) { image[grid_.pixel(x, y)] = renderer.colour(next++); });
        });
      });
}

MethodTrial::Way ProductRenderer::trial_way(const MethodTrial& trial, double rays,
                                            const RenderLength& length, double cost_of_ray,
                                            uint64_t seed) {
  // An image draws its points once for all of its rays. A render of the trial draws this number
  // times light_share_.
  const double share_of_light =
      trial.share() * std::min(1., rays / std::max(length.rays_per_pixel, 1.)) / light_share_;
  MethodTrial::Way way{[=, this](const MethodTrial& tiles, uint64_t index, std::span<Rgb> image) {
                         try_tiles(tiles, rays, index, hash_words(seed, 1, index), image);
                       },
                       cost_of_ray, light_rays_ * share_of_light * cost_of_ray};
  // Pixels share the light points, whose number is in this proportion.
  way.common_share = light_share_;
  if (caustics_) {
    const double count = rays / kRaysPerCausticPath * grid_.crop().area();
    const auto tried = static_cast<uint32_t>(std::ceil(count * trial.share()));
    way.more_variance = caustics_->variance(hash_words(seed, 3), tried, count, grid_,
                                            context_.job.stats().counters);
    way.extra_cost += tried * caustics_->rays_per_path() * cost_of_ray;
  }
  return way;
}

}  // namespace kinome
