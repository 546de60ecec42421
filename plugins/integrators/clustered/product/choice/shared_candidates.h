#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/choice/candidates.h"
#include "clustered/product/choice/cell_importance.h"
#include "clustered/product/tiles/groups.h"
#include "clustered/product/choice/point_nodes.h"

namespace kinome {

/// Candidates of distant light that pixels of a tile share if their points reflect nearly alike.
/// They are drawn and their light is looked up once per node of points, by the lobe of its mean
/// point. Each pixel evaluates them for its own points.
///
/// The candidates are divided into blocks. Each block is a complete set of candidates, and all
/// blocks have the same expectation. A pixel takes some of the blocks, beginning with a random one,
/// and uses a block's densities. This is unbiased, however far the pixel's points are from the mean
/// point.
///
/// A pixel's control variate is the light that the *mean* point reflects by the pixel's blocks,
/// minus the average over all blocks. Its expectation is 0. It reduces noise, because all blocks
/// together are more precise than those of a pixel.
///
/// One per thread; not thread-safe. `light` must outlive it.
class SharedCandidates {
 public:
  explicit SharedCandidates(const CellLight& light);

  /// Begins a tile with the units that may share candidates, or none. All arguments must stay
  /// unchanged until the next call.
  void begin_tile(const TilePrimaries& primaries, std::span<const Patch> patches,
                  std::span<const Visibility> visibility, std::span<const Unit> units,
                  uint64_t seed);

  /// The candidates of one node.
  struct Set {
    bool is_shared = false;
    bool is_drawn = false;
    uint32_t blocks = 0;
    uint32_t from_lobe = 0, from_cells = 0;  ///< number in each block
    size_t size = 0;   ///< of a block in the columns: candidates of both kinds, padded
    size_t first = 0;  ///< index of the first candidate in the columns
    float share = 1;   ///< a pixel takes this fraction of the candidates that it wants
    Rgb mean{0.f};     ///< mean over blocks of the known light that the mean point reflects
  };
  /// Returns the set of the group's points, and draws it at the first call. nullptr if they share
  /// none.
  const Set* find(const GroupView& group);
  /// Number of blocks for a group that wants this number of candidates.
  static uint32_t blocks_for(const Set& set, float wanted);
  /// Weight of the set's control variate for a group: the number of points, scaled by their
  /// reflectance relative to that of the patch's form. Decreases with the distance from the mean
  /// point.
  Rgb variate(const GroupView& group) const;
  /// The candidates of block `block` of a set.
  Directions directions(const Set& set, uint32_t block) const {
    return candidates_.directions(set.first + block * set.size);
  }
  const uint32_t* cells(const Set& set, uint32_t block) const {
    return &candidates_.cell[set.first + block * set.size];
  }
  simd::SharedValues values(const Set& set, uint32_t block) const;

 private:
  bool may_share(const PointNode& node) const;
  void choose_counts(const PointNode& node, Set& set) const;
  void draw(const PointNode& node, Set& set, uint64_t seed);
  void draw_from_lobe(const PointNode& node, const Set& set, uint64_t seed);
  void draw_from_cells(const PointNode& node, const Set& set, float offset);
  void evaluate(const PointNode& node, Set& set);
  simd::HalfVectorLobe lobe_of(const PointNode& node) const;

  const CellLight& light_;
  CellImportance importance_;
  PointNodes nodes_;
  std::vector<Set> sets_;  ///< of each node
  std::span<const Patch> patches_;
  std::span<const Visibility> visibility_;
  uint64_t seed_ = 0;
  DistantCandidates candidates_;  ///< of all sets
  std::vector<float> ratio_[3], known_[3], v_, sigma_;  ///< see simd::SharedValues
  simd::PointFrames mean_point_;
  std::vector<uint32_t> mean_member_, mean_id_{0};
  Column<uint32_t> numbers_[2];
};

}  // namespace kinome
