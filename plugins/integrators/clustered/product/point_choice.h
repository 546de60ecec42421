#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "clustered/product/cell_light.h"
#include "clustered/product/local_choice.h"

namespace kinome {

/// Chooses, for a place that a path from the eye has found, one of a block of light points to
/// connect it to. One per thread; not thread-safe. `light`, which has local light, must outlive it.
class PointChoice {
 public:
  explicit PointChoice(const CellLight& light) : light_(light) {}

  /// The points of a tile: [begin, end) of all points taken since clear(). `begin` is a multiple of
  /// kBlockLanes.
  struct Block {
    size_t begin = 0, end = 0;
  };
  struct Chosen {
    const LightPoint& point;
    float probability;
    float weight;  ///< LocalChoice::Block::weight
  };

  void clear() { points_.clear(); }
  /// Takes a block of the points that `choice` has, but for those that a path which has `edges`
  /// when it meets them would be too long with. `bits`: random.
  Block take(const LocalChoice& choice, uint32_t bits, uint32_t edges);
  /// Chooses one point of a block with a probability about in proportion to the light that it sends
  /// to y. Returns nullopt if no point sends any light there.
  std::optional<Chosen> choose(const SurfaceInteraction& y, Block block, float u);
  /// Odds for a path from the eye to find the point as its third, against points that are looked
  /// at: to be multiplied by the density of places there.
  float third_odds(const LightPoint& point, std::span<const float> rates) const {
    return light_.local->third_ratio(point.cell) / rates[point.cell];
  }

 private:
  /// Columns of the points that choose() reads.
  enum Number { kPosition, kNormal = 3, kGeometric = 6, kPower = 9, kOdds, kWeight, kNumbers };

  void grow();

  const CellLight& light_;
  std::vector<uint32_t> points_;  ///< indices into the local points of the pass, padded
  Column<float> columns_[kNumbers];
  Column<float> chances_;  ///< of the points of one block, not normalised
};

}  // namespace kinome
