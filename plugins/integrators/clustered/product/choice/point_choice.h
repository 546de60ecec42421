#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "clustered/product/choice/cell_light.h"
#include "clustered/product/choice/local_choice.h"

namespace kinome {

/// Selects a light point from a block, to connect it to a surface point of a path from the eye. One
/// object per thread; not thread-safe. `light` must have local light and outlive it.
class PointChoice {
 public:
  explicit PointChoice(const CellLight& light) : light_(light) {}

  /// Light points of a tile: [begin, end) of all points taken since clear(). `begin` is a multiple
  /// of kBlockLanes.
  struct Block {
    size_t begin = 0, end = 0;
  };
  struct Chosen {
    const LightPoint& point;
    float probability;
    float weight;  ///< LocalChoice::Block::weight
  };

  void clear() { points_.clear(); }
  /// Takes a block of the points of `choice`, selected by the random number `bits`. Skips points
  /// that would make a path too long: those whose edges and `edges` exceed the maximum depth.
  Block take(const LocalChoice& choice, uint32_t bits, uint32_t edges);
  /// Chooses one point of a block, with a probability roughly in proportion to the light that it
  /// sends to y. Returns nullopt if no point sends light there.
  std::optional<Chosen> choose(const SurfaceInteraction& y, Block block, float u);
  /// Ratio of two probabilities of finding the point's light: by paths from the eye, as their third
  /// surface point, and by light points. Must be multiplied by the density of such paths at the
  /// point.
  float third_odds(const LightPoint& point, std::span<const float> rates) const {
    return light_.local->third_ratio(point.cell) / rates[point.cell];
  }

 private:
  /// Columns of the points that choose() reads.
  enum Number { kPosition, kNormal = 3, kGeometric = 6, kPower = 9, kOdds, kWeight, kNumbers };

  const CellLight& light_;
  std::vector<uint32_t> points_;  ///< indices into the local points of the pass, padded
  Column<float> columns_[kNumbers];
  Column<float> chances_;  ///< unnormalised probabilities of the points of one block
};

}  // namespace kinome
