#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "clustered/kernels/importance_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/local_light.h"

namespace kinome {

/// Light points of a pass that a tile considers, and how often it takes each: in proportion to the
/// light that the tile's patches reflect of it, estimated, and a part in proportion to its cell's
/// rate alone. The expected number of takes times the weight is the same for all points of the pass,
/// whatever was estimated. Keeps its memory: one per thread.
class TriedPoints {
 public:
  /// The points of a pass; they must outlive the choice.
  void begin(const LocalPoints& points);
  /// Considers a point of a cell. `probability`: that of being considered; `rate`: expected number
  /// of takes by the cell alone; `eye_weight`: factor of the point's eye ratio.
  void add(uint32_t point, uint32_t cell, double probability, double rate, float eye_weight);
  /// After all add(): reads the points.
  void gather();
  /// Adds what one of the tile's patches reflects of each point. size2: its squared extent;
  /// visibility: of each cell.
  void add_patch(const simd::ReflectingPatch& patch, float size2, const float* visibility);

  struct Take {
    uint32_t point, cell;
    float weight;  ///< 1 / expected number of takes
  };
  /// Takes points, in the order of add(); a point at most `most` times on average. offset: random.
  void take(double most, double offset, std::vector<Take>& out) const;

  bool empty() const { return points_.empty(); }

 private:
  void gather_lobes();
  void multiply_by_lobes(const simd::ReflectingPatch& patch, float size2);

  const LocalPoints* of_pass_ = nullptr;
  std::vector<uint32_t> points_, cells_;
  std::vector<float> inverse_probabilities_, eye_weights_;
  std::vector<double> rates_;
  std::vector<uint32_t> glossy_;  ///< those that have a Reflection
  Column<float> columns_[simd::kLightPointNumbers];
  /// Position and SentLobe of each point of glossy_.
  static constexpr size_t kLobeNumbers = sizeof(simd::SentLobe) / sizeof(float);
  std::vector<float> lobe_columns_[3 + kLobeNumbers];
  std::vector<float> lobe_scales_;  ///< incident light over power
  std::vector<float> lobe_fractions_;
  std::vector<float> power_;       ///< mean of the channels
  std::vector<float> of_patch_;    ///< importance to the last patch
  std::vector<float> importance_;  ///< sum over patches
};

}  // namespace kinome
