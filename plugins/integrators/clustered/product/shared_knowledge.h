#pragma once

#include <array>
#include <deque>
#include <unordered_map>
#include <vector>

#include "clustered/product/patches.h"
#include "clustered/product/tile_grid.h"
#include "kinome/scene.h"
#include "kinome/shared_items.h"

/// What processes of a group tell each other of tiles.
namespace kinome {

/// What BSDFs and their tables are for other processes, where addresses are others: of the BSDFs of
/// a scene's shapes their number, of tables what is in them. Must outlive what it has transferred.
class BsdfAddresses {
 public:
  explicit BsdfAddresses(const Scene& scene);
  void transfer(const Bsdf*& bsdf, SharedBytes& bytes) const;
  /// BsdfForm::transmittance.
  void transfer(const float*& table, SharedBytes& bytes);

 private:
  using Table = std::array<float, BsdfForm::kTableSize>;
  std::vector<const Bsdf*> all_;
  std::unordered_map<const Bsdf*, uint32_t> number_;
  std::deque<Table> tables_;  ///< of other processes: a few
};

/// All of a patch.
void transfer(Patch& patch, SharedBytes& bytes, BsdfAddresses& addresses);
/// What the plan has found of it.
void transfer_plan(Patch& patch, SharedBytes& bytes);

/// The pixels of those tiles of a block that `is_wanted`, in a picture of the grid.
template <class Wanted>
void transfer_tiles(std::vector<Rgb>& picture, const TileGrid& grid, int block,
                    const Wanted& is_wanted, SharedBytes& bytes) {
  grid.for_each_tile(block, [&](const TileGrid::Tile& tile) {
    if (!is_wanted(tile)) return;
    tile.for_each_pixel([&](int x, int y) { bytes.value(picture[grid.pixel(x, y)]); });
  });
}

}  // namespace kinome
