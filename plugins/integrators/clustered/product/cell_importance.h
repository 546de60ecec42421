#pragma once

#include <span>
#include <vector>

#include "clustered/product/cell_light.h"
#include "clustered/product/comb.h"

namespace kinome {

/// Cells of distant light by what a glossy lobe may show of them: what candidates are drawn by.
/// Keeps its memory: one per thread. `light` must outlive it.
class CellImportance {
 public:
  explicit CellImportance(const CellLight& light);

  /// The points that are lit: unit mean normal and direction toward the viewer, the cosine of a
  /// cone around `normal` that holds all normals, and the lobe's squared roughness.
  struct Lobe {
    Vec3 normal, viewer;
    float cosine;
    float alpha2;
  };
  void find(const Lobe& lobe);

  /// Of the lobe that was found last. 0: it shows no cell.
  float total() const { return total_; }
  float inverse_total() const { return total_ > 0 ? 1 / total_ : 0.f; }
  /// Of each cell.
  const float* values() const { return values_.data(); }
  /// About `count` cells by a comb whose random number is `offset`, in their order; valid until the
  /// next call. Their points are on their way to the cache.
  std::span<const Comb::Hit> draw(uint32_t count, float offset);

 private:
  const CellLight& light_;
  std::vector<float> values_, block_sums_;
  float total_ = 0;
  std::vector<Comb::Hit> hits_;
};

}  // namespace kinome
