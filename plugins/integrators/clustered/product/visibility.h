#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/cell_kernels.h"

namespace kinome {

/// What one shadow ray found: the cell that it went to, and whether its light was visible.
class VisibilityRecord {
 public:
  VisibilityRecord() = default;
  VisibilityRecord(uint32_t cell, bool visible)
      : bits_(static_cast<uint16_t>(cell | (visible ? 0x8000u : 0u))) {}
  uint32_t cell() const { return bits_ & 0x7fffu; }
  bool visible() const { return bits_ & 0x8000u; }

 private:
  uint16_t bits_ = 0;
};

/// Visibility of each cell at a patch of surface, with what is left uncertain; arrays padded.
struct Visibility {
  std::vector<float> v;            ///< in [0, 1]: what control terms count on
  std::vector<float> sigma;        ///< root mean square of V - v
  std::vector<float> sigma_mixed;  ///< root mean square of V: where v is taken as 0
  void resize(size_t padded);
  /// Nothing known: v = 0.
  void reset();
  simd::CellKnowledge knowledge() const { return {v.data(), sigma.data(), sigma_mixed.data()}; }
};

/// Cells around each cell, the nearest ones by their mean directions, nearest first.
struct CellNeighbours {
  static constexpr size_t kCount = 8;
  std::vector<std::array<uint16_t, kCount>> of;  ///< cells.size(), a padding one: there is none
};
CellNeighbours find_neighbours(const DistantCells& cells, const RenderContext& context);

/// Turns records of rays nearby into visibilities: the share of visible ones, a cell with few
/// records leaning on its neighbours, and these on what is around them along the cells' curve
/// (shrinkage up a tree of fan-out 8).
class VisibilityLearner {
 public:
  /// Without `neighbours`, cells lean on the tree alone; else they must outlive the learner.
  explicit VisibilityLearner(size_t padded_cells, const CellNeighbours* neighbours = nullptr);
  void begin();
  /// Each record counts `weight` / 16.
  void add(std::span<const VisibilityRecord> records, uint32_t weight);
  /// Without any record: nothing is known.
  void finish(Visibility& out);

 private:
  struct Count {
    uint32_t all = 0;
    uint32_t visible = 0;
  };
  struct Node {
    float all = 0;
    float visible = 0;
  };
  float prior(size_t cell) const;
  const CellNeighbours* neighbours_;
  std::vector<Count> counts_;
  std::vector<std::vector<Node>> levels_;  ///< sums of 8; the last one is the root alone
};

}  // namespace kinome
