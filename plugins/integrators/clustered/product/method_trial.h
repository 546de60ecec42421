#pragma once

#include <functional>
#include <vector>

#include "clustered/product/tile_grid.h"
#include "kinome/render_context.h"

namespace kinome {

/// Asks which way to the picture takes less work, where there are two. Some tiles are rendered
/// twice by each; how far the two renders differ is multiplied by what they took, counted in rays,
/// which is the same on every machine. None of it is part of the picture, which stays unbiased
/// whatever is chosen.
class MethodTrial {
 public:
  /// Chooses tiles that are spread over the picture. `grid` must outlive it.
  MethodTrial(const TileGrid& grid, uint64_t seed);
  /// False where the picture is so small that a few tiles of it tell nothing.
  bool is_possible() const;
  bool is_wanted(const TileGrid::Tile& tile) const;
  /// Of the picture, about.
  double share() const { return 1. / static_cast<double>(stride_); }

  struct Way {
    /// Renders the tiles that are wanted for the index-th time, each with random numbers of its
    /// own, into a picture of the grid (TileGrid::pixel).
    std::function<void(uint64_t index, std::vector<Rgb>& picture)> render;
    double cost_of_ray = 1;    ///< of all but light rays
    double cost_of_light = 1;  ///< of light rays
    /// What light that no tile has adds to each pixel's variance (mean of the channels), and what
    /// it costs; may be empty.
    std::vector<float> more_variance{};
    double more_cost = 0;
  };
  /// Work of the second way to the same error, in units of the first one's. The error is relative
  /// to how bright a tile is; that of pixels would say little of bright outliers, each of which
  /// makes its own pixel bright.
  double compare(const Way& first, const Way& second, RenderContext& context) const;

 private:
  struct Renders {
    std::vector<Rgb> pictures[2];
    double cost = 0;
  };
  Renders run(const Way& way, RenderContext& context) const;

  const TileGrid& grid_;
  const uint64_t seed_;
  const uint64_t stride_;  ///< one of so many tiles is wanted
};

}  // namespace kinome
