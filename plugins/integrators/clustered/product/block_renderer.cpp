#include "clustered/product/block_renderer.h"

#include <algorithm>
#include <cmath>

namespace kinome {
namespace {

/// What an unshadowed candidate takes, in rays.
constexpr float kCandidateCost = 0.1f;
/// Whatever is planned: surfaces that the pilot missed, such as thin ones, must not be left to
/// control terms.
constexpr uint32_t kLeastRays = 2;

}  // namespace

BlockRenderer::BlockRenderer(const PassView& view)
    : view_(view),
      tracer_(view.primaries),
      learner_(view.knowledge.padded_cells(), &view.neighbours),
      estimator_(view.light) {}

Rgb BlockRenderer::colour(size_t pixel) const {
  Rgb c(0.f);
  for (size_t k = pixel * units_per_pixel(); k < (pixel + 1) * units_per_pixel(); ++k) {
    c += weights_[k].of(sums_[k]);
  }
  return c;
}

void BlockRenderer::render(int block, const std::vector<PixelPlan>& plan, uint64_t seed,
                           RenderCounters& counters, const IsWanted& is_wanted) {
  sums_.clear();
  weights_.clear();
  alphas_.clear();
  diagnostics_.clear();
  sums_.reserve(units_per_pixel() * TileGrid::kBlockSide * TileGrid::kBlockSide);
  tracer_.trace(
      view_.grid, block, seed, counters.stage_seconds["primary"], counters,
      [&](const TileGrid::Tile& tile) { return !is_wanted || is_wanted(tile); },
      [&](int x, int y) {
        // Of each sign one.
        return std::max<uint16_t>(plan[view_.grid.pixel(x, y)].primaries,
                                  static_cast<uint16_t>(units_per_pixel()));
      },
      [&](const TileGrid::Tile& tile, TilePrimaries& primaries) {
        render_tile(tile, primaries, plan, seed, counters);
      });
  estimator_.flush();
}

/// What is known of each of the tile's patches.
void BlockRenderer::find_visibilities(int tile) {
  mean_visibility_.clear();
  for (size_t p = 0; p < patches_.size(); ++p) {
    if (visibility_.size() == p) {
      visibility_.emplace_back().resize(view_.knowledge.padded_cells());
      visibility_.back().reset();
    }
    Patch& patch = patches_[p];
    Visibility& visibility = visibility_[p];
    view_.knowledge.recall(tile, p, patch, learner_, visibility);
    if (view_.settings.diagnostics) {
      mean_visibility_.push_back(mean_visibility(patch, visibility));
    }
    view_.knowledge.restrict(patch, visibility);
  }
}

void BlockRenderer::render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                                const std::vector<PixelPlan>& plan, uint64_t seed,
                                RenderCounters& counters) {
  patches_ = view_.knowledge.patches(tile.index);
  assign_patches(primaries, patches_);
  find_visibilities(tile.index);
  find_units(primaries, plan, seed);
  const std::span<const Unit> units = units_;
  estimator_.begin_tile(view_.scene, primaries, patches_, visibility_,
                        hash_words(seed, static_cast<uint64_t>(tile.index), 3), counters,
                        view_.settings.shared_candidates ? units : units.first(0));
  const size_t per_pixel = units_per_pixel();
  for (size_t i = 0; i < units.size(); ++i) {
    const Unit& unit = units[i];
    Rgb& sum = sums_.emplace_back(0.f);
    float alpha = 0;
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      sum += primaries.emitted(k);
      alpha += primaries.alpha(k);
    }
    if (i % per_pixel == 0) alphas_.push_back(0.f);
    alphas_.back() += weights_[sums_.size() - 1].of(alpha);
    estimator_.estimate(unit, sum);
  }
  if (view_.settings.diagnostics) find_diagnostics(primaries, plan);
}

/// Each pixel of a tile; where the filter is negative in parts, first what is positive and then
/// what is negative of it, by its share of the pixel's primaries.
void BlockRenderer::find_units(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                               uint64_t seed) {
  const Rect& pixels = primaries.pixels();
  const Rect region = view_.primaries.region;
  units_.clear();
  for (int i = 0; i < pixels.area(); ++i) {
    const int x = pixels.x0 + i % pixels.width(), y = pixels.y0 + i / pixels.width();
    const size_t pixel = view_.grid.pixel(x, y);
    const uint32_t ends[] = {primaries.first(i), primaries.first_negative(i),
                             primaries.first(i + 1)};
    const FilterSampler::Shares shares = view_.primaries.filter.shares(x, y, region);
    const float of_sign[] = {shares.positive, -shares.negative};
    for (size_t k = 0; k < units_per_pixel(); ++k) {
      const uint32_t first = ends[k], end = ends[k + 1];
      const float part = static_cast<float>(end - first) / static_cast<float>(ends[2] - ends[0]);
      const auto rays = static_cast<uint32_t>(std::ceil(part * plan[pixel].rays));
      units_.push_back({first, end, std::max<uint32_t>(rays, kLeastRays),
                        part * plan[pixel].candidates, hash_words(seed, pixel, 2 + 2 * k)});
      weights_.push_back({of_sign[k], static_cast<float>(end - first)});
    }
  }
}

/// Of the light that cells send to an unshadowed point, by what is learned.
float BlockRenderer::mean_visibility(const Patch& patch, const Visibility& visibility) const {
  double all = 0, visible = 0;
  for (uint32_t c = 0; c < view_.cells.size(); ++c) {
    const Vec3 axis(view_.cells.axis()[0][c], view_.cells.axis()[1][c], view_.cells.axis()[2][c]);
    const double light = view_.cells.flux()[c] * std::max(0.f, glm::dot(axis, patch.normal));
    all += light;
    visible += light * visibility.v[c];
  }
  if (view_.cells.size() == 0) return patch.mean_visibility;
  return all > 0 ? static_cast<float>(visible / all) : 0.f;
}

void BlockRenderer::find_diagnostics(const TilePrimaries& primaries,
                                     const std::vector<PixelPlan>& plan) {
  const Rect& pixels = primaries.pixels();
  for (int i = 0; i < pixels.area(); ++i) {
    const uint32_t first = primaries.first(i), end = primaries.first(i + 1);
    float visible = 0, lit = 0;
    for (uint32_t k = first; k < end; ++k) {
      if (primaries.patch(k) < 0) continue;
      visible += mean_visibility_[primaries.patch(k)];
      lit += 1;
    }
    const PixelPlan& p =
        plan[view_.grid.pixel(pixels.x0 + i % pixels.width(), pixels.y0 + i / pixels.width())];
    const auto samples = static_cast<float>(end - first);
    const float rays = lit > 0 ? static_cast<float>(std::max<uint32_t>(p.rays, kLeastRays)) : 0.f;
    diagnostics_.emplace_back(samples,
                              samples + rays + (lit > 0 ? kCandidateCost * p.candidates : 0.f),
                              lit > 0 ? visible / lit : 0.f);
  }
}

}  // namespace kinome
