#include "clustered/product/pass/block_renderer.h"

#include <algorithm>
#include <cmath>

#include "transport/camera/film_samples.h"

namespace kinome {
namespace {

/// Cost of an unshadowed candidate, in rays.
constexpr float kCandidateCost = 0.1f;
/// Number of shadow rays of a pixel for which none were planned, because the pilot missed its
/// surfaces. The control terms of such surfaces are wrong.
constexpr uint16_t kRaysOfUnplannedPixel = 2;
/// Maximum number of a pixel's samples that are added to the film in one call.
constexpr uint32_t kMaxSamples = 1024;

}  // namespace

BlockRenderer::BlockRenderer(const PassView& view)
    : view_(view),
      is_split_(transport::weighs_positions(view.primaries.sensor.film().filter())),
      groups_(view.light.group_count()),
      tracer_(view.primaries),
      learner_(view.knowledge.padded_cells(), &view.neighbours),
      estimator_(view.light) {}

Rgb BlockRenderer::colour(size_t index) const {
  const Pixel& pixel = pixels_[index];
  Rgb sum(0.f);
  const size_t sums = is_split() ? pixel.samples : 1;
  for (size_t k = 0; k < sums * groups_; ++k) sum += sums_[pixel.first + k];
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
  sums_.reserve(sums * groups_);
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
    const size_t rows = is_split() ? samples : 1;
    sums_.resize(pixel.first + rows * groups_, Rgb(0.f));
    const UnitSums sums{&sums_[pixel.first], is_split(), unit.first, groups_};
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      const uint32_t group = groups_ > 1 ? view_.light.group_of(primaries.emitter(k)) : 0;
      sums.of_group(group).of(k) += primaries.emitted(k);
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
                      plan[pixel].rays > 0 ? plan[pixel].rays : kRaysOfUnplannedPixel,
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
  const float response = view_.primaries.sensor.film().response();
  std::vector<float> values;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& pixel = pixels_[i];
    const Rgb c = colour(i);
    values.assign({c.x, c.y, c.z, pixel.alpha});
    values.resize(first_group_value());
    for (uint32_t g = 0; view_.light.groups && g < groups_; ++g) {
      const Rgb light = sums_[pixel.first + g] / static_cast<float>(pixel.samples) * response;
      values.insert(values.end(), {light.x, light.y, light.z});
    }
    colours.add_pixel(pixel.x, pixel.y, values, weight);
  }
}

/// Sets element k of the columns of layer 0 of the film to a sample, whose groups have these sums.
void BlockRenderer::set_sample(const Rgb* sums, size_t k, float response,
                               std::span<Column<float>> columns) const {
  Rgb colour(0.f);
  for (uint32_t g = 0; g < groups_; ++g) {
    colour += sums[g];
    Column<float>* const of_group = &columns[first_group_value() + 3 * size_t{g}];
    for (int c = 0; view_.light.groups && c < 3; ++c) of_group[c][k] = sums[g][c] * response;
  }
  for (int c = 0; c < 3; ++c) columns[static_cast<size_t>(c)][k] = colour[c];
}

void BlockRenderer::add_samples(FilmTile& colours, float weight) const {
  const Film& film = view_.primaries.sensor.film();
  const size_t values = first_group_value() + (view_.light.groups ? 3 * size_t{groups_} : 0);
  transport::FilmSamples film_samples(film.filter(), static_cast<int>(values), kMaxSamples);
  std::vector<Column<float>> columns(values + 2);
  std::vector<float*> of_sample;
  for (auto& column : columns) {
    column.resize(padded(kMaxSamples) + kBlockLanes);
    of_sample.push_back(column.data());
  }
  float* const x = of_sample[values];
  float* const y = of_sample[values + 1];
  of_sample.resize(values);
  for (const Pixel& pixel : pixels_) {
    for (uint32_t begin = 0; begin < pixel.samples; begin += kMaxSamples) {
      const uint32_t count = std::min(kMaxSamples, pixel.samples - begin);
      const size_t first = pixel.first / groups_ + begin;
      for (uint32_t k = 0; k < count; ++k) {
        set_sample(&sums_[(first + k) * groups_], k, film.response(), columns);
      }
      if (film.has_alpha()) std::copy_n(&samples_.alpha[first], count, columns[3].begin());
      std::copy_n(&samples_.x[first], count, x);
      std::copy_n(&samples_.y[first], count, y);
      const auto px = static_cast<uint32_t>(pixel.x), py = static_cast<uint32_t>(pixel.y);
      film_samples.add({&px, &py, 1, 0, count, 0}, {x, y}, of_sample, colours,
                       weight / static_cast<float>(pixel.samples));
    }
  }
}

}  // namespace kinome
