#pragma once

#include <cstdint>
#include <vector>

#include "clustered/product/tile_grid.h"
#include "kinome/bsdf.h"

namespace kinome {

/// Method of each tile, product sampling or `path`, by the work that a trial measured. The work of a
/// tile is estimated by kernel regression (Nadaraya and Watson 1964) from the tiles of the trial:
/// those near by, and those that show the same material, count most. Works are averaged by their
/// roots: (mean of roots)^2. A few tiles with outliers then don't decide for the whole image, because
/// few tiles show too many outliers or none. Immutable.
class MethodMap {
 public:
  /// A tile of the trial.
  struct Trial {
    int tile;                  ///< TileGrid::Tile::index
    const Bsdf* bsdf;          ///< of most of its primaries; nullptr: of no surface
    double product, path;      ///< work to the same error, in a common unit
  };
  /// `grid` must outlive it.
  MethodMap(const TileGrid& grid, std::vector<Trial> trials);

  /// True if `path` is expected to take less work in a tile that shows this material.
  bool is_for_path(int tile, const Bsdf* bsdf) const { return is_for_path(tile, bsdf, -1); }
  /// Work of all trials if each tile had the method that the trials farther away suggest. A
  /// standard error is added to the roots of product sampling, because few tiles show few of its
  /// bright outliers.
  double mixed_work() const;
  /// The same if all tiles had product sampling.
  double product_work() const;
  double path_work() const { return work_of(path_); }

 private:
  /// `left_out`: a tile near which no trial counts, or -1.
  bool is_for_path(int tile, const Bsdf* bsdf, int left_out) const;
  /// Work of all trials, of the sum of their roots.
  double work_of(double sum_of_roots) const;

  const TileGrid& grid_;
  const std::vector<Trial> roots_;  ///< with the roots of the works
  double product_ = 0, path_ = 0;   ///< sums of roots
};

}  // namespace kinome
