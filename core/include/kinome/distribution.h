#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// Cells of a grid, picked with probability proportional to their weights. The marginal of the rows
/// and the conditional of the columns are inverted in order, so that stratified numbers stay
/// stratified; guide tables (Chen and Asau 1974) make that take constant time on average.
/// Immutable; thread-safe.
class KINOME_EXPORT GridDistribution {
 public:
  GridDistribution() = default;
  /// `weights`, row by row: finite, not negative. Sums are taken in double precision. Throws
  /// std::invalid_argument where their number is wrong.
  GridDistribution(uint32_t columns, uint32_t rows, std::vector<float> weights);

  /// Sum of the weights; where it is 0 there is nothing to sample.
  double total() const { return total_; }

  struct Cell {
    uint32_t column;
    uint32_t row;
    Vec2 u;  ///< what is left of the random numbers: uniform in [0, 1)², for use within the cell
  };
  /// Never a cell of weight 0. total() must not be 0.
  Cell sample(const Vec2& u) const;

 private:
  /// Cumulative probabilities (each entry the end of its cell), and for each k of a power of two
  /// the first entry above k / size.
  struct Row {
    const float* cdf;
    const uint32_t* guide;
  };
  static void finish_row(float* cdf, uint32_t count, uint32_t* guide, uint32_t guide_size);
  static uint32_t find(const Row& row, uint32_t guide_size, float& u);

  uint32_t columns_ = 0;
  uint32_t rows_ = 0;
  uint32_t column_guide_size_ = 0;
  uint32_t row_guide_size_ = 0;
  double total_ = 0;
  std::vector<float> column_cdf_;  ///< rows_ x columns_
  std::vector<uint32_t> column_guide_;
  std::vector<float> row_cdf_;
  std::vector<uint32_t> row_guide_;
};

}  // namespace kinome
