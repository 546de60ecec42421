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

/// Result of a shadow ray: its cell, and the share of the light that arrives, which panes and masks may
/// weaken. Three bytes, because pilots keep many.
class VisibilityRecord {
 public:
  /// share() of unweakened light.
  static constexpr uint32_t kWhole = 255;

  VisibilityRecord() = default;
  VisibilityRecord(uint32_t cell, bool visible) : VisibilityRecord(cell, visible ? 1.f : 0.f) {}
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

/// Visibility of each cell at a patch of surface, with what is left uncertain; arrays padded.
struct Visibility {
  Column<float> v;            ///< in [0, 1]: what control terms count on
  Column<float> sigma;        ///< root mean square of V - v
  Column<float> sigma_mixed;  ///< root mean square of V: where v is taken as 0
  void resize(size_t padded);
  /// Nothing known: v = 0.
  void reset();
  simd::CellKnowledge knowledge() const { return {v.data(), sigma.data(), sigma_mixed.data()}; }
};

/// Cells around each cell, the nearest ones by their mean directions, nearest first.
struct CellNeighbours {
  static constexpr size_t kCount = 8;
  /// of[i][c]: the i-th neighbour of cell c, padded; cells.size(), a padding one: there is none.
  std::array<Column<int32_t>, kCount> of;
};
CellNeighbours find_neighbours(const DistantCells& cells, const RenderContext& context);

/// Turns records of rays nearby into visibilities: the mean share of light that arrives, a cell with
/// few records leaning on its neighbours, and these on what is around them along the cells' curve
/// (shrinkage up a tree of fan-out 8).
class VisibilityLearner {
 public:
  /// The most that all records together may weigh: 4,095 whole ones.
  static constexpr int32_t kMaxWeight = 0xffff;

  /// Without `neighbours`, cells lean on the tree alone; else they must outlive the learner.
  explicit VisibilityLearner(size_t padded_cells, const CellNeighbours* neighbours = nullptr);
  void begin();
  /// Each record counts `weight` / 16. What would exceed kMaxWeight is left out.
  void add(std::span<const VisibilityRecord> records, uint32_t weight);
  /// Without any record: nothing is known.
  void finish(Visibility& out);
  /// Of cells that a patch of such normals (CellBlocks::find_facing) may face alone, those behind
  /// `blocks` included; of others, nothing is known.
  void finish(const CellBlocks& blocks, const Vec3& normal, float sine, Visibility& out);

 private:
  /// Records of a cell or node, in 1/16 of one: all of them in the lower half, the sum of their
  /// shares in the upper one.
  using Count = uint32_t;
  /// Of a level's nodes, each the sum of 8 of the level below.
  struct Level {
    std::vector<Count> counts;
    std::vector<float> share;  ///< what is visible, by what is known of the nodes above
  };
  void sum_up();
  void share_down();
  wide::Float prior(size_t first) const;
  void finish(std::span<const uint32_t> blocks, Visibility& out);
  const CellNeighbours* neighbours_;
  /// Cell by cell; zeros behind them, to which neighbours that there aren't point.
  Column<Count> counts_;
  uint32_t weight_ = 0;              ///< of all records
  uint64_t shares_ = 0, squares_ = 0;  ///< weighted sums over all records
  std::vector<Level> levels_;        ///< the last one is the root alone
  std::vector<uint32_t> all_blocks_, facing_;
};

}  // namespace kinome
