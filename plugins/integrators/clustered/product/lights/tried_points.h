#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/aligned.h"
#include "clustered/kernels/importance_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/lights/local_light.h"

namespace kinome {

/// Size of the blocks in which a tile uses its points, and the minimum number of these blocks.
inline constexpr uint32_t kPointBlockSize = 32, kMinPointBlocks = 16;

/// Light points of a pass that a tile considers, and the expected number of times that it takes
/// each. This number is in proportion to the light that the tile's patches reflect from the point,
/// as estimated; a part depends only on the rate of the point's cell. The expected number of takes
/// times the weight is the same for all points of the pass, whatever was estimated. Reuses its
/// memory; one object per thread.
class TriedPoints {
 public:
  /// Begins with the points of a pass, which must outlive the choice.
  void begin(const LocalPoints& points);
  /// Considers a point of a cell. `probability` is that of considering the point. `rate` is the
  /// expected number of takes by the cell alone. `eye_weight` is a factor of the point's eye ratio.
  void add(uint32_t point, uint32_t cell, double probability, double rate, float eye_weight);
  /// Reads the points. Call it after all add().
  void gather();
  /// Adds the light that one of the tile's patches reflects from each point. `size2` is the patch's
  /// squared extent, and `visibility` is of each cell.
  void add_patch(const simd::ReflectingPatch& patch, float size2, const float* visibility);

  struct Take {
    uint32_t point, cell;
    float weight;  ///< 1 / expected number of takes
  };
  /// Takes points in the order of add(), each at most `max_takes` times on average. `offset` is a
  /// random number in [0, 1).
  void take(double max_takes, double offset, std::vector<Take>& out) const;

  bool empty() const { return points_.empty(); }

 private:
  void gather_lobes();
  void multiply_by_lobes(const simd::ReflectingPatch& patch, float size2);

  const LocalPoints* of_pass_ = nullptr;
  std::vector<uint32_t> points_, cells_;
  std::vector<float> inverse_probabilities_, eye_weights_;
  std::vector<double> rates_;
  std::vector<uint32_t> glossy_;  ///< indices of the points that have a Reflection
  Column<float> columns_[simd::kLightPointNumbers];
  /// Position and SentLobe of each point of glossy_.
  static constexpr size_t kLobeNumbers = sizeof(simd::SentLobe) / sizeof(float);
  std::vector<float> lobe_columns_[3 + kLobeNumbers];
  std::vector<float> lobe_scales_;  ///< incident light over power
  std::vector<float> lobe_fractions_;
  std::vector<float> power_;       ///< mean over channels
  std::vector<float> of_patch_;    ///< importance for the last patch
  std::vector<float> importance_;  ///< sum over all patches
};

}  // namespace kinome
