#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/cell_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/patches.h"
#include "clustered/product/lights/tried_points.h"

namespace kinome {

/// Returns the expected number of eye rays of each primary of the patch; at most 1.
float expected_eye_rays(const Patch& patch, const LocalLight& light);

/// Selects the light points of a pass that a tile connects to. Each cell has a rate: three quarters
/// depend on the light that the tile's patches may get from it, a quarter on its guided flux alone.
/// So no light is left out. Rates depend on cells and on learned visibility, not on the points.
/// Balance weights of eye rays can therefore be computed from them at any point. Within these
/// rates, points are selected in proportion to the light that the patches reflect from each
/// (TriedPoints).
///
/// Reuses its memory; one per thread.
class LocalChoice {
 public:
  /// Size of a block. A tile's points are dealt into blocks in the order of the cells, so that each
  /// block is a sample of all cells. A primary uses one block. An important point may be in several
  /// blocks, or in all.
  static constexpr uint32_t kBlockSize = kPointBlockSize;
  /// Bounds of the number of blocks. It is a power of two, about half the number of primaries.
  static constexpr uint32_t kMinBlocks = kMinPointBlocks, kMaxBlocks = 64;

  /// Selects points and lamps for a tile with this number of primaries. `visibility` has an entry
  /// for each patch, in which local cells start at `first_cell`.
  void choose(const LocalLight& light, const LocalPoints& points, std::span<const Patch> patches,
              std::span<const Visibility> visibility, uint32_t first_cell, size_t primaries,
              uint64_t seed);

  /// A padded block of points, for a primary that uses a random block. Powers are multiplied by
  /// `weight`, eye ratios by 1 / rate of the cell.
  struct Block {
    simd::LightPointColumns columns;
    const uint32_t* cell;
    const uint32_t* point;       ///< index in LocalPoints
    const uint32_t* reflection;  ///< LightPoint::reflection
    const uint8_t* group;        ///< LightPoint::group
    const float* weight;         ///< 1 / expected number of uses of the point; 0 for padding
    uint32_t size = 0;           ///< including padding
    Vec3 geometric(uint32_t i) const {
      const float* const (&normal)[3] = columns.geometric;
      return {normal[0][i], normal[1][i], normal[2][i]};
    }
  };
  Block block(uint32_t index) const;

  struct Lamp {
    const Emitter* emitter;
    uint32_t cell;
    float weight;  ///< 1 / probability that a primary uses the lamp
    uint32_t group;  ///< LocalLight::group_of
  };
  std::span<const Lamp> lamps(uint32_t index) const;

  /// For each cell, the expected number of times that a primary uses one of its points: the mean
  /// over the points that a pass may draw there.
  const std::vector<float>& rates() const { return rates_; }

 private:
  void find_importance(const LocalLight& light, const simd::ReflectingPatch& patch);
  void find_lamp_importance(const LocalLight& light, const simd::ReflectingPatch& patch);
  void find_rates(const LocalLight& light);
  void find_rates(const LocalLight& light, uint32_t begin, uint32_t end, uint32_t size);
  void try_points(const LocalLight& light, const LocalPoints& points, double offset);
  void pick_points(const LocalPoints& points);
  void pick_lamps(const LocalLight& light, double offset);

  std::vector<float> importance_;  ///< for each cell, summed over patches; padded
  std::vector<float> of_patch_, assumed_visibility_;
  std::vector<double> shares_;
  std::vector<float> rates_;
  TriedPoints tried_;
  std::vector<TriedPoints::Take> picks_;
  Column<float> columns_[simd::kLightPointNumbers];
  Column<float> weights_, eye_weights_;
  Column<uint32_t> cells_, points_, reflections_;
  Column<uint8_t> groups_;
  std::vector<uint32_t> block_first_;
  std::vector<Lamp> picked_lamps_, lamps_;
  uint32_t blocks_ = kMinBlocks;
  uint32_t lamp_blocks_ = 1;
  std::vector<uint32_t> lamp_first_;
};

}  // namespace kinome
