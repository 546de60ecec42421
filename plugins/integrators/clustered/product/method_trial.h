#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "clustered/product/pixel_filter.h"
#include "clustered/product/tile_grid.h"
#include "kinome/render_context.h"

namespace kinome {

/// Compares two ways to render an image by the work that they take to the same error. Some tiles
/// are rendered twice by each way; the squared difference of the two renders is multiplied by their
/// cost, counted in rays, which is the same on every machine. None of these renders is part of the
/// image, which stays unbiased whatever is chosen.
class MethodTrial {
 public:
  static constexpr size_t kMinTiles = 16;
  /// Chooses about `tiles` tiles, at most half of the image's, in groups of 2x2 that are spread
  /// over the image. Tiles cut by the image's border are left out. `grid` must outlive it.
  /// `filter`: of the film; errors are those of filtered images.
  MethodTrial(const TileGrid& grid, int tiles, uint64_t seed, const PixelFilter& filter = {});
  const TileGrid& grid() const { return grid_; }
  /// True if no tile was chosen.
  bool empty() const { return chosen_.empty(); }
  bool is_wanted(const TileGrid::Tile& tile) const { return wanted_[tile.index] != 0; }
  /// Share of the image's tiles that was chosen.
  double share() const { return static_cast<double>(chosen_.size()) / std::max(1, grid_.tiles()); }
  /// Gives up all tiles but about this share of them, at least kMinTiles. Those that remain are
  /// spread over the image, too.
  void keep(double share);
  /// Pixels of the chosen tiles (TileGrid::pixel), tile by tile, row by row.
  std::vector<size_t> pixels() const;

  struct Way {
    /// Renders the tiles that `tiles` wants for the index-th time, each with random numbers of its
    /// own, into a picture of the grid (TileGrid::pixel). `tiles`: the trial, or a part of it.
    std::function<void(const MethodTrial& tiles, uint64_t index, std::vector<Rgb>& picture)> render;
    double cost_of_ray = 1;  ///< that `render` traces; light rays cost nothing
    double more_cost = 0;    ///< of a render, for all that `render` doesn't trace, and light rays
    /// Variance that light in none of the tiles adds to each pixel (mean of the channels); may be
    /// empty.
    std::vector<float> more_variance{};
    /// Variance of a whole render's brightness over that of a render in the trial.
    double common_share = 1;
  };
  /// Errors of the two ways in a tile: sums over its pixels, of a render.
  struct TileErrors {
    int tile;  ///< TileGrid::Tile::index
    double first, second;
  };
  struct Result {
    double cost = 1;  ///< of the second way's renders, in units of the first one's
    /// Expected deviation of a whole render's brightness by the first way, relative: by how far its
    /// renders in the trial are from one another and from the second way's, less what the noise of
    /// the second way explains.
    double deviation = 0;
    std::vector<TileErrors> tiles;
  };
  /// Error of a single render, and its cost.
  struct RenderError {
    double rel_mse = 0;
    double cost = 0;
  };
  /// Renders the tiles twice by one way and measures its relMSE, which is 0 if all is black.
  RenderError measure(const Way& way, RenderContext& context) const;

  /// Renders the tiles and measures errors and costs. `tiles` is empty if there is nothing to
  /// compare. The error of a pixel is relative to the brightness of its tile or, if that is larger,
  /// to its own: the mean of the middle two of its four renders, so that a single outlier does not
  /// count as brightness. If a way finds less light in both of its renders, the difference counts
  /// as its error, because rare and bright light makes no noise while it is missed.
  ///
  /// `is_enough` is called with the errors of a single render by the first way, estimated by its
  /// difference from those by the second way: first of a part of the tiles, then of all. If it
  /// returns true, this is the result, without a deviation. It is not called if either way has
  /// more_variance.
  Result compare(const Way& first, const Way& second, RenderContext& context,
                 const std::function<bool(const Result&)>& is_enough = nullptr) const;

 private:
  struct Renders {
    std::vector<Rgb> pictures[2];
    double cost = 0;  ///< of all renders so far
  };
  /// A tile that was rendered.
  struct Part {
    int tile;
    std::vector<size_t> pixels;
    Rgb means[4];  ///< of the first way's renders and the second's
    Rgb mean() const { return (means[0] + means[1] + means[2] + means[3]) * 0.25f; }
  };
  void render(const Way& way, const MethodTrial& tiles, uint64_t index, Renders& renders,
              RenderContext& context) const;
  Result first_result(const Way& first, const Way& second, Renders a, Renders b) const;
  /// Parts of the trial that are rendered one after another.
  std::vector<MethodTrial> parts() const;
  void filter(std::vector<Rgb>& picture) const;
  std::vector<Part> parts_of(const Renders& a, const Renders& b) const;
  /// Brightness below which errors of the parts are absolute, squared. 0 if all is black.
  static double floor_of(const std::vector<Part>& parts);
  double noise_of(const Way& way, const Renders& renders, const Part& part,
                  const std::vector<float>& weights) const;
  static std::vector<float> weights_of(const Renders& a, const Renders& b, const Part& part,
                                       double floor);
  double deviation_of(const Way& first, const std::vector<Part>& parts, bool is_comparable) const;

  const TileGrid& grid_;
  PixelFilter filter_;
  std::vector<uint8_t> wanted_;  ///< 1 for each chosen tile
  std::vector<size_t> chosen_;   ///< group by group, in the order in which they were chosen
};

}  // namespace kinome
