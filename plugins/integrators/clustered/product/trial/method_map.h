#pragma once

#include <cstdint>
#include <vector>

#include "clustered/product/tiles/tile_grid.h"
#include "kinome/bsdf.h"

namespace kinome {

/// Selects product sampling or `path` for each tile, by the work that a trial measured. Estimates
/// the work of a tile by kernel regression (Nadaraya and Watson 1964) from the tiles of the trial.
/// Nearby tiles and tiles that show the same material have the largest weights. Averages the square
/// roots of works, and squares the mean, so that a few tiles with outliers don't decide for the
/// whole image. Immutable.
class MethodMap {
 public:
  /// A tile of the trial.
  struct Trial {
    int tile;                  ///< TileGrid::Tile::index
    const Bsdf* bsdf;          ///< material of most primaries; nullptr if they hit no surface
    double product, path;      ///< work for the same error, in a common unit
  };
  MethodMap(const TileGrid& grid, std::vector<Trial> trials);

  /// True if `path` is expected to take less work in a tile that shows this material. Ignores the
  /// trials near tile `left_out`, unless it is -1.
  bool is_for_path(int tile, const Bsdf* bsdf, int left_out = -1) const;
  /// Work of all trials if each tile had the method that the trials farther away suggest. Adds a
  /// standard error to the roots of product sampling, because a few tiles contain few of its bright
  /// outliers.
  double mixed_work() const;
  /// Work of all trials if all tiles had product sampling. Includes the standard error, too.
  double product_work() const;
  double path_work() const { return work_of(path_); }

 private:
  /// Work of all trials, given the sum of their roots.
  double work_of(double sum_of_roots) const;

  const TileGrid grid_;
  const std::vector<Trial> roots_;  ///< square roots of the works
  double product_ = 0, path_ = 0;   ///< sums of roots
};

}  // namespace kinome
