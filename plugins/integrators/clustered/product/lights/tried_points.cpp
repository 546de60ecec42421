#include "clustered/product/lights/tried_points.h"

#include <algorithm>
#include <cstring>

#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Share of the takes that depends on cells' rates alone. It bounds the weight of a point that is
/// more important than estimated.
constexpr double kShareByRate = 0.25;

}  // namespace

void TriedPoints::begin(const LocalPoints& points) {
  of_pass_ = &points;
  points_.clear();
  cells_.clear();
  inverse_probabilities_.clear();
  eye_weights_.clear();
  rates_.clear();
  glossy_.clear();
}

void TriedPoints::add(uint32_t point, uint32_t cell, double probability, double rate,
                      float eye_weight) {
  if (of_pass_->reflection[point] != LightPoint::kLambertian) {
    glossy_.push_back(static_cast<uint32_t>(points_.size()));
  }
  points_.push_back(point);
  cells_.push_back(cell);
  inverse_probabilities_.push_back(static_cast<float>(1 / probability));
  rates_.push_back(rate / probability);
  eye_weights_.push_back(eye_weight);
}

void TriedPoints::gather() {
  const size_t size = points_.size(), length = padded(size);
  importance_.assign(length, 0.f);
  if (size == 0) return;
  gather_lobes();
  // Padding has no power.
  points_.resize(length, points_.front());
  cells_.resize(length, cells_.front());
  inverse_probabilities_.resize(length, 0.f);
  eye_weights_.resize(length, 0.f);
  power_.resize(length);
  of_patch_.resize(length);
  float* columns[simd::kLightPointNumbers];
  for (size_t k = 0; k < simd::kLightPointNumbers; ++k) {
    if (columns_[k].size() < length) columns_[k].resize(length);
    columns[k] = columns_[k].data();
  }
  simd::gather_points(of_pass_->rows.data(),
                      {points_.data(), inverse_probabilities_.data(), eye_weights_.data()}, length,
                      columns);
  for (size_t i = 0; i < length; ++i) {
    const Rgb power(columns_[9][i], columns_[10][i], columns_[11][i]);
    power_[i] = mean_of(glm::abs(power));
  }
}

void TriedPoints::gather_lobes() {
  const size_t size = glossy_.size(), length = padded(size);
  for (auto& column : lobe_columns_) column.assign(length, 0.f);
  lobe_scales_.resize(size);
  lobe_fractions_.resize(length);
  for (size_t k = 0; k < size; ++k) {
    const uint32_t point = points_[glossy_[k]];
    const Reflection& reflection = of_pass_->reflections[of_pass_->reflection[point]];
    const simd::LightPointRow& row = of_pass_->rows[point];
    const Rgb power(row.power[0], row.power[1], row.power[2]);
    const float emitted = mean_of(glm::abs(power));
    lobe_scales_[k] = emitted > 0 ? mean_of(glm::abs(reflection.incident)) / emitted : 0;
    for (size_t axis = 0; axis < 3; ++axis) lobe_columns_[axis][k] = row.position[axis];
    float numbers[kLobeNumbers];
    std::memcpy(numbers, &reflection.lobe, sizeof(numbers));
    for (size_t n = 0; n < kLobeNumbers; ++n) lobe_columns_[3 + n][k] = numbers[n];
  }
}

/// Scales the importance of points that aren't Lambertian by their lobes, each averaged over the
/// patch's size as seen from the point.
void TriedPoints::multiply_by_lobes(const simd::ReflectingPatch& patch, float size2) {
  const auto column = [&](size_t n) { return lobe_columns_[n].data(); };
  simd::sent_to_patch(patch, size2,
                      {{column(0), column(1), column(2)},
                       {column(3), column(4), column(5)},
                       {column(6), column(7), column(8)},
                       column(9),
                       column(10),
                       column(11)},
                      lobe_fractions_.size(), lobe_fractions_.data());
  for (size_t k = 0; k < glossy_.size(); ++k) {
    of_patch_[glossy_[k]] *= lobe_fractions_[k] * lobe_scales_[k];
  }
}

void TriedPoints::add_patch(const simd::ReflectingPatch& patch, float size2,
                            const float* visibility) {
  const auto column = [&](int k) { return columns_[k].data(); };
  simd::point_importance(patch, size2,
                         {{column(0), column(1), column(2)},
                          {column(3), column(4), column(5)},
                          power_.data(),
                          column(12),
                          cells_.data()},
                         visibility, points_.size(), of_patch_.data());
  multiply_by_lobes(patch, size2);
  simd::add_normalized(of_patch_.data(), points_.size(), importance_.data());
}

void TriedPoints::take(double max_takes, double offset, std::vector<Take>& out) const {
  const size_t size = rates_.size();
  double wanted = 0, important = 0;
  for (size_t i = 0; i < size; ++i) {
    wanted += rates_[i];
    important += static_cast<double>(importance_[i]);
  }
  const double by_rate = important > 0 ? kShareByRate : 1;
  const double by_importance = important > 0 ? (1 - kShareByRate) * wanted / important : 0;
  double left = 1 - offset;
  for (size_t i = 0; i < size; ++i) {
    const double share = by_rate * rates_[i] + by_importance * static_cast<double>(importance_[i]);
    const double takes = std::min(share, max_takes);
    if (!(takes > 0)) continue;
    const auto weight = static_cast<float>(static_cast<double>(inverse_probabilities_[i]) / takes);
    for (left -= takes; left <= 0; left += 1) out.push_back({points_[i], cells_[i], weight});
  }
}

}  // namespace kinome
