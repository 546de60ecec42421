#pragma once

#include <span>
#include <vector>

#include "clustered/product/local_light.h"
#include "clustered/product/patches.h"
#include "clustered/product/product_sampling.h"
#include "clustered/product/shared_knowledge.h"
#include "clustered/product/sigma_check.h"
#include "clustered/product/tile_grid.h"

namespace kinome {

/// What is known of each tile of a picture between the pilot and the passes: its patches of
/// surface, what the pilot's rays found there, and how visible that makes each cell. A patch learns
/// from the tiles around, too, where surfaces go on as it does. The functions for one tile may be
/// called for different tiles at once, those that are const for any.
class TileKnowledge {
 public:
  /// Tiles this far around a tile tell of its visibility.
  static constexpr int kReach = 2;

  /// All must outlive it.
  TileKnowledge(const TileGrid& grid, const DistantCells& cells, const LocalLight* local,
                const ProductSettings& settings);

  /// Length of arrays of all cells: those of distant light, then those of local light.
  size_t padded_cells() const { return padded_cells_; }
  std::vector<Patch>& patches(int tile) { return tiles_[tile].patches; }
  const std::vector<Patch>& patches(int tile) const { return tiles_[tile].patches; }
  /// Of no tile is anything known any more.
  void forget();

  /// Keeps what rays found, patch by patch.
  void keep(int tile, std::span<const std::vector<VisibilityRecord>> found);
  /// fn(index of the patch, its visibility) for each patch of the tile, learned from what was kept;
  /// also sets what of it is to be trusted.
  template <class Function>
  void learn(int tile, VisibilityLearner& learner, Visibility& scratch, const Function& fn) {
    check_sigma(tile, learner, scratch);
    begin_learning(tile);
    for (size_t p = 0; p < tiles_[tile].patches.size(); ++p) {
      learn_patch(tile, p, learner, scratch);
      fn(p, scratch);
    }
  }

  /// Hands what was kept of a tile, its patches included, to the bytes, or replaces it.
  void transfer_kept(int tile, SharedBytes& bytes, BsdfAddresses& addresses);
  /// The same of what was learned, but for visibilities: recall() learns them anew where another
  /// process has, which takes less than to send them.
  void transfer_learned(int tile, SharedBytes& bytes);

  /// All tiles have been learned, by whatever process of a group. Only what recall() says is
  /// corrected by it: plan and trust were made before.
  void finish() {
    if (checks_sigma()) sigma_check_.finish();
  }
  /// Before that, of a group of processes: what all of them have found of sigma.
  void add_up(RenderContext& context) {
    if (checks_sigma()) sigma_check_.add_up(context);
  }

  /// The same of patch number `index` of a tile, which later passes may have found, in 8 bits: as
  /// learn() did, if it is one of the pilot's, but for sigma, which is what the pilot's rays found
  /// it to be.
  void recall(int tile, size_t index, Patch& patch, VisibilityLearner& learner,
              Visibility& out) const;
  /// Makes of it what estimates may count on.
  void restrict(const Patch& patch, Visibility& visibility) const;

 private:
  /// Of a patch of the pilot, what decides who learns from it: all that patches around look at.
  struct Source {
    const Bsdf* bsdf;
    Vec3 normal, position;
    uint32_t first_record, records;
  };
  struct Tile {
    std::vector<Patch> patches;
    std::vector<Source> sources;  ///< of each patch
    std::vector<VisibilityRecord> records;
    std::span<const VisibilityRecord> records_of(const Source& source) const {
      return std::span(records).subspan(source.first_record, source.records);
    }
    /// Of each patch: v, then the root of sigma, of each cell, in 8 bits. Empty where the picture
    /// is so large that each pass learns them again, or where another process has learned them.
    std::vector<uint8_t> learned;
  };

  bool remembers() const { return grid_.crop().area() <= settings_.remembered_pixels; }
  bool checks_sigma() const { return settings_.checked_sigma && settings_.learned_sigma; }
  void check_sigma(int tile, VisibilityLearner& learner, Visibility& scratch);
  void begin_learning(int tile);
  void restore(int tile, size_t index, Patch& patch, VisibilityLearner& learner,
               Visibility& out) const;
  void learn_patch(int tile, size_t index, VisibilityLearner& learner, Visibility& out);
  enum class Own { kTaken, kLeftOut };
  void learn_from_around(int tile, const Patch& patch, VisibilityLearner& learner,
                         Visibility& out, Own own = Own::kTaken) const;
  void find_trust(std::span<const VisibilityRecord> own, Patch& patch,
                  const Visibility& visibility) const;

  const TileGrid& grid_;
  const DistantCells& cells_;
  const ProductSettings& settings_;
  size_t padded_cells_;
  uint32_t first_lamp_, end_lamps_;  ///< cells of lamps
  bool has_local_;
  std::vector<Tile> tiles_;
  SigmaCheck sigma_check_;
};

}  // namespace kinome
