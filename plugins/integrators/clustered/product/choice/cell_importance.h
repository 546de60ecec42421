#pragma once

#include <span>
#include <vector>

#include "clustered/product/choice/cell_light.h"
#include "clustered/product/rays/comb.h"

namespace kinome {

/// Importance of each cell of distant light for a glossy lobe, from which candidates are drawn.
/// Reuses its memory; one per thread. `light` must outlive it.
class CellImportance {
 public:
  explicit CellImportance(const CellLight& light);

  /// Lobe of a group of points.
  struct Lobe {
    Vec3 normal, viewer;  ///< unit means; `viewer` points toward the viewer
    float cosine;         ///< of the cone around `normal` that contains all normals
    float alpha2;         ///< squared roughness
  };
  void find(const Lobe& lobe);

  /// Total importance for the lobe of the last find(); 0 if it reflects no cell.
  float total() const { return total_; }
  float inverse_total() const { return total_ > 0 ? 1 / total_ : 0.f; }
  /// Importance of each cell.
  const float* values() const { return values_.data(); }
  /// Draws about `count` cells, in order, with a comb whose random number is `offset`. Prefetches
  /// their points. The result is valid until the next call.
  std::span<const Comb::Hit> draw(uint32_t count, float offset);

 private:
  const CellLight& light_;
  std::vector<float> values_, block_sums_;
  float total_ = 0;
  std::vector<Comb::Hit> hits_;
};

}  // namespace kinome
