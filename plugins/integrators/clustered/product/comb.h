#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
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
  static constexpr float kBelowOne = 0x1.fffffep-1f;

  /// Where each stratum of a block ends: four runs of four, which are summed side by side, each
  /// from where the one before ends, so that ends never go down, and don't move where a weight is
  /// 0.
  struct Ends {
    static constexpr size_t kRuns = 4, kOfRun = 4;
    static_assert(kRuns * kOfRun == simd::kCellLanes);
    using Floats = float __attribute__((vector_size(16)));
    using Doubles = double __attribute__((vector_size(32)));
    using Integers = int64_t __attribute__((vector_size(32)));
    Doubles of[kOfRun];  ///< [place in the run], run by run

    Ends(const float* weights, double begin) {
      Floats runs[kRuns];
      std::memcpy(runs, weights, sizeof runs);
      // Transposed: the first of each run, the second ...
      const Floats a = __builtin_shufflevector(runs[0], runs[1], 0, 4, 1, 5);
      const Floats b = __builtin_shufflevector(runs[2], runs[3], 0, 4, 1, 5);
      const Floats c = __builtin_shufflevector(runs[0], runs[1], 2, 6, 3, 7);
      const Floats d = __builtin_shufflevector(runs[2], runs[3], 2, 6, 3, 7);
      of[0] = __builtin_convertvector(__builtin_shufflevector(a, b, 0, 1, 4, 5), Doubles);
      of[1] = __builtin_convertvector(__builtin_shufflevector(a, b, 2, 3, 6, 7), Doubles);
      of[2] = __builtin_convertvector(__builtin_shufflevector(c, d, 0, 1, 4, 5), Doubles);
      of[3] = __builtin_convertvector(__builtin_shufflevector(c, d, 2, 3, 6, 7), Doubles);
      for (size_t i = 1; i < kOfRun; ++i) of[i] += of[i - 1];
      const Doubles sums = of[kOfRun - 1];
      const double second = begin + sums[0], third = second + sums[1], last = third + sums[2];
      const Doubles begins = {begin, second, third, last};
      for (Doubles& ends : of) ends += begins;
    }
    double operator[](size_t i) const { return of[i % kOfRun][i / kOfRun]; }
    /// How many strata end at or before a point.
    size_t before(double point) const {
      const Doubles points = {point, point, point, point};
      const Integers minus = ((of[0] <= points) + (of[1] <= points)) +
                             ((of[2] <= points) + (of[3] <= points));
      return static_cast<size_t>(-((minus[0] + minus[1]) + (minus[2] + minus[3])));
    }
  };

  void pass_block(const float* weights, size_t first, double end, std::vector<Hit>& hits) {
    const Ends ends(weights + first, position_);
    // Whether there is another point isn't asked of the ends, which take longer to be known.
    for (; next_ < end && left_ > 0; next_ += step_, --left_) {
      size_t i = ends.before(next_);
      float share = kBelowOne;
      if (i < simd::kCellLanes) {
        const double begin = i > 0 ? ends[i - 1] : position_;
        share = std::min(static_cast<float>((next_ - begin) / weights[first + i]), kBelowOne);
      } else {
        // The block's sum, rounded otherwise, may reach a little further than its weights.
        while (i > 0 && !(weights[first + --i] > 0)) {
        }
        if (!(weights[first + i] > 0)) continue;
      }
      hits.push_back({static_cast<uint32_t>(first + i), share});
    }
  }

  double step_;
  double next_;
  double position_ = 0;
  size_t left_;
};

}  // namespace kinome
