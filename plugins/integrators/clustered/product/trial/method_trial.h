#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "clustered/product/tiles/tile_grid.h"
#include "kinome/math.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/render_context.h"

namespace kinome {

/// Reconstruction filter for the means of whole pixels. Has weights of a pixel and its neighbours,
/// for samples that are spread evenly over each pixel. Filters noise that neighbouring pixels share
/// as the film does. Immutable.
class PixelFilter {
 public:
  /// Neighbours farther away, in pixels, are ignored.
  static constexpr int kReach = 2;

  /// Box filter as wide as a pixel, which doesn't change images.
  PixelFilter() { weights_[kReach] = 1; }
  explicit PixelFilter(const ReconstructionFilter& filter);

  float weight(int dx, int dy) const { return weights_[kReach + dx] * weights_[kReach + dy]; }
  /// Factor by which the filter changes the variance of noise that is independent between pixels.
  float variance() const;

 private:
  std::array<float, 2 * kReach + 1> weights_{};  ///< sum: 1
};

/// Compares the work that two methods need for the same error of an image. Renders some tiles twice
/// by each method. The squared difference of the two renders is multiplied by their cost. Costs are
/// numbers of rays, which are the same on every machine. None of these renders is part of the
/// image, so that it stays unbiased.
class MethodTrial {
 public:
  static constexpr size_t kMinTiles = 16;
  /// Chooses about `tiles` tiles, at most half of the image's. They are in groups of 2x2 that are
  /// spread over the image. Skips tiles that the image's border cuts. `grid` must outlive this
  /// object. `filter` is that of the film: errors are those of filtered images.
  MethodTrial(const TileGrid& grid, int tiles, uint64_t seed, const PixelFilter& filter = {});
  const TileGrid& grid() const { return grid_; }
  /// True if no tile was chosen.
  bool empty() const { return chosen_.empty(); }
  bool is_wanted(const TileGrid::Tile& tile) const { return wanted_[tile.index] != 0; }
  /// Fraction of the image's tiles that was chosen.
  double share() const { return static_cast<double>(chosen_.size()) / std::max(1, grid_.tiles()); }
  /// Keeps about this fraction of the tiles, but at least kMinTiles. The remaining tiles are spread
  /// over the image, too.
  void keep(double share);
  const PixelFilter& film_filter() const { return filter_; }
  /// Returns pixels() of an image, filtered. Ignores other pixels.
  std::vector<Rgb> filtered(std::span<const Rgb> image) const;
  /// Pixels of the chosen tiles (TileGrid::pixel), tile by tile, row by row.
  std::vector<size_t> pixels() const;
  /// Calls fn(tile, worker, counters) for the index of each chosen tile, on many threads, like
  /// TileGrid::for_each_block. A block may have all chosen tiles that see any light. Transfers the
  /// tiles' pixels, which fn sets, to the other processes of a group.
  template <class Worker, class Make, class Function>
  void for_each_tile(Scheduler& scheduler, std::span<Rgb> image, const Make& make,
                     const Function& fn) const {
    SharedItems shared([&](size_t item, SharedBytes& bytes) {
      const auto index = static_cast<int>(chosen_[item]);
      grid_.for_each_tile(grid_.block_of(index), [&](const TileGrid::Tile& tile) {
        if (tile.index != index) return;
        tile.for_each_pixel([&](int x, int y) { bytes.value(image[grid_.pixel(x, y)]); });
      });
    });
    transport::Workers<Worker> workers;
    scheduler.for_each(
        chosen_.size(),
        [&](size_t item, RenderCounters& counters) {
          workers.with_one(make, [&](Worker& worker) {
            const StageTimer timer(counters.stage_seconds["trial"]);
            fn(static_cast<int>(chosen_[item]), worker, counters);
          });
        },
        &shared);
  }
  /// Calls fn(index) for each pixel of the chosen tiles of a block, tile by tile, row by row.
  template <class Function>
  void for_each_pixel(int block, const Function& fn) const {
    grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      if (!is_wanted(tile)) return;
      tile.for_each_pixel([&](int x, int y) { fn(grid_.pixel(x, y)); });
    });
  }

  /// A method to compare.
  struct Way {
    /// Renders the tiles that `tiles` wants for the index-th time, with independent random numbers
    /// each time. Writes to an image of the grid (TileGrid::pixel). `tiles` is the trial or a part
    /// of it.
    std::function<void(const MethodTrial& tiles, uint64_t index, std::span<Rgb> image)> render;
    /// Cost of each ray that `render` traces, except light rays, which cost nothing.
    double cost_of_ray = 1;
    double extra_cost = 0;  ///< cost of a render besides those rays, such as that of light rays
    /// Variance of each pixel by light that `render` leaves out (mean of the channels). May be
    /// empty.
    std::vector<float> more_variance{};
    /// Variance of the brightness of a whole render, divided by that of a render in the trial.
    double common_share = 1;
  };
  /// Errors of a render by each method in a tile, summed over its pixels.
  struct TileErrors {
    int tile;  ///< TileGrid::Tile::index
    double first, second;
  };
  struct Result {
    double cost = 1;  ///< of the second method's renders, relative to the first one's
    /// Expected relative deviation of the brightness of a whole render by the first method. It
    /// follows from the differences among its renders in the trial, and from those to the second
    /// method's renders. The differences that the second method's noise explains are subtracted.
    double deviation = 0;
    std::vector<TileErrors> tiles;
  };
  /// Error of a single render, and its cost.
  struct RenderError {
    double rel_mse = 0;
    double cost = 0;
  };
  /// Renders the tiles twice by one method and measures its relMSE. It is 0 if all is black.
  RenderError measure(const Way& way, RenderContext& context) const;

  /// Renders the tiles and measures errors and costs. `tiles` of the result is empty if there is
  /// nothing to compare.
  ///
  /// The error of a pixel is relative to the brightness of its tile, or to its own brightness if
  /// that is larger. A pixel's own brightness is the mean of the middle two of its four renders, so
  /// that a single outlier doesn't count as brightness. If both renders by one method are darker,
  /// the difference counts as its error, because rare and bright light makes no noise while it is
  /// missed.
  ///
  /// Calls `is_enough` after the first render by the first method: for a part of the tiles, then
  /// for all. It gets the errors of a single render. The first method's error is estimated by its
  /// difference from the second method's renders. If it returns true, compare() returns these
  /// errors, without a deviation. It is not called if a method has more_variance.
  Result compare(const Way& first, const Way& second, RenderContext& context,
                 const std::function<bool(const Result&)>& is_enough = nullptr) const;

 private:
  /// Returns the parts of the trial, which are rendered one after another.
  std::vector<MethodTrial> parts() const;

  const TileGrid& grid_;
  PixelFilter filter_;
  std::vector<uint8_t> wanted_;  ///< 1 for each chosen tile
  std::vector<size_t> chosen_;   ///< group by group, in the order in which they were chosen
};

}  // namespace kinome
