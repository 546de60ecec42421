#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/product/candidates.h"
#include "clustered/product/cell_importance.h"
#include "clustered/product/groups.h"
#include "clustered/product/point_nodes.h"

namespace kinome {

/// Candidates of distant light that pixels of a tile share, where their points reflect nearly
/// alike: drawn and looked up once for a node of points, by the lobe of its mean point, and
/// evaluated by each pixel for its own points.
///
/// They are dealt into blocks, each of which is a set of candidates by itself, and whose
/// expectations are the same. A pixel takes some of them, the first one being random, and estimates
/// with a block's densities: that is unbiased, however far its points are from the mean one. All
/// blocks together know better than the few of a pixel what the *mean* point reflects: how much the
/// pixel's blocks say of that, less what the average block says, has expectation 0, and is the
/// pixel's control variate.
///
/// One per thread; not thread-safe. `light` must outlive it.
class SharedCandidates {
 public:
  explicit SharedCandidates(const CellLight& light);

  /// What the units of a tile may share, which are to be estimated. All must stay as they are until
  /// the next call.
  void begin_tile(const TilePrimaries& primaries, std::span<const Patch> patches,
                  std::span<const Visibility> visibility, std::span<const Unit> units,
                  uint64_t seed);

  /// Nothing is shared.
  void clear();

  /// The candidates of one node.
  struct Set {
    bool is_shared = false;
    bool is_drawn = false;
    uint32_t blocks = 0;
    uint32_t from_lobe = 0, from_cells = 0;  ///< in each block
    size_t size = 0;   ///< of a block in the columns: both, padded
    size_t first = 0;  ///< of the columns
    float share = 1;   ///< of the candidates that it wants, a pixel takes these
    Rgb mean{0.f};     ///< over the blocks: known light that the mean point reflects of one
  };
  /// The set of the group's points, drawn; nullptr: they share none.
  const Set* find(const GroupView& group);
  /// How many blocks a group takes that wants so many candidates.
  static uint32_t blocks_for(const Set& set, float wanted);
  /// How much of its set's control variate a group takes: all of its reflectance at the mean point,
  /// less the farther it is from that.
  Rgb variate(const GroupView& group) const;
  /// The candidates of block `block` of a set.
  Directions directions(const Set& set, uint32_t block) const;
  const uint32_t* cells(const Set& set, uint32_t block) const {
    return &candidates_.cell[set.first + block * set.size];
  }
  simd::SharedValues values(const Set& set, uint32_t block) const;

 private:
  const PointNode& node_of(const GroupView& group) const {
    return nodes_.nodes()[nodes_.of(group.primary(0))];
  }
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
