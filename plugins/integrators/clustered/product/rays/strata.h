#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/cell_kernels.h"

namespace kinome {

/// Strata of a unit, laid end to end on a line for a comb. Stores the weight of each stratum, which
/// is the uncertainty of its light, and the sums of each simd::kCellLanes weights. Strata of one
/// kind and group form a segment. Reuses its memory; one object per thread.
class Strata {
 public:
  enum class Kind : uint8_t {
    kDiffuse,  ///< cells of distant light, which contain many directions
    kGlossy,   ///< candidates, which are single directions
    kLocal     ///< candidates toward light points and lamps
  };
  struct Segment {
    Kind kind = Kind::kDiffuse;
    uint32_t group = 0;
    size_t begin = 0;  ///< index of the first stratum
    size_t size = 0;   ///< padded to simd::kCellLanes
    size_t first = 0;  ///< first index in the data of the stage that appended the segment
  };
  /// Columns of one segment: `size` weights, and the size / simd::kCellLanes sums of them.
  struct Columns {
    float* weights;
    float* block_sums;
  };

  void clear() {
    segments_.clear();
    weights_.clear();
    block_sums_.clear();
  }
  /// Appends a segment. Its weights and sums must be set before the next one is appended.
  Columns append(Kind kind, uint32_t group, size_t size, size_t first) {
    segments_.push_back({kind, group, weights_.size(), size, first});
    const Segment& segment = segments_.back();
    weights_.resize(segment.begin + size);
    block_sums_.resize(weights_.size() / simd::kCellLanes);
    return columns(segment);
  }

  std::span<const Segment> segments() const { return segments_; }
  Columns columns(const Segment& segment) {
    return {weights_.data() + segment.begin, block_sums_.data() + segment.begin / simd::kCellLanes};
  }
  /// Sum of all weights.
  double total() const {
    double total = 0;
    for (const float sum : block_sums_) total += sum;
    return total;
  }

 private:
  std::vector<Segment> segments_;
  std::vector<float> weights_;
  std::vector<float> block_sums_;
};

}  // namespace kinome
