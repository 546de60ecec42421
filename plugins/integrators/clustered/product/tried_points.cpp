#include "clustered/product/tried_points.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Share of the takes that depends on rates of cells alone. It bounds the weight of a point that is
/// more important than estimated.
constexpr double kDefensive = 0.25;

}  // namespace

void TriedPoints::begin(const LocalPoints& points) {
  of_pass_ = &points;
  points_.clear();
  cells_.clear();
  inverse_probabilities_.clear();
  rates_.clear();
  glossy_.clear();
}

void TriedPoints::add(uint32_t point, uint32_t cell, double probability, double rate) {
  if (of_pass_->reflection[point] != LightPoint::kLambertian) {
    glossy_.push_back(static_cast<uint32_t>(points_.size()));
  }
  points_.push_back(point);
  cells_.push_back(cell);
  inverse_probabilities_.push_back(static_cast<float>(1 / probability));
  rates_.push_back(rate / probability);
}

void TriedPoints::gather() {
  const size_t size = points_.size(), length = padded(size);
  importance_.assign(length, 0.f);
  if (size == 0) return;
  // Padding has no power.
  points_.resize(length, points_.front());
  cells_.resize(length, cells_.front());
  inverse_probabilities_.resize(length, 0.f);
  power_.resize(length);
  of_patch_.resize(length);
  float* columns[simd::kLightPointNumbers];
  for (size_t k = 0; k < simd::kLightPointNumbers; ++k) {
    if (columns_[k].size() < length) columns_[k].resize(length);
    columns[k] = columns_[k].data();
  }
  const float* const weights = inverse_probabilities_.data();
  simd::gather_points(of_pass_->rows.data(), {points_.data(), weights, weights}, length, columns);
  for (size_t i = 0; i < length; ++i) {
    const Rgb power(columns_[9][i], columns_[10][i], columns_[11][i]);
    power_[i] = mean_of(glm::abs(power));
  }
}

/// Replaces the importance of points that aren't Lambertian by that of their lobes, each as wide as
/// the patch appears from there.
void TriedPoints::multiply_by_lobes(const simd::ReflectingPatch& patch, float size2) {
  const Vec3 position(patch.position[0], patch.position[1], patch.position[2]);
  for (const uint32_t i : glossy_) {
    if (!(of_patch_[i] > 0)) continue;
    const LightPoint& point = of_pass_->points[points_[i]];
    const Vec3 to = position - point.position;
    const float squared = glm::dot(to, to) + 1e-30f;
    const Rgb sent = of_pass_->reflections[point.reflection].about(to / std::sqrt(squared),
                                                                   size2 / (squared + size2));
    const float power = mean_of(glm::abs(point.power));
    of_patch_[i] *= mean_of(glm::abs(sent)) / std::max(power, 1e-30f);
  }
}

void TriedPoints::add_patch(const simd::ReflectingPatch& patch, float size2,
                            const float* visibility) {
  const auto column = [&](int k) { return columns_[k].data(); };
  simd::point_importance(patch, size2,
                         {{column(0), column(1), column(2)},
                          {column(3), column(4), column(5)},
                          power_.data(),
                          cells_.data()},
                         visibility, points_.size(), of_patch_.data());
  multiply_by_lobes(patch, size2);
  simd::add_normalized(of_patch_.data(), points_.size(), importance_.data());
}

void TriedPoints::take(double most, double offset, std::vector<Take>& out) const {
  const size_t size = rates_.size();
  double wanted = 0, important = 0;
  for (size_t i = 0; i < size; ++i) {
    wanted += rates_[i];
    important += static_cast<double>(importance_[i]);
  }
  const double by_rate = important > 0 ? kDefensive : 1;
  const double by_importance = important > 0 ? (1 - kDefensive) * wanted / important : 0;
  double left = 1 - offset;
  for (size_t i = 0; i < size; ++i) {
    const double share = by_rate * rates_[i] + by_importance * static_cast<double>(importance_[i]);
    const double takes = std::min(share, most);
    if (!(takes > 0)) continue;
    const auto weight = static_cast<float>(static_cast<double>(inverse_probabilities_[i]) / takes);
    for (left -= takes; left <= 0; left += 1) out.push_back({points_[i], cells_[i], weight});
  }
}

}  // namespace kinome
