#include "kinome/distribution.h"

#include <bit>
#include <stdexcept>

namespace kinome {
namespace {

/// Returns the size of a guide table with two to four cells per entry.
uint32_t guide_size_for(uint32_t count) {
  return std::max(1u, std::bit_ceil(count) / 4);
}

/// Writes the cumulative probabilities of the weights to `cdf` and returns the weights' sum. The
/// CDF is exactly 1 from the last cell with a positive weight on. `cdf` may equal `weights`.
template <class Weight>
double accumulate(const Weight* weights, float* cdf, uint32_t count) {
  double sum = 0;
  for (uint32_t i = 0; i < count; ++i) sum += weights[i];
  if (!(sum > 0)) {
    std::fill(cdf, cdf + count, 1.f);
    return 0;
  }
  uint32_t last = 0;
  double running = 0;
  const double scale = 1 / sum;
  for (uint32_t i = 0; i < count; ++i) {
    if (weights[i] > 0) last = i;
    running += weights[i];
    cdf[i] = static_cast<float>(std::min(running * scale, 1.0));
  }
  std::fill(cdf + last, cdf + count, 1.f);
  return sum;
}

void fill_guide(const float* cdf, uint32_t count, uint32_t* guide, uint32_t guide_size) {
  uint32_t i = 0;
  for (uint32_t k = 0; k < guide_size; ++k) {
    const float start = static_cast<float>(k) / static_cast<float>(guide_size);
    while (i + 1 < count && cdf[i] <= start) ++i;
    guide[k] = i;
  }
  guide[guide_size] = count - 1;
}

}  // namespace

GridDistribution::GridDistribution(uint32_t columns, uint32_t rows, std::vector<float> weights)
    : columns_(columns),
      column_guide_size_(guide_size_for(columns)),
      row_guide_size_(guide_size_for(rows)),
      column_cdf_(std::move(weights)) {
  if (columns == 0 || rows == 0 || column_cdf_.size() != static_cast<size_t>(columns) * rows) {
    throw std::invalid_argument("GridDistribution: the number of weights is not rows x columns");
  }
  column_guide_.resize(static_cast<size_t>(rows) * (column_guide_size_ + 1));
  std::vector<double> sums(rows);
  for (uint32_t y = 0; y < rows; ++y) {
    float* const row = column_cdf_.data() + static_cast<size_t>(y) * columns;
    sums[y] = accumulate(row, row, columns);
    fill_guide(row, columns,
               column_guide_.data() + static_cast<size_t>(y) * (column_guide_size_ + 1),
               column_guide_size_);
  }
  row_cdf_.resize(rows);
  row_guide_.resize(row_guide_size_ + 1);
  total_ = accumulate(sums.data(), row_cdf_.data(), rows);
  fill_guide(row_cdf_.data(), rows, row_guide_.data(), row_guide_size_);
}

}  // namespace kinome
