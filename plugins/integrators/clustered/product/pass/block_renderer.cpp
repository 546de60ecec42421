#include "clustered/product/pass/block_renderer.h"

#include <algorithm>
#include <cmath>

#include "transport/film_samples.h"

namespace kinome {
namespace {

/// Cost of an unshadowed candidate, in rays.
constexpr float kCandidateCost = 0.1f;
/// Minimum number of shadow rays of a pixel, because control terms are wrong on surfaces that the
/// pilot missed, such as thin ones.
constexpr uint32_t kMinRays = 2;

}  // namespace

BlockRenderer::BlockRenderer(const PassView& view)
    : view_(view),
      is_split_(transport::weighs_positions(view.primaries.sensor.film().filter())),
      tracer_(view.primaries),
      learner_(view.knowledge.padded_cells(), &view.neighbours),
      estimator_(view.light) {}

Rgb BlockRenderer::colour(size_t index) const {
  const Pixel& pixel = pixels_[index];
  Rgb sum(0.f);
  const size_t sums = is_split() ? pixel.samples : 1;
  for (size_t k = 0; k < sums; ++k) sum += sums_[pixel.first + k];
  return sum / static_cast<float>(pixel.samples);
}

/// Reserves memory for the block's sums. They must not move, because rays store their addresses.
void BlockRenderer::reserve(int block, const std::vector<PixelPlan>& plan) {
  size_t sums = 0;
  const Rect pixels = view_.grid.block(block);
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      sums += is_split() ? samples_of(plan[view_.grid.pixel(x, y)]) : 1;
    }
  }
  sums_.clear();
  sums_.reserve(sums);
}

void BlockRenderer::render(int block, const std::vector<PixelPlan>& plan, uint64_t seed,
                           RenderCounters& counters, const IsWanted& is_wanted) {
  reserve(block, plan);
  pixels_.clear();
  samples_.clear();
  diagnostics_.clear();
  tracer_.trace(
      view_.grid, block, seed, counters.stage_seconds["primary"], counters,
      [&](const TileGrid::Tile& tile) { return !is_wanted || is_wanted(tile); },
      [&](int x, int y) { return samples_of(plan[view_.grid.pixel(x, y)]); },
      [&](const TileGrid::Tile& tile, TilePrimaries& primaries) {
        render_tile(tile, primaries, plan, seed, counters);
      });
  estimator_.flush();
}

/// Finds the learned visibility of each of the tile's patches.
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
  for (size_t i = 0; i < units.size(); ++i) {
    const Unit& unit = units[i];
    const uint32_t samples = unit.end - unit.first;
    const Rect& pixels = primaries.pixels();
    Pixel pixel{pixels.x0 + static_cast<int>(i) % pixels.width(),
                pixels.y0 + static_cast<int>(i) / pixels.width(), sums_.size(), samples, 0};
    sums_.resize(pixel.first + (is_split() ? samples : 1), Rgb(0.f));
    const UnitSums sums{&sums_[pixel.first], is_split(), unit.first};
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      sums.of(k) += primaries.emitted(k);
      const float alpha = primaries.alpha(k);
      pixel.alpha += alpha;
      if (is_split()) samples_.add(primaries.film_position(k), alpha);
    }
    pixel.alpha /= static_cast<float>(samples);
    pixels_.push_back(pixel);
    estimator_.estimate(unit, sums);
  }
  if (view_.settings.diagnostics) find_diagnostics(primaries, plan);
}

void BlockRenderer::find_units(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                               uint64_t seed) {
  const Rect& pixels = primaries.pixels();
  units_.clear();
  for (int i = 0; i < pixels.area(); ++i) {
    const int x = pixels.x0 + i % pixels.width(), y = pixels.y0 + i / pixels.width();
    const size_t pixel = view_.grid.pixel(x, y);
    units_.push_back({primaries.first(i), primaries.first(i + 1),
                      std::max<uint32_t>(plan[pixel].rays, kMinRays), plan[pixel].candidates,
                      hash_words(seed, pixel, 2)});
  }
}

/// Returns the mean learned visibility, weighted by the light of each cell on an unshadowed point.
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
    const float rays = lit > 0 ? static_cast<float>(std::max<uint32_t>(p.rays, kMinRays)) : 0.f;
    diagnostics_.emplace_back(samples,
                              samples + rays + (lit > 0 ? kCandidateCost * p.candidates : 0.f),
                              lit > 0 ? visible / lit : 0.f);
  }
}

}  // namespace kinome
