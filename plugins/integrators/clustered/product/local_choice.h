#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/cell_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/local_light.h"
#include "clustered/product/patches.h"
#include "clustered/product/tried_points.h"

namespace kinome {

/// Light points of a pass that a tile connects to. Rates of cells depend on what the tile's patches
/// may see of them, and a quarter on their guided flux alone, so that no light is left out. Rates
/// depend on cells and on what was learned earlier, not on the points: so balance weights of eye
/// rays can be computed from them anywhere. Within these rates, points are chosen one by one, by
/// the light that the patches reflect of each (TriedPoints).
///
/// Keeps its memory: one per thread.
class LocalChoice {
 public:
  /// A tile's points are dealt, in the order of the cells, into blocks of about kBlockSize: each a
  /// sample of all cells. A primary looks at one of them. A point that matters much may be in
  /// several, or in all.
  static constexpr uint32_t kBlockSize = 32;
  /// There is a block for every other primary or fewer, within these bounds: a power of two.
  static constexpr uint32_t kLeastBlocks = 16, kMostBlocks = 64;

  /// `visibility` of each patch; local cells begin at `first_cell` there. `primaries`: number of
  /// them in the tile.
  void choose(const LocalLight& light, const LocalPoints& points, std::span<const Patch> patches,
              std::span<const Visibility> visibility, uint32_t first_cell, size_t primaries,
              uint64_t seed);

  /// A block of points, padded, for a primary that looks at one block taken at random. Powers are
  /// multiplied by `weight`, eye ratios by 1 / rate of the cell.
  struct Block {
    simd::LightPointColumns columns;
    const uint32_t* cell;
    const uint32_t* point;       ///< in LocalPoints
    const uint32_t* reflection;  ///< LightPoint::reflection
    const float* weight;         ///< 1 / expected number of times that the point is looked at; 0: padding
    uint32_t size = 0;           ///< padded
    Vec3 geometric(uint32_t i) const {
      const float* const (&normal)[3] = columns.geometric;
      return {normal[0][i], normal[1][i], normal[2][i]};
    }
  };
  Block block(uint32_t index) const;

  struct Lamp {
    const Emitter* emitter;
    uint32_t cell;
    float weight;  ///< 1 / probability of being looked at
  };
  std::span<const Lamp> lamps(uint32_t index) const;

  /// Expected number of times that a primary looks at a point of the cell, on average over the
  /// points that a pass may draw there.
  const std::vector<float>& rates() const { return rates_; }

 private:
  void find_importance(const LocalLight& light, const simd::ReflectingPatch& patch);
  void look_at_lamps(const LocalLight& light, const simd::ReflectingPatch& patch);
  void find_rates(const LocalLight& light);
  void find_rates(const LocalLight& light, uint32_t begin, uint32_t end, uint32_t size);
  void try_points(const LocalLight& light, const LocalPoints& points, double offset);
  void pick_points(const LocalPoints& points);
  void pick_lamps(const LocalLight& light, double offset);

  std::vector<float> importance_;  ///< of each cell, summed over patches; padded
  std::vector<float> of_patch_, believed_;
  std::vector<double> shares_;
  std::vector<float> rates_;
  TriedPoints tried_;
  std::vector<TriedPoints::Take> picks_;
  Column<float> columns_[simd::kLightPointNumbers];
  Column<float> weights_, eye_weights_;
  Column<uint32_t> cells_, points_, reflections_;
  std::vector<uint32_t> block_first_;
  std::vector<Lamp> picked_lamps_, lamps_;
  uint32_t blocks_ = kLeastBlocks;
  uint32_t lamp_blocks_ = 1;
  std::vector<uint32_t> lamp_first_;
};

}  // namespace kinome
