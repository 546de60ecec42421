#include "clustered/product/method_trial.h"

#include <algorithm>

#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// One of so many tiles, and no more than these in all: a trial is to be a small part of the
/// render.
constexpr int kTilesPerTrial = 16, kMostTiles = 256, kLeastTiles = 24;

double rays_of(const RenderCounters& counters, bool of_light) {
  double sum = 0;
  for (int kind = 0; kind < kRayKindCount; ++kind) {
    const bool is_light = static_cast<RayKind>(kind) == RayKind::kLight;
    if (is_light == of_light) sum += static_cast<double>(counters.rays[kind]);
  }
  return sum;
}

/// Mean of the channels' squares.
double mean_square(const Rgb& c) {
  return glm::dot(c, c) / 3.0;
}

}  // namespace

MethodTrial::MethodTrial(const TileGrid& grid, uint64_t seed)
    : grid_(grid),
      seed_(seed),
      stride_(static_cast<uint64_t>(
          std::max(kTilesPerTrial, (grid.tiles() + kMostTiles - 1) / kMostTiles))) {}

bool MethodTrial::is_possible() const {
  return grid_.tiles() >= kLeastTiles * kTilesPerTrial;
}

bool MethodTrial::is_wanted(const TileGrid::Tile& tile) const {
  return hash_words(seed_, static_cast<uint64_t>(tile.index)) % stride_ == 0;
}

MethodTrial::Renders MethodTrial::run(const Way& way, RenderContext& context) const {
  Renders renders;
  const RenderCounters& counters = context.stats().counters;
  const double rays = rays_of(counters, false), light_rays = rays_of(counters, true);
  for (uint64_t i = 0; i < 2; ++i) {
    renders.pictures[i].assign(static_cast<size_t>(grid_.crop().area()), Rgb(0.f));
    way.render(i, renders.pictures[i]);
  }
  renders.cost = (rays_of(counters, false) - rays) * way.cost_of_ray +
                 (rays_of(counters, true) - light_rays) * way.cost_of_light + 2 * way.more_cost;
  return renders;
}

double MethodTrial::compare(const Way& first, const Way& second, RenderContext& context) const {
  const Renders a = run(first, context), b = run(second, context);
  if (context.cancelled() || !(a.cost > 0 && b.cost > 0)) return kInfinity;
  // Of each tile that is wanted: its pixels, and the mean of what all four have come to.
  struct Part {
    std::vector<size_t> pixels;
    Rgb mean{0.f};
  };
  std::vector<Part> parts;
  double mean = 0;
  for (int block = 0; block < grid_.blocks_x() * grid_.blocks_y(); ++block) {
    grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      if (!is_wanted(tile)) return;
      Part part;
      tile.for_each_pixel([&](int x, int y) { part.pixels.push_back(grid_.pixel(x, y)); });
      for (const size_t i : part.pixels) {
        part.mean += a.pictures[0][i] + a.pictures[1][i] + b.pictures[0][i] + b.pictures[1][i];
      }
      part.mean *= 0.25f / static_cast<float>(part.pixels.size());
      mean += mean_of(part.mean);
      parts.push_back(std::move(part));
    });
  }
  if (!(mean > 0)) return kInfinity;
  mean /= static_cast<double>(parts.size());
  const auto error_of = [&](const Way& way, const Renders& renders) {
    double error = 0;
    for (const Part& part : parts) {
      const double weight = 1 / (mean_square(part.mean) + 0.01 * mean * mean);
      for (const size_t i : part.pixels) {
        error += weight * mean_square(renders.pictures[0][i] - renders.pictures[1][i]);
        // Of a difference it would be twice that.
        if (!way.more_variance.empty()) {
          error += weight * 2 * static_cast<double>(way.more_variance[i]);
        }
      }
    }
    return error;
  };
  const double error_a = error_of(first, a), error_b = error_of(second, b);
  return error_a > 0 ? error_b * b.cost / (error_a * a.cost) : kInfinity;
}

}  // namespace kinome
