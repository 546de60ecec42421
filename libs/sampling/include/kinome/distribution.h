#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// Discrete distribution over the cells of a grid, proportional to their weights. Inverts the
/// marginal CDF of the rows and the conditional CDF of the columns in order, which preserves
/// stratification. Guide tables (Chen and Asau 1974) make sampling constant-time on average.
/// Immutable; thread-safe.
class KINOME_EXPORT GridDistribution {
 public:
  GridDistribution() = default;
  /// Takes weights row by row; they must be finite and not negative. Sums are computed in double
  /// precision. Throws std::invalid_argument if the number of weights is wrong.
  GridDistribution(uint32_t columns, uint32_t rows, std::vector<float> weights);

  /// Sum of the weights; sample() must not be called if it is 0.
  double total() const { return total_; }

  struct Cell {
    uint32_t column;
    uint32_t row;
    Vec2 u;  ///< remapped random numbers, uniform in [0, 1)², for use within the cell
  };
  /// Samples a cell; never one with weight 0. total() must be positive.
  Cell sample(const Vec2& u) const {
    Cell cell{0, 0, glm::min(u, Vec2(kOneMinusEpsilon))};
    cell.row = find(row_cdf_.data(), row_guide_.data(), row_guide_size_, cell.u.y);
    cell.column = find(column_cdf(cell.row), column_guide(cell.row), column_guide_size_, cell.u.x);
    return cell;
  }

  /// Tables read by sample(), for vectorised inversion (kinome/wide/distribution.h).
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
  /// Returns the first entry of `cdf` above u, where entry i is the end of cell i, and remaps u to
  /// its position in the cell. `guide[k]` is the first entry above k / guide_size.
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
