#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "clustered/kernels/cell_kernels.h"
#include "kinome/math.h"

namespace kinome {

/// Systematic sampling: `count` equally spaced points on a line. The strata lie on this line end to
/// end, and the weight of each is its length. Points are in order along the line. The position of a
/// point within its stratum serves as a uniform random number, so that neighbouring strata are
/// sampled as one stratified set. Åkerlund 2008, 6.1.1 requires such numbers; Deville and Tillé
/// 1998 derive the method's variance.
class Comb {
 public:
  struct Hit {
    uint32_t stratum;
    float remainder;  ///< in [0, 1)
  };

  /// `total`: sum of all weights that will be passed. `offset`: the random number, in [0, 1).
  Comb(double total, size_t count, double offset)
      : step_(total / static_cast<double>(count)), next_(offset * step_), left_(count) {}

  /// Returns a comb with a given distance between points and no limit to their number. A stratum as
  /// long as `step` is hit exactly once.
  static Comb by_step(double step, double offset) {
    Comb comb(step, 1, offset);
    comb.left_ = std::numeric_limits<size_t>::max();
    return comb;
  }

  /// Appends the points on the next `size` strata to `hits`. `size` is a multiple of
  /// simd::kCellLanes; `block_sums` has the sum of each simd::kCellLanes weights. A stratum of
  /// weight 0 is never hit.
  void pass(const float* weights, const float* block_sums, size_t size, std::vector<Hit>& hits) {
    for (size_t block = 0; block < size / simd::kCellLanes; ++block) {
      const double end = position_ + block_sums[block];
      if (next_ < end && left_ > 0) pass_block(weights, block * simd::kCellLanes, end, hits);
      position_ = end;
    }
  }

 private:
  /// End of each stratum of a block: prefix sums of four runs of four, computed side by side. Each
  /// run starts at the end of the previous one. So the ends never decrease, and are equal if a
  /// weight is 0.
  struct Ends {
    static constexpr size_t kRuns = 4, kRunLength = 4;
    static_assert(kRuns * kRunLength == simd::kCellLanes);
    using Floats = float __attribute__((vector_size(16)));
    using Doubles = double __attribute__((vector_size(32)));
    using Integers = int64_t __attribute__((vector_size(32)));
    Doubles of[kRunLength];  ///< [index within the run], one element per run

    Ends(const float* weights, double begin) {
      Floats runs[kRuns];
      std::memcpy(runs, weights, sizeof runs);
      // Transpose: of[i] gets element i of each run.
      const Floats a = __builtin_shufflevector(runs[0], runs[1], 0, 4, 1, 5);
      const Floats b = __builtin_shufflevector(runs[2], runs[3], 0, 4, 1, 5);
      const Floats c = __builtin_shufflevector(runs[0], runs[1], 2, 6, 3, 7);
      const Floats d = __builtin_shufflevector(runs[2], runs[3], 2, 6, 3, 7);
      of[0] = __builtin_convertvector(__builtin_shufflevector(a, b, 0, 1, 4, 5), Doubles);
      of[1] = __builtin_convertvector(__builtin_shufflevector(a, b, 2, 3, 6, 7), Doubles);
      of[2] = __builtin_convertvector(__builtin_shufflevector(c, d, 0, 1, 4, 5), Doubles);
      of[3] = __builtin_convertvector(__builtin_shufflevector(c, d, 2, 3, 6, 7), Doubles);
      for (size_t i = 1; i < kRunLength; ++i) of[i] += of[i - 1];
      const Doubles sums = of[kRunLength - 1];
      const double second = begin + sums[0], third = second + sums[1], last = third + sums[2];
      const Doubles begins = {begin, second, third, last};
      for (Doubles& ends : of) ends += begins;
    }
    double operator[](size_t i) const { return of[i % kRunLength][i / kRunLength]; }
    /// Returns the number of strata that end at or before a point.
    size_t before(double point) const {
      const Doubles points = {point, point, point, point};
      const Integers minus = ((of[0] <= points) + (of[1] <= points)) +
                             ((of[2] <= points) + (of[3] <= points));
      return static_cast<size_t>(-((minus[0] + minus[1]) + (minus[2] + minus[3])));
    }
  };

  void pass_block(const float* weights, size_t first, double end, std::vector<Hit>& hits) {
    const Ends ends(weights + first, position_);
    // The loop condition uses `end` rather than `ends`, which are available later.
    for (; next_ < end && left_ > 0; next_ += step_, --left_) {
      size_t i = ends.before(next_);
      float share = kOneMinusEpsilon;
      if (i < simd::kCellLanes) {
        const double begin = i > 0 ? ends[i - 1] : position_;
        share =
            std::min(static_cast<float>((next_ - begin) / weights[first + i]), kOneMinusEpsilon);
      } else {
        // Because of rounding, the block's sum can exceed the last end slightly.
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
