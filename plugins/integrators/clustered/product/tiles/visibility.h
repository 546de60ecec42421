#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/aligned.h"
#include "clustered/kernels/cell_kernels.h"
#include "kinome/wide/numbers.h"

namespace kinome {

/// Result of a shadow ray: its cell and the fraction of the light that arrives. Panes and masks may
/// weaken the light. Uses three bytes, because a pilot keeps many records.
class VisibilityRecord {
 public:
  /// share() if all light arrives.
  static constexpr uint32_t kWhole = 255;

  VisibilityRecord() = default;
  /// `share` in [0, 1].
  VisibilityRecord(uint32_t cell, float share)
      : cell_{static_cast<uint8_t>(cell), static_cast<uint8_t>(cell >> 8)},
        share_(static_cast<uint8_t>(share * kWhole + 0.5f)) {}
  uint32_t cell() const { return cell_[0] | static_cast<uint32_t>(cell_[1]) << 8; }
  bool visible() const { return share_ > 0; }
  /// In units of 1 / kWhole.
  uint32_t share() const { return share_; }
  float value() const { return static_cast<float>(share_) / kWhole; }

 private:
  uint8_t cell_[2] = {};
  uint8_t share_ = 0;
};

/// Learned visibility of each cell from a patch, and its uncertainty. Arrays are padded.
struct Visibility {
  Column<float> v;            ///< in [0, 1]; used by control terms
  Column<float> sigma;        ///< root mean square of V - v
  Column<float> sigma_mixed;  ///< root mean square of V; used if v is taken as 0
  explicit Visibility(size_t padded = 0)
      : v(padded, 0.f), sigma(padded, 1.f), sigma_mixed(padded, 1.f) {}
  /// Sets v = 0 and sigma = 1, as the constructor does: nothing was learned.
  void reset();
  simd::CellKnowledge knowledge() const { return {v.data(), sigma.data(), sigma_mixed.data()}; }
};

/// The nearest cells of each cell by their mean directions, nearest first.
struct CellNeighbours {
  static constexpr size_t kCount = 8;
  /// of[i][c] is the i-th neighbour of cell c, padded. It is cells.size(), a padding cell, if there
  /// is none.
  std::array<Column<int32_t>, kCount> of;
};
CellNeighbours find_neighbours(const DistantCells& cells, const Scheduler& scheduler);

/// Learns visibilities from records of nearby rays, as the mean fraction of light that arrives. The
/// value of a cell with few records is pulled toward that of its neighbours. Their value is pulled
/// toward that of larger parts of the cells' curve (shrinkage up a tree of fan-out 8).
class VisibilityLearner {
 public:
  /// Maximum weight of all records together, in 1/16 of a record: 4,095 whole records.
  static constexpr int32_t kMaxWeight = 0xffff;

  /// Without `neighbours`, values are pulled toward those of the tree alone. `neighbours` must
  /// outlive the learner.
  explicit VisibilityLearner(size_t padded_cells, const CellNeighbours* neighbours = nullptr);
  void begin();
  /// Adds records of weight `weight` / 16 each. Ignores records that would exceed kMaxWeight.
  void add(std::span<const VisibilityRecord> records, uint32_t weight);
  /// Computes the visibility of all cells. Resets `out` if there are no records.
  void finish(Visibility& out);
  /// Computes only the cells that a patch with these normals may face (CellBlocks::find_facing),
  /// and all cells behind `blocks`. Sets the others to Visibility::reset().
  void finish(const CellBlocks& blocks, const Vec3& normal, float sine, Visibility& out);

 private:
  /// Weights of the records of a cell or node, in units of 1/16. The lower half is the sum of all
  /// weights, the upper half is the sum of weighted shares.
  using Count = uint32_t;
  /// Nodes of one level. Each is the sum of 8 nodes of the level below.
  struct Level {
    std::vector<Count> counts;
    std::vector<float> share;  ///< estimated from the node's records and the nodes above
  };
  void sum_up();
  /// Estimates the shares of all levels, from the root down.
  void estimate_shares();
  wide::Float prior(size_t first) const;
  void finish(std::span<const uint32_t> blocks, Visibility& out);
  const CellNeighbours* neighbours_;
  /// Per cell. Missing neighbours refer to the zeros at the end.
  Column<Count> counts_;
  uint32_t weight_ = 0;                ///< sum over all records
  uint64_t shares_ = 0, squares_ = 0;  ///< weighted sums over all records
  std::vector<Level> levels_;          ///< the last level is the root alone
  std::vector<uint32_t> all_blocks_, facing_;
};

}  // namespace kinome
