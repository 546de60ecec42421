#include "clustered/product/trial/method_trial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "clustered/product/tiles/spread.h"
#include "transport/blocks/large_array.h"

namespace kinome {
namespace {

/// Side of a group of tiles, in tiles.
constexpr int kGroupSide = 2;
/// Share of the tiles that are rendered first. They may be enough.
constexpr double kFirstPart = 0.3;

/// Number of rays, other than light rays.
double rays_of(const RenderCounters& counters) {
  double sum = 0;
  for (int kind = 0; kind < kRayKindCount; ++kind) {
    if (static_cast<RayKind>(kind) != RayKind::kLight) {
      sum += static_cast<double>(counters.rays[kind]);
    }
  }
  return sum;
}

double squared(double x) {
  return x * x;
}

/// Mean of the channels' squares.
double mean_square(const Rgb& c) {
  return glm::dot(c, c) / 3.0;
}

/// Renders by one method.
struct Renders {
  LargeArray<Rgb> images[2];
  double cost = 0;  ///< of all renders so far
};

/// The same renders, filtered: MethodTrial::pixels() of each.
using Filtered = std::array<std::vector<Rgb>, 2>;

/// A tile that was rendered.
struct Part {
  int tile;
  size_t first;                ///< index in MethodTrial::pixels() of its first pixel
  std::vector<size_t> pixels;  ///< TileGrid::pixel of each
  Rgb means[4];                ///< two by the first method, then two by the second
  Rgb mean() const { return (means[0] + means[1] + means[2] + means[3]) * 0.25f; }
};

/// Renders the tiles of a part of the trial.
void render(const MethodTrial& trial, const MethodTrial::Way& way, const MethodTrial& part,
            uint64_t index, Renders& renders, RenderContext& context) {
  const RenderCounters& counters = context.job.stats().counters;
  const double rays = rays_of(counters);
  LargeArray<Rgb>& image = renders.images[index];
  image.resize(static_cast<size_t>(trial.grid().crop().area()));
  way.render(part, index, image);
  renders.cost +=
      (rays_of(counters) - rays) * way.cost_of_ray + way.extra_cost * part.share() / trial.share();
}

Filtered all_filtered(const MethodTrial& trial, const Renders& renders) {
  return {trial.filtered(renders.images[0]), trial.filtered(renders.images[1])};
}

/// Returns the rendered tiles with their brightness.
std::vector<Part> parts_of(const MethodTrial& trial, const Filtered& a, const Filtered& b) {
  const TileGrid& grid = trial.grid();
  std::vector<Part> parts;
  size_t next = 0;
  for (int block = 0; block < grid.blocks_x() * grid.blocks_y(); ++block) {
    grid.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      if (!trial.is_wanted(tile)) return;
      Part part{tile.index, next, {}, {}};
      tile.for_each_pixel([&](int x, int y) { part.pixels.push_back(grid.pixel(x, y)); });
      next += part.pixels.size();
      const auto mean_of_tile = [&](const std::vector<Rgb>& pixels) {
        Rgb sum(0.f);
        for (size_t i = part.first; i < next; ++i) sum += pixels[i];
        return sum / static_cast<float>(part.pixels.size());
      };
      for (size_t k = 0; k < 2; ++k) {
        part.means[k] = mean_of_tile(a[k]);
        part.means[2 + k] = mean_of_tile(b[k]);
      }
      parts.push_back(std::move(part));
    });
  }
  return parts;
}

/// Error of a method's renders in a tile: the weighted squared difference of two renders.
double noise_of(const MethodTrial& trial, const MethodTrial::Way& way, const Filtered& renders,
                const Part& part, const std::vector<float>& weights) {
  double error = 0;
  for (size_t k = 0; k < part.pixels.size(); ++k) {
    const size_t i = part.first + k;
    // The variance of a difference is twice that of a render.
    double square = 0.5 * mean_square(renders[0][i] - renders[1][i]);
    if (!way.more_variance.empty()) {
      square +=
          static_cast<double>(trial.film_filter().variance() * way.more_variance[part.pixels[k]]);
    }
    error += static_cast<double>(weights[k]) * square;
  }
  return error;
}

