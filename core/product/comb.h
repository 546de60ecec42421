#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "cell_kernels.h"

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
  static_assert(simd::kCellLanes == 16);
  /// Sums of two, four and eight weights of a block.
  struct Sums {
    double two[8], four[4], eight[2];
    explicit Sums(const float* w) {
      for (int i = 0; i < 8; ++i) two[i] = static_cast<double>(w[2 * i]) + w[2 * i + 1];
      for (int i = 0; i < 4; ++i) four[i] = two[2 * i] + two[2 * i + 1];
      for (int i = 0; i < 2; ++i) eight[i] = four[2 * i] + four[2 * i + 1];
    }
  };

  void pass_block(const float* weights, size_t first, double end, std::vector<Hit>& hits) {
    const float* const w = weights + first;
    const Sums sums(w);
    const double sum = position_ + (sums.eight[0] + sums.eight[1]);
    for (; next_ < sum && left_ > 0; next_ += step_, --left_) {
      // Down the tree of sums: a chain of four additions, where running sums would take sixteen.
      double begin = position_;
      size_t i = 0;
      const auto descend = [&](double left, size_t width) {
        const bool is_right = next_ >= begin + left;
        begin += is_right ? left : 0;
        i += is_right ? width : 0;
      };
      descend(sums.eight[0], 8);
      descend(sums.four[i / 4], 4);
      descend(sums.two[i / 2], 2);
      descend(w[i], 1);
      // Rounded sums may lead past the last weight.
      while (i > 0 && !(w[i] > 0)) --i;
      if (!(w[i] > 0)) continue;
      const float share = static_cast<float>(next_ - begin) / w[i];
      hits.push_back({static_cast<uint32_t>(first + i),
                      std::min(std::max(share, 0.f), std::nextafter(1.f, 0.f))});
    }
    // The block's sum, rounded otherwise, may reach a little further than its weights.
    for (; next_ < end && left_ > 0; next_ += step_, --left_) {
      size_t last = simd::kCellLanes - 1;
      while (last > 0 && !(w[last] > 0)) --last;
      if (!(w[last] > 0)) continue;
      hits.push_back({static_cast<uint32_t>(first + last), std::nextafter(1.f, 0.f)});
    }
  }

  double step_;
  double next_;
  double position_ = 0;
  size_t left_;
};

}  // namespace kinome
