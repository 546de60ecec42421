#include "clustered/product/pass/block_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "transport/film_samples.h"

namespace kinome {
namespace {

/// Cost of an unshadowed candidate, in rays.
constexpr float kCandidateCost = 0.1f;
/// Number of shadow rays of a pixel for which none were planned, because the pilot missed its
/// surfaces. The control terms of such surfaces are wrong.
constexpr uint16_t kRaysOfMissed = 2;
/// Maximum number of a pixel's samples that are added to the film in one call.
constexpr uint32_t kMaxSamples = 1024;

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
void BlockRenderer::reserve(int block, std::span<const PixelPlan> plan) {
  size_t sums = 0;
  const Rect pixels = view_.task.grid.block(block);
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      sums += is_split() ? samples_of(plan[view_.task.grid.pixel(x, y)]) : 1;
    }
  }
  sums_.clear();
  sums_.reserve(sums);
}

void BlockRenderer::render(int block, std::span<const PixelPlan> plan, uint64_t seed,
                           RenderCounters& counters, const TileGrid::IsWanted& is_wanted) {
  reserve(block, plan);
  pixels_.clear();
  for (auto* const column : {&samples_.x, &samples_.y, &samples_.alpha}) column->clear();
  diagnostics_.clear();
  tracer_.trace(
      view_.task.grid, block, seed, counters.stage_seconds["primary"], counters,
      [&](const TileGrid::Tile& tile) { return !is_wanted || is_wanted(tile); },
      [&](int x, int y) { return samples_of(plan[view_.task.grid.pixel(x, y)]); },
      [&](const TileGrid::Tile& tile, TilePrimaries& primaries) {
        render_tile(tile, primaries, plan, seed, counters);
      });
  estimator_.flush();
}

/// Finds the learned visibility of each of the tile's patches.
void BlockRenderer::find_visibilities(int tile) {
  mean_visibility_.clear();
  for (size_t p = 0; p < patches_.size(); ++p) {
    if (visibility_.size() == p) visibility_.emplace_back(view_.knowledge.padded_cells());
    Patch& patch = patches_[p];
    Visibility& visibility = visibility_[p];
    view_.knowledge.recall(tile, p, patch, learner_, visibility);
    if (view_.task.settings.diagnostics) {
      mean_visibility_.push_back(mean_visibility(patch, visibility));
    }
    view_.knowledge.restrict(patch, visibility);
  }
}

void BlockRenderer::render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                                std::span<const PixelPlan> plan, uint64_t seed,
                                RenderCounters& counters) {
  view_.knowledge.patches(tile.index, patches_);
  assign_patches(primaries, patches_);
  find_visibilities(tile.index);
  find_units(tile, primaries, plan, seed);
  const std::span<const Unit> units = units_;
  estimator_.begin_tile(view_.task.scene, primaries, patches_, visibility_,
                        hash_words(seed, static_cast<uint64_t>(tile.index), 3), counters,
                        view_.task.settings.shared_candidates ? units : units.first(0));
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
      if (!is_split()) continue;
      const Vec2 position = primaries.film_position(k);
      samples_.x.push_back(position.x);
      samples_.y.push_back(position.y);
      samples_.alpha.push_back(alpha);
    }
    pixel.alpha /= static_cast<float>(samples);
    pixels_.push_back(pixel);
    estimator_.estimate(unit, sums);
  }
  if (view_.task.settings.diagnostics) find_diagnostics(primaries);
}

void BlockRenderer::find_units(const TileGrid::Tile& tile, const TilePrimaries& primaries,
                               std::span<const PixelPlan> plan, uint64_t seed) {
  units_.clear();
  tile.for_each_pixel([&](int x, int y) {
    const size_t i = units_.size(), pixel = view_.task.grid.pixel(x, y);
    units_.push_back({primaries.first(i), primaries.first(i + 1),
                      plan[pixel].rays > 0 ? plan[pixel].rays : kRaysOfMissed,
                      plan[pixel].candidates, hash_words(seed, pixel, 2)});
  });
}

/// Returns the mean learned visibility, weighted by the light of each cell on an unshadowed point.
float BlockRenderer::mean_visibility(const Patch& patch, const Visibility& visibility) const {
  double all = 0, visible = 0;
  const DistantCells& cells = view_.light.cells;
  for (uint32_t c = 0; c < cells.size(); ++c) {
    const Vec3 axis(cells.axis()[0][c], cells.axis()[1][c], cells.axis()[2][c]);
    const double light = cells.flux()[c] * std::max(0.f, glm::dot(axis, patch.normal));
    all += light;
    visible += light * visibility.v[c];
  }
  if (cells.size() == 0) return patch.mean_visibility;
  return all > 0 ? static_cast<float>(visible / all) : 0.f;
}

void BlockRenderer::find_diagnostics(const TilePrimaries& primaries) {
  for (const Unit& unit : units_) {
    float visible = 0, lit = 0;
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      if (primaries.patch(k) < 0) continue;
      visible += mean_visibility_[primaries.patch(k)];
      lit += 1;
    }
    const auto samples = static_cast<float>(unit.end - unit.first);
    const float rays = lit > 0 ? static_cast<float>(unit.rays) : 0.f;
    diagnostics_.emplace_back(samples,
                              samples + rays + (lit > 0 ? kCandidateCost * unit.candidates : 0.f),
                              lit > 0 ? visible / lit : 0.f);
  }
}

void BlockRenderer::add_to(FilmTile& colours, float weight) const {
  if (is_split()) {
    add_samples(colours, weight);
    return;
  }
  const size_t values = view_.primaries.sensor.film().has_alpha() ? 4 : 3;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Rgb c = colour(i);
    const std::array<float, 4> pixel{c.x, c.y, c.z, pixels_[i].alpha};
    colours.add_pixel(pixels_[i].x, pixels_[i].y, {pixel.data(), values}, weight);
  }
}

void BlockRenderer::add_samples(FilmTile& colours, float weight) const {
  const Film& film = view_.primaries.sensor.film();
  const size_t values = film.has_alpha() ? 4 : 3;
  transport::FilmSamples film_samples(film.filter(), static_cast<int>(values), kMaxSamples);
  std::array<Column<float>, 6> columns;
  for (auto& column : columns) column.resize(padded(kMaxSamples) + kBlockLanes);
  auto& [r, g, b, alpha, x, y] = columns;
  std::vector<float*> of_sample{r.data(), g.data(), b.data(), alpha.data()};
  of_sample.resize(values);
  for (const Pixel& pixel : pixels_) {
    for (uint32_t begin = 0; begin < pixel.samples; begin += kMaxSamples) {
      const uint32_t count = std::min(kMaxSamples, pixel.samples - begin);
      const size_t first = pixel.first + begin;
      for (uint32_t k = 0; k < count; ++k) {
        const Rgb& c = sums_[first + k];
        r[k] = c.x, g[k] = c.y, b[k] = c.z;
      }
      std::copy_n(&samples_.alpha[first], count, alpha.begin());
      std::copy_n(&samples_.x[first], count, x.begin());
      std::copy_n(&samples_.y[first], count, y.begin());
      const auto px = static_cast<uint32_t>(pixel.x), py = static_cast<uint32_t>(pixel.y);
      film_samples.add({&px, &py, 1, 0, count, 0}, {x.data(), y.data()}, of_sample, colours,
                       weight / static_cast<float>(pixel.samples));
    }
  }
}

}  // namespace kinome
