#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "clustered/kernels/cell_kernels.h"

namespace kinome {

/// Systematic sampling: `count` points at equal distances along the line of all strata, laid end to
/// end with their weights as lengths. Points keep their order along the line, and what is left of
/// each within its stratum is as uniform as a random number: neighbours in the list of strata are
/// sampled as one stratified set (Åkerlund 2008, 6.1.1 asks for such numbers; Deville and Tillé
/// 1998 for the method's variance).
class Comb {
 public:
  struct Hit {
    uint32_t stratum;
    float remainder;  ///< in [0, 1)
  };

  /// `total`: of all weights that will be passed; `offset` in [0, 1) is the one random number.
  Comb(double total, size_t count, double offset)
      : step_(total / static_cast<double>(count)), next_(offset * step_), left_(count) {}

  /// Points at a given distance, as many as there will be: a stratum that is as long as the step is
  /// hit exactly once.
  static Comb by_step(double step, double offset) {
    Comb comb(step, 1, offset);
    comb.left_ = std::numeric_limits<size_t>::max();
    return comb;
  }

  /// Appends the points that fall on the next `size` (padded) strata, whose weights are summed in
  /// blocks of simd::kCellLanes. A stratum of weight 0 is never hit.
  void pass(const float* weights, const float* block_sums, size_t size, std::vector<Hit>& hits) {
    for (size_t block = 0; block < size / simd::kCellLanes; ++block) {
      const double end = position_ + block_sums[block];
      if (next_ < end && left_ > 0) pass_block(weights, block * simd::kCellLanes, end, hits);
      position_ = end;
    }
  }

 private:
  void pass_block(const float* weights, size_t first, double end, std::vector<Hit>& hits) {
    double ends[simd::kCellLanes];
    double sum = position_;
    for (size_t i = 0; i < simd::kCellLanes; ++i) ends[i] = sum += weights[first + i];
    for (; next_ < sum && left_ > 0; next_ += step_, --left_) {
      // The first stratum that ends behind the point, in steps of halves without branches.
      size_t i = 0;
      for (size_t half = simd::kCellLanes / 2; half > 0; half /= 2) {
        i += ends[i + half - 1] <= next_ ? half : 0;
      }
      const double begin = i > 0 ? ends[i - 1] : position_;
      const auto share = static_cast<float>((next_ - begin) / weights[first + i]);
      hits.push_back({static_cast<uint32_t>(first + i),
                      std::min(std::max(share, 0.f), std::nextafter(1.f, 0.f))});
    }
    // The block's sum, rounded otherwise, may reach a little further than its weights.
    for (; next_ < end && left_ > 0; next_ += step_, --left_) {
      size_t last = first + simd::kCellLanes - 1;
      while (last > first && !(weights[last] > 0)) --last;
      if (!(weights[last] > 0)) continue;
      hits.push_back({static_cast<uint32_t>(last), std::nextafter(1.f, 0.f)});
    }
  }

  double step_;
  double next_;
  double position_ = 0;
  size_t left_;
};

}  // namespace kinome
