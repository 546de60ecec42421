#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace kinome {

/// Importance of the quads of a grid, with prefix sums along rows. They are stored only for every
/// kBlock-th quad, so that the tables of a large map don't take many times its memory.
class QuadImportance {
 public:
  QuadImportance(int columns, int rows)
      : columns_(columns),
        stride_(columns / kBlock + 1),
        values_(std::make_unique_for_overwrite<float[]>(static_cast<size_t>(columns) * rows)),
        blocks_(static_cast<size_t>(stride_) * rows) {}

  /// Values of a row; must be set before sum_row().
  float* row(int y) { return &values_[static_cast<size_t>(y) * columns_]; }
  const float* row(int y) const { return &values_[static_cast<size_t>(y) * columns_]; }
  const float& operator[](size_t quad) const { return values_[quad]; }

  /// Raises each value to at least `share` times the largest of its eight neighbours. Columns wrap
  /// around. Call it before sum_row().
  void spread(float share) {
    const auto rows = static_cast<int>(blocks_.size() / stride_);
    // Maxima over three columns: of the row above, of the row itself, of the row below.
    std::vector<float> above(columns_, 0.f), own = row_maxima(0), below;
    for (int y = 0; y < rows; ++y) {
      below = y + 1 < rows ? row_maxima(y + 1) : std::vector<float>(columns_, 0.f);
      float* const values = row(y);
      for (int x = 0; x < columns_; ++x) {
        values[x] = std::max(values[x], share * std::max({above[x], own[x], below[x]}));
      }
      above = std::move(own);
      own = std::move(below);
    }
  }

  /// Raises the values of a row to at least `least`, and computes its prefix sums.
  void sum_row(int y, float least) {
    float* const values = row(y);
    Sums* const blocks = &blocks_[static_cast<size_t>(y) * stride_];
    Sums sums;
    for (int x = 0; x < columns_; ++x) {
      if (x % kBlock == 0) blocks[x / kBlock] = sums;
      values[x] = std::max(values[x], least);
      sums.add(values[x]);
    }
    if (columns_ % kBlock == 0) blocks[columns_ / kBlock] = sums;
  }

  struct Sums {
    double values = 0;
    double squares = 0;
    void add(float value) {
      values += value;
      squares += static_cast<double>(value) * value;
    }
  };
  /// Returns the sums over columns [x0, x1) of a row.
  Sums sum(int y, int x0, int x1) const {
    Sums sums;
    if (x1 - x0 <= kBlock) {
      const float* const values = row(y);
      for (int x = x0; x < x1; ++x) sums.add(values[x]);
      return sums;
    }
    const Sums begin = before(y, x0), end = before(y, x1);
    return {end.values - begin.values, end.squares - begin.squares};
  }

  /// Position in a row: a column, and the share of its quad that is before the position, in [0, 1).
  struct Place {
    int column;
    double share;
  };
  /// Returns the position in columns [x0, x1) where a share of their sum is reached.
  Place find(int y, int x0, int x1, double share) const {
    const float* const values = row(y);
    const Sums* const blocks = &blocks_[static_cast<size_t>(y) * stride_];
    double at = before(y, x0).values;
    const double target = at + share * sum(y, x0, x1).values;
    const Sums* const after =
        std::upper_bound(blocks + x0 / kBlock + 1, blocks + (x1 - 1) / kBlock + 1, target,
                         [](double value, const Sums& sums) { return value < sums.values; });
    int x = x0;
    if (after > blocks + x0 / kBlock + 1) {
      x = static_cast<int>(after - 1 - blocks) * kBlock;
      at = after[-1].values;
    }
    while (x + 1 < x1 && at + values[x] <= target) at += values[x++];
    return {x, std::clamp((target - at) / values[x], 0., 0.9999999)};
  }

 private:
  std::vector<float> row_maxima(int y) const {
    const float* const values = row(y);
    std::vector<float> maxima(columns_);
    for (int x = 0; x < columns_; ++x) {
      const int before = x > 0 ? x - 1 : columns_ - 1, after = x + 1 < columns_ ? x + 1 : 0;
      maxima[x] = std::max({values[before], values[x], values[after]});
    }
    return maxima;
  }
  static constexpr int kBlock = 16;

  Sums before(int y, int x) const {
    const int block = x / kBlock;
    Sums sums = blocks_[static_cast<size_t>(y) * stride_ + block];
    const float* const values = row(y);
    for (int k = block * kBlock; k < x; ++k) sums.add(values[k]);
    return sums;
  }

  int columns_;
  int stride_;  ///< number of blocks in a row, plus 1
  std::unique_ptr<float[]> values_;
  std::vector<Sums> blocks_;
};

}  // namespace kinome
