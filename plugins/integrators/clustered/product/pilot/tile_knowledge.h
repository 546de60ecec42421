#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/product_sampling.h"
#include "clustered/product/pilot/shared_knowledge.h"
#include "clustered/product/pilot/stored_patch.h"
#include "clustered/product/tiles/sigma_check.h"
#include "clustered/product/tiles/tile_grid.h"

namespace kinome {

/// Learned data of each tile of an image: its patches, the results of the pilot's rays, and the
/// learned visibility of each cell. A patch also learns from the tiles around, where their surfaces
/// continue it. Non-const functions for one tile may run at once for different tiles, and const
/// functions for any tile.
class TileKnowledge {
 public:
  /// Distance of the tiles around from which a tile learns, in tiles.
  static constexpr int kReach = 2;

  /// All arguments must outlive it.
  TileKnowledge(const TileGrid& grid, const DistantCells& cells, const LocalLight* local,
                const ProductSettings& settings);
  ~TileKnowledge();

  /// Length of arrays of all cells: those of distant light, then those of local light.
  size_t padded_cells() const { return padded_cells_; }
  /// Sets `out` to the patches of a tile.
  void patches(int tile, std::vector<Patch>& out) const;
  /// Returns the material of the patch with the most points; nullptr if there are no patches.
  const Bsdf* main_bsdf(int tile) const;
  /// Discards all data of all tiles.
  void forget();

  /// Stores the patches of a tile, and the records of the pilot's rays for each patch. Sets
  /// Patch::records_end.
  void keep(int tile, std::span<Patch> patches,
            std::span<const std::vector<VisibilityRecord>> found);
  /// Learns the visibility of each patch of the tile from the stored records, and calls fn(index of
  /// the patch, its visibility). `patches` are those of the tile. Also sets their trust and mean
  /// visibilities, and stores these.
  template <class Function>
  void learn(int tile, std::span<Patch> patches, VisibilityLearner& learner, Visibility& scratch,
             const Function& fn) {
    check_sigma(tile, learner, scratch);
    if (remembers()) learned_[tile].assign(patches.size() * 2 * padded_cells_, 0);
    for (size_t p = 0; p < patches.size(); ++p) {
      learn_patch(tile, p, patches[p], learner, scratch);
      fn(p, scratch);
    }
  }

  /// Transfers the stored records of a tile and its patches.
  void transfer_kept(int tile, SharedBytes& bytes, BsdfAddresses& addresses);
  /// Transfers the learned data of a tile, except visibilities. If another process has learned
  /// them, recall() learns them again, which takes less time than the transfer.
  void transfer_learned(int tile, SharedBytes& bytes);

  /// Finishes learning, after all processes of a group have learned all tiles. Only results of
  /// recall() are corrected by the check: the plan and Patch::trust were computed before.
  void finish(ProcessGroup* group) {
    if (!checks_sigma()) return;
    sigma_check_.sum_over_processes(group);
    sigma_check_.finish();
  }

  /// Sets `out` to the visibility of patch `index` of a tile, with sigma corrected by the check.
  /// For a patch of the pilot, this is the result of learn() in 8 bits. Learns the visibility of a
  /// patch that a later pass added.
  void recall(int tile, size_t index, Patch& patch, VisibilityLearner& learner,
              Visibility& out) const;
  /// Applies Patch::trust and the settings to the visibility.
  void restrict(const Patch& patch, Visibility& visibility) const;

 private:
  /// Patches and records in one piece of memory, because there are millions of tiles.
  class Tile {
   public:
    Tile() = default;
    /// Records are patch by patch; there are patches.back().records_end.
    Tile(std::span<const Patch> patches, std::span<const VisibilityRecord> records,
         SharedOfPatches& shared);
    std::span<const StoredPatch> patches() const { return {data(), count_}; }
    std::span<StoredPatch> patches() { return {data(), count_}; }
    std::span<const VisibilityRecord> records() const {
      return {reinterpret_cast<const VisibilityRecord*>(data() + count_),
              count_ > 0 ? data()[count_ - 1].records_end : 0};
    }
    std::span<const VisibilityRecord> records_of(size_t patch) const {
      const uint32_t first = patch > 0 ? data()[patch - 1].records_end : 0;
      return records().subspan(first, data()[patch].records_end - first);
    }

   private:
    static_assert(std::is_trivially_copyable_v<StoredPatch> &&
                  std::is_trivially_copyable_v<VisibilityRecord>);
    StoredPatch* data() const { return reinterpret_cast<StoredPatch*>(bytes_.get()); }
    std::unique_ptr<std::byte[]> bytes_;
    uint32_t count_ = 0;
  };

  bool remembers() const { return grid_.crop().area() <= settings_.remembered_pixels; }
  bool checks_sigma() const { return settings_.checked_sigma && settings_.learned_sigma; }
  void check_sigma(int tile, VisibilityLearner& learner, Visibility& scratch);
  void learn_patch(int tile, size_t index, Patch& patch, VisibilityLearner& learner,
                   Visibility& out);
  enum class Own { kTaken, kLeftOut };
  void learn_from_around(int tile, const Patch& patch, VisibilityLearner& learner,
                         Visibility& out, Own own = Own::kTaken) const;
  void find_trust(std::span<const VisibilityRecord> own, Patch& patch,
                  const Visibility& visibility) const;

  const TileGrid& grid_;
  const DistantCells& cells_;
  const ProductSettings& settings_;
  size_t padded_cells_;
  uint32_t first_lamp_, end_lamps_;  ///< range of the cells of lamps
  bool has_local_;
  SharedOfPatches shared_;
  std::vector<Tile> tiles_;
  /// For each tile and patch: v of each cell in 8 bits, then the root of each sigma. A tile's is
  /// empty if another process learned it. Has no tiles if the image is so large that each pass
  /// learns them again.
  std::vector<std::vector<uint8_t>> learned_;
  SigmaCheck sigma_check_;
};

}  // namespace kinome
