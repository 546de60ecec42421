#pragma once

#include <algorithm>
#include <cstddef>

#include "kinome/wide/vectors.h"
#include "transport/blocks/arena.h"

namespace kinome {

/// Weights of sources, for drawing one of them. Stores the sum of each SIMD lane, so that a draw
/// searches only the sources of one lane. Not thread-safe: use one per thread.
class WeightedSources {
 public:
  /// Allocates memory for arena.capacity() sources. Weights that were never set are 0.
  explicit WeightedSources(transport::Arena& arena)
      : weight_(arena.floats()), sums_(arena.floats()) {}

  void clear() { end_ = 0, total_ = 0; }
  /// Sets the weights of sources first ... first + count - 1; `first` must be a multiple of the
  /// block size. weight_of(i) returns a vector of the weights from i on, which must be 0 in the
  /// padding. Call it in ascending order after clear(). Sources in between get the weight 0.
  template <class Function>
  void add(size_t first, size_t count, const Function& weight_of) {
    using namespace wide;
    Float sum(0.f);
    if (end_ > 0) sum = Float::load(sums_);
    for (; end_ < first; end_ += kLanes) Float(0.f).store(weight_ + end_);
    for_lanes(count, [&](size_t i) {
      const Float weight = weight_of(first + i);
      weight.store(weight_ + first + i);
      sum = sum + weight;
      end_ = first + i + kLanes;
    });
    sum.store(sums_);
    total_ = wide::sum(sum);
  }
  float total() const { return total_; }
  float operator[](size_t i) const { return weight_[i]; }
  const float* weights() const { return weight_; }

  /// Returns the source at `position`, in [0, total()), if the weights are placed end to end, lane
  /// by lane. Some weight must be positive.
  size_t at(float position) const {
    using namespace wide;
    size_t lane = 0, last = 0;
    for (; lane < kLanes && position >= sums_[lane]; ++lane) {
      if (sums_[lane] > 0) last = lane;
      position -= sums_[lane];
    }
    // Rounding may leave a position behind the last weight.
    if (lane == kLanes) lane = last, position = sums_[lane];
    size_t source = lane;
    for (size_t i = lane; i < end_; i += kLanes) {
      if (!(weight_[i] > 0)) continue;
      source = i;
      if (position < weight_[i]) break;
      position -= weight_[i];
    }
    return source;
  }

 private:
  float *weight_, *sums_;
  size_t end_ = 0;
  float total_ = 0;
};

}  // namespace kinome
