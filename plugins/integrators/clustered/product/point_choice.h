#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clustered/product/cell_light.h"
#include "clustered/product/local_choice.h"

namespace kinome {

/// Chooses, for a place that a path from the eye has found, one of a block of light points to
/// connect it to. One per thread; not thread-safe. `light`, which has local light, must outlive it.
class PointChoice {
 public:
  explicit PointChoice(const CellLight& light) : light_(light) {}

  /// The points of a tile: [begin, end) of all that were taken since clear().
  struct Block {
    size_t begin = 0, end = 0;
  };
  struct Chosen {
    const LightPoint& point;
    float probability;
    float weight;  ///< LocalChoice::Block::weight
  };

  void clear() {
    points_.clear();
    weights_.clear();
  }
  /// Takes a block of the points that `choice` has, but for those that a path which has `edges`
  /// when it meets them would be too long with. `bits`: random.
  Block take(const LocalChoice& choice, uint32_t bits, uint32_t edges);
  /// One point of a block, by about what it sends to y. `rates`: of the tile's choice. nullopt
  /// where none of them sends anything.
  std::optional<Chosen> choose(const SurfaceInteraction& y, Block block,
                               std::span<const float> rates, float u);
  /// Odds for a path from the eye to find the point as its third, against points that are looked
  /// at: to be multiplied by the density of places there.
  float third_odds(const LightPoint& point, std::span<const float> rates) const {
    return light_.local->third_ratio(point.cell) / rates[point.cell];
  }

 private:
  const CellLight& light_;
  std::vector<uint32_t> points_;  ///< in the pass's local points
  std::vector<float> weights_;    ///< of the same points
  std::vector<float> sums_;       ///< running, of what the points of a block send, or about that
};

}  // namespace kinome