/// Weight of each pixel's squared error.
std::vector<float> weights_of(const Filtered& a, const Filtered& b, const Part& part,
                              double floor) {
  const double of_tile = mean_square(part.mean());
  std::vector<float> weights;
  for (size_t i = part.first; i < part.first + part.pixels.size(); ++i) {
    double values[4] = {mean_square(a[0][i]), mean_square(a[1][i]), mean_square(b[0][i]),
                        mean_square(b[1][i])};
    std::sort(std::begin(values), std::end(values));
    const double own = (values[1] + values[2]) / 2;
    weights.push_back(static_cast<float>(1 / (std::max(of_tile, own) + floor)));
  }
  return weights;
}

/// Returns MethodTrial::Result::deviation. `is_comparable` is true if the renders of both methods
/// contain all light.
double deviation_of(const TileGrid& grid, const MethodTrial::Way& first,
                    const std::vector<Part>& parts, bool is_comparable) {
  double sums[4] = {0, 0, 0, 0};
  std::map<int, double> differences;  // per group of tiles; groups are independent of one another
  for (const Part& part : parts) {
    double means[4];
    for (int k = 0; k < 4; ++k) sums[k] += means[k] = mean_of(part.means[k]);
    const int x = part.tile % grid.tiles_x() / kGroupSide;
    const int y = part.tile / grid.tiles_x() / kGroupSide;
    differences[y * grid.tiles_x() + x] += (means[0] + means[1] - means[2] - means[3]) / 2;
  }
  const double brightness = (sums[0] + sums[1] + sums[2] + sums[3]) / 4;
  // Half of the squared difference of two renders is the variance of one.
  const double variance = squared(sums[0] - sums[1]) / 2;
  double square = first.common_share * std::max(0., variance - squared(sums[2] - sums[3]) / 2);
  const auto n = static_cast<double>(differences.size());
  if (is_comparable && n > 1) {
    double sum = 0, squares = 0;
    for (const auto& [group, difference] : differences) {
      sum += difference;
      squares += squared(difference);
    }
    const double noise = std::sqrt(std::max(0., squares - squared(sum) / n) * n / (n - 1));
    // Light that the second method finds rarely makes no noise while it is missed.
    const double excess = std::max(0., sum > 0 ? sum - 2 * noise : -sum - noise);
    square += std::max(0., squared(excess) - variance / 2);
  }
  return std::sqrt(square) / brightness;
}

/// Square of the brightness below which errors are absolute. 0 if all is black.
double floor_of(const std::vector<Part>& parts) {
  double mean = 0;
  for (const Part& part : parts) mean += mean_of(part.mean());
  return 0.01 * squared(mean / static_cast<double>(std::max<size_t>(1, parts.size())));
}

/// Result of these tiles by the first render of the first method. Its squared difference from the
/// mean of the second method's renders is the sum of two terms: its own squared error, and half of
/// the variance of one of the second method's renders.
MethodTrial::Result first_result(const MethodTrial& trial, const MethodTrial::Way& first,
                                 const MethodTrial::Way& second, const Renders& by_first,
                                 const Renders& by_second) {
  const Filtered b = all_filtered(trial, by_second);
  Filtered a{trial.filtered(by_first.images[0]), b[0]};
  for (size_t i = 0; i < a[1].size(); ++i) a[1][i] = (b[0][i] + b[1][i]) * 0.5f;
  const std::vector<Part> parts = parts_of(trial, a, b);
  const double floor = floor_of(parts);
  MethodTrial::Result result;
  if (!(floor > 0) || !(by_first.cost > 0 && by_second.cost > 0)) return result;
  result.cost = by_second.cost / (2 * by_first.cost);
  for (const Part& part : parts) {
    const std::vector<float> weights = weights_of(a, b, part, floor);
    const double noise = noise_of(trial, second, b, part, weights);
    result.tiles.push_back(
        {part.tile, 2 * noise_of(trial, first, a, part, weights) - noise / 2, noise});
  }
  return result;
}

}  // namespace

