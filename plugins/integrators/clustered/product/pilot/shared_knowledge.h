#pragma once

#include <array>
#include <deque>
#include <unordered_map>
#include <vector>

#include "clustered/product/tiles/patches.h"
#include "clustered/product/tiles/tile_grid.h"
#include "kinome/scene.h"
#include "kinome/shared_items.h"

/// Transfer of tiles between the processes of a group.
namespace kinome {

/// Converts pointers to BSDFs and their tables for other processes, where addresses differ. The
/// BSDF of a shape is transferred as a number, and a table as its contents. Must outlive the
/// transferred data.
class BsdfAddresses {
 public:
  explicit BsdfAddresses(const Scene& scene);
  void transfer(const Bsdf*& bsdf, SharedBytes& bytes) const;
  /// Transfers a BsdfForm::transmittance.
  void transfer(const float*& table, SharedBytes& bytes);

 private:
  using Table = std::array<float, BsdfForm::kTableSize>;
  std::vector<const Bsdf*> all_;
  std::unordered_map<const Bsdf*, uint32_t> number_;
  std::deque<Table> tables_;  ///< distinct tables from other processes: a few
};

/// Transfers a whole patch.
void transfer(Patch& patch, SharedBytes& bytes, BsdfAddresses& addresses);
/// Transfers the results of the plan.
void transfer_plan(Patch& patch, SharedBytes& bytes);

}  // namespace kinome
