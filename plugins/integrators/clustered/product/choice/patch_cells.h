#pragma once

#include <vector>

#include "clustered/product/choice/cell_light.h"
#include "clustered/product/tiles/patches.h"

namespace kinome {

/// Cells of distant light as seen from one patch, with their learned visibility.
struct PreparedPatch {
  simd::PatchCells cells;
  std::vector<uint32_t> blocks;  ///< indices of the CellBlocks that the patch faces
  Column<float> transmittance;   ///< Patch::transmittance toward their cells; empty if it is 1
};

/// Sorts the cells into those above the patch's horizon and those that may straddle it. `seed`
/// selects the points of a cell from which the light of straddling cells is estimated. Reuses the
/// memory of `out`.
void prepare_patch(const CellLight& light, const Patch& patch, const Visibility& visibility,
                   PreparedPatch& out, uint64_t seed);

/// The patches of a tile, each prepared when a unit first needs it. Reuses its memory; one object
/// per thread. `light` must outlive it.
class PreparedPatches {
 public:
  explicit PreparedPatches(const CellLight& light) : light_(light) {}
  /// Discards all patches and expects `count` new ones. `seed`: see prepare_patch.
  void begin_tile(size_t count, uint64_t seed);
  /// Returns patch `index`, and prepares it at the first call. The same index must always mean the
  /// same patch of the tile.
  const PreparedPatch& get(size_t index, const Patch& patch, const Visibility& visibility);

 private:
  struct Entry {
    bool ready = false;
    PreparedPatch prepared;
  };
  const CellLight& light_;
  std::vector<Entry> entries_;
  uint64_t seed_ = 0;
};

/// Returns the normals within a cone around n, in the form that kernels take.
simd::GroupNormal group_normal(const DistantCells& cells, const Vec3& n, float cone_cosine);

}  // namespace kinome