PixelFilter::PixelFilter(const ReconstructionFilter& filter) {
  float sum = 0;
  for (int d = -kReach; d <= kReach; ++d) {
    weights_[kReach + d] = static_cast<float>(filter.integral(d - 0.5, d + 0.5));
    sum += weights_[kReach + d];
  }
  for (float& weight : weights_) weight /= sum;
}

float PixelFilter::variance() const {
  float squares = 0;
  for (const float weight : weights_) squares += sqr(weight);
  return sqr(squares);
}

MethodTrial::MethodTrial(const TileGrid& grid, int tiles, uint64_t seed, const PixelFilter& filter)
    : grid_(grid), filter_(filter), wanted_(static_cast<size_t>(grid.tiles())) {
  const int whole_x = grid.crop().width() / kTileSide, whole_y = grid.crop().height() / kTileSide;
  const int columns = (whole_x + kGroupSide - 1) / kGroupSide;
  const int rows = (whole_y + kGroupSide - 1) / kGroupSide;
  const auto max_tiles = std::min(static_cast<size_t>(tiles), wanted_.size() / 2);
  // Several points may fall into one group.
  for (uint32_t i = 0; chosen_.size() < max_tiles && i < 4 * max_tiles; ++i) {
    const int x0 = static_cast<int>(scaled(random_bits(seed, 0) + i * kGolden, columns));
    const int y0 = static_cast<int>(scaled(random_bits(seed, 1) + i * kPlastic, rows));
    for (int k = 0; k < kGroupSide * kGroupSide; ++k) {
      const int x = x0 * kGroupSide + k % kGroupSide, y = y0 * kGroupSide + k / kGroupSide;
      if (x >= whole_x || y >= whole_y) continue;
      const size_t tile = static_cast<size_t>(y) * grid.tiles_x() + x;
      if (wanted_[tile] == 0) chosen_.push_back(tile);
      wanted_[tile] = 1;
    }
  }
}

void MethodTrial::keep(double share) {
  const double kept = std::clamp(share, 0., 1.) * static_cast<double>(chosen_.size());
  const size_t count = std::max(kMinTiles, static_cast<size_t>(kept));
  for (size_t i = count; i < chosen_.size(); ++i) wanted_[chosen_[i]] = 0;
  if (count < chosen_.size()) chosen_.resize(count);
}

std::vector<size_t> MethodTrial::pixels() const {
  std::vector<size_t> pixels;
  for (int block = 0; block < grid_.blocks_x() * grid_.blocks_y(); ++block) {
    for_each_pixel(block, [&](size_t i) { pixels.push_back(i); });
  }
  return pixels;
}

std::vector<MethodTrial> MethodTrial::parts() const {
  std::vector<MethodTrial> parts(2, *this);
  parts[0].keep(kFirstPart);
  const size_t count = parts[0].chosen_.size();
  for (size_t i = 0; i < count; ++i) parts[1].wanted_[chosen_[i]] = 0;
  parts[1].chosen_.erase(parts[1].chosen_.begin(),
                         parts[1].chosen_.begin() + static_cast<std::ptrdiff_t>(count));
  if (parts[1].empty()) parts.pop_back();
  return parts;
}

