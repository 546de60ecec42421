#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clustered/kernels/cell_kernels.h"

namespace kinome {

/// The strata of a unit, laid end to end on one line for a comb to walk along: of each the weight,
/// which is how uncertain its light is, and sums of each simd::kCellLanes of them. Those of one
/// kind and group are one segment. Keeps its memory: one per thread.
class Strata {
 public:
  enum class Kind : uint8_t {
    kDiffuse,  ///< cells of distant light, each of many directions
    kGlossy,   ///< candidates, which are one direction each
    kLocal     ///< candidates toward light points and lamps
  };
  struct Segment {
    Kind kind = Kind::kDiffuse;
    uint32_t group = 0;
    size_t begin = 0;  ///< its first stratum's number
    size_t size = 0;   ///< padded to simd::kCellLanes
    size_t first = 0;  ///< where what the stage that appended it keeps of it begins there
  };
  /// Of one segment: size weights, and size / simd::kCellLanes sums of them.
  struct Columns {
    float* weights;
    float* block_sums;
  };

  void clear() {
    segments_.clear();
    weights_.clear();
    block_sums_.clear();
  }
  /// Appends a segment, whose weights and sums are to be filled before the next is appended.
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
