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
  Cell sample(const Vec2& u) const {
    Cell cell{0, 0, glm::min(u, Vec2(kOneMinusEpsilon))};
    cell.row = find(row_cdf_.data(), row_guide_.data(), row_guide_size_, cell.u.y);
    cell.column = find(column_cdf(cell.row), column_guide(cell.row), column_guide_size_, cell.u.x);
    return cell;
  }

  /// What sample() reads, for those who invert many numbers at once (kinome/wide/distribution.h).
  struct Tables {
    const float* row_cdf;
    const uint32_t* row_guide;
    uint32_t row_guide_size;
    const float* column_cdf;       ///< rows x columns
    const uint32_t* column_guide;  ///< rows x (column_guide_size + 1)
    uint32_t column_guide_size;
    uint32_t columns;
  };
  Tables tables() const {
    return {row_cdf_.data(),      row_guide_.data(),  row_guide_size_, column_cdf_.data(),
            column_guide_.data(), column_guide_size_, columns_};
  }

 private:
  /// First entry of `cdf` above u (entries are the ends of their cells); u becomes its place in the
  /// cell. Guide: for each k of a power of two, the first entry above k / size.
  static uint32_t find(const float* cdf, const uint32_t* guide, uint32_t guide_size, float& u) {
    // The guide's size is a power of two: the product is exact.
    const auto k = static_cast<uint32_t>(u * static_cast<float>(guide_size));
    uint32_t first = guide[k];
    uint32_t length = guide[k + 1] - first;  // the last one is the answer if no other is
    while (length > 0) {                     // binary search without branches on the data
      const uint32_t half = length / 2;
      const bool above = cdf[first + half] <= u;
      first = above ? first + half + 1 : first;
      length = above ? length - half - 1 : half;
    }
    const float start = first == 0 ? 0.f : cdf[first - 1];
    u = std::min((u - start) / (cdf[first] - start), kOneMinusEpsilon);
    return first;
  }
  const float* column_cdf(uint32_t row) const {
    return column_cdf_.data() + static_cast<size_t>(row) * columns_;
  }
  const uint32_t* column_guide(uint32_t row) const {
    return column_guide_.data() + static_cast<size_t>(row) * (column_guide_size_ + 1);
  }

  uint32_t columns_ = 0;
  uint32_t column_guide_size_ = 0;
  uint32_t row_guide_size_ = 0;
  double total_ = 0;
  std::vector<float> column_cdf_;  ///< rows x columns_
  std::vector<uint32_t> column_guide_;
  std::vector<float> row_cdf_;
  std::vector<uint32_t> row_guide_;
};

}  // namespace kinome