std::vector<Rgb> MethodTrial::filtered(std::span<const Rgb> image) const {
  const int width = grid_.crop().width(), height = grid_.crop().height();
  std::vector<Rgb> result;
  for (const size_t i : pixels()) {
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    Rgb sum(0.f);
    float weights = 0;
    for (int dy = -PixelFilter::kReach; dy <= PixelFilter::kReach; ++dy) {
      for (int dx = -PixelFilter::kReach; dx <= PixelFilter::kReach; ++dx) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
        const int tile = ny / kTileSide * grid_.tiles_x() + nx / kTileSide;
        if (wanted_[tile] == 0) continue;
        sum += filter_.weight(dx, dy) * image[static_cast<size_t>(ny) * width + nx];
        weights += filter_.weight(dx, dy);
      }
    }
    result.push_back(sum / weights);
  }
  return result;
}

MethodTrial::RenderError MethodTrial::measure(const Way& way, RenderContext& context) const {
  Renders renders;
  for (const uint64_t index : {0, 1}) render(*this, way, *this, index, renders, context);
  const Filtered images = all_filtered(*this, renders);
  const std::vector<Part> parts = parts_of(*this, images, images);
  const double floor = floor_of(parts);
  RenderError error{0, renders.cost / 2};
  if (context.job.cancelled() || !(floor > 0)) return error;
  for (const Part& part : parts) {
    error.rel_mse += noise_of(*this, way, images, part, weights_of(images, images, part, floor));
  }
  error.rel_mse /= static_cast<double>(pixels().size());
  return error;
}

MethodTrial::Result MethodTrial::compare(
    const Way& first, const Way& second, RenderContext& context,
    const std::function<bool(const Result&)>& is_enough) const {
  const bool is_comparable = first.more_variance.empty() && second.more_variance.empty();
  const bool may_be_enough = is_enough && is_comparable;
  Renders by_first, by_second;
  MethodTrial seen = *this;
  seen.chosen_.clear();
  std::fill(seen.wanted_.begin(), seen.wanted_.end(), 0);
  for (const MethodTrial& part : may_be_enough ? parts() : std::vector{*this}) {
    for (const uint64_t index : {0, 1}) render(*this, second, part, index, by_second, context);
    render(*this, first, part, 0, by_first, context);
    if (!may_be_enough || context.job.cancelled()) continue;
    for (const size_t tile : part.chosen_) {
      seen.chosen_.push_back(tile);
      seen.wanted_[tile] = 1;
    }
    Result result = first_result(seen, first, second, by_first, by_second);
    if (!result.tiles.empty() && is_enough(result)) return result;
  }
  render(*this, first, *this, 1, by_first, context);
  if (context.job.cancelled() || !(by_first.cost > 0 && by_second.cost > 0)) return {};
  const Filtered a = all_filtered(*this, by_first), b = all_filtered(*this, by_second);
  const std::vector<Part> parts = parts_of(*this, a, b);
  const double floor = floor_of(parts);
  if (!(floor > 0)) return {};
  Result result;
  result.cost = by_second.cost / by_first.cost;
  result.deviation = deviation_of(grid_, first, parts, is_comparable);
  for (const Part& part : parts) {
    const std::vector<float> weights = weights_of(a, b, part, floor);
    TileErrors errors{part.tile, noise_of(*this, first, a, part, weights),
                      noise_of(*this, second, b, part, weights)};
    // The squared difference between the means of both methods, minus its expectation by noise. It
    // is added to the error of the method that finds less light here. By chance alone, sums over
    // many tiles are 0 on average. Not with more_variance, whose light is in neither render.
    if (is_comparable) {
      const Rgb difference = (part.means[0] + part.means[1] - part.means[2] - part.means[3]) * 0.5f;
      const double noise = (mean_square(part.means[0] - part.means[1]) +
                            mean_square(part.means[2] - part.means[3])) /
                           4;
      const double excess = static_cast<double>(part.pixels.size()) *
                            (mean_square(difference) - noise) / (mean_square(part.mean()) + floor);
      (mean_of(difference) < 0 ? errors.first : errors.second) += excess;
    }
    result.tiles.push_back(errors);
  }
  return result;
}

}  // namespace kinome
