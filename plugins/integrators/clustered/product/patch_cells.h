#pragma once

#include <vector>

#include "clustered/product/cell_light.h"
#include "clustered/product/patches.h"

namespace kinome {

/// The cells of distant light as one patch sees them, with what was learned of them.
struct PreparedPatch {
  simd::PatchCells cells;
  std::vector<uint32_t> blocks;  ///< of CellBlocks: those that the patch faces
  Column<float> transmittance;   ///< Patch::transmittance toward each of their cells; empty: 1
};

/// Sorts the cells into those above the patch's horizon, and those that may straddle it. `seed`:
/// which of a cell's points tell the light of the latter. Keeps the memory of `out`.
void prepare_patch(const CellLight& light, const Patch& patch, const Visibility& visibility,
                   PreparedPatch& out, uint64_t seed);

/// The patches of a tile, each prepared when the first unit needs it. Keeps its memory: one per
/// thread. `light` must outlive it.
class PreparedPatches {
 public:
  explicit PreparedPatches(const CellLight& light) : light_(light) {}
  /// Forgets all patches: others come, `count` of them. `seed`: as prepare_patch has it.
  void begin_tile(size_t count, uint64_t seed);
  /// Of patch number `index`, which is always the same one for the tile.
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

/// Normals within a cone around n, as kernels take them.
simd::GroupNormal group_normal(const DistantCells& cells, const Vec3& n, float cone_cosine);

}  // namespace kinome
