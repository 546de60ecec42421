#pragma once

#include <array>
#include <deque>
#include <unordered_map>
#include <vector>

#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/tile_grid.h"
#include "kinome/scene.h"
#include "kinome/shared_items.h"

/// Transfer of patches between the processes of a group. Each function writes to `bytes`, or reads
/// from them if bytes.reads().
namespace kinome {

/// Transfers pointers to BSDFs and to their transmittance tables, whose addresses differ between
/// processes. A BSDF is transferred as its index among the BSDFs of the scene's shapes, a table as
/// its contents. Must outlive the patches that were read, because it owns their tables.
class BsdfAddresses {
 public:
  explicit BsdfAddresses(const Scene& scene);
  void transfer(const Bsdf*& bsdf, SharedBytes& bytes) const;
  /// Transfers a table BsdfForm::transmittance, or nullptr.
  void transfer(const float*& table, SharedBytes& bytes);

 private:
  using Table = std::array<float, BsdfForm::kTableSize>;
  std::vector<const Bsdf*> all_;
  std::unordered_map<const Bsdf*, uint32_t> number_;  ///< index in all_
  std::deque<Table> tables_;  ///< distinct tables read from other processes; there are only a few
};

/// Transfers a whole patch.
void transfer(Patch& patch, SharedBytes& bytes, BsdfAddresses& addresses);
/// Transfers only the members that learning sets and passes use: visibilities and trust.
void transfer_learned(Patch& patch, SharedBytes& bytes);

}  // namespace kinome
