#include "clustered/product/point_choice.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Of where paths and light points find as much, so much is added to what points are chosen by.
constexpr float kSoftening = 0.3f;

}  // namespace

PointChoice::Block PointChoice::take(const LocalChoice& choice, uint32_t bits, uint32_t edges) {
  Block taken{points_.size(), 0};
  const LocalChoice::Block block = choice.block(bits);
  for (uint32_t i = 0; i < block.size; ++i) {
    const LightPoint& point = light_.local_points.points[block.point[i]];
    const bool is_padding = block.weight[i] == 0;
    if (is_padding || !point.is_plain || point.edges + edges > light_.local->max_depth()) continue;
    points_.push_back(block.point[i]);
    weights_.push_back(block.weight[i]);
  }
  taken.end = points_.size();
  return taken;
}

std::optional<PointChoice::Chosen> PointChoice::choose(const SurfaceInteraction& y, Block block,
                                                       std::span<const float> rates, float u) {
  const bool transmits = y.shape->bsdf().transmits();
  const float side = y.wi.z >= 0 ? 1.f : -1.f;
  sums_.clear();
  float sum = 0;
  for (size_t k = block.begin; k < block.end; ++k) {
    const LightPoint& point = light_.local_points.points[points_[k]];
    const Vec3 to = point.position - y.p;
    const float distance2 = glm::dot(to, to), distance = std::sqrt(distance2);
    const Vec3 d = to / distance;
    const float cosine = side * glm::dot(y.frame.n, d);
    const bool may_reach = distance2 > 0 && glm::dot(point.normal, d) < 0 &&
                           (cosine > 0 || transmits) && y.resolves(d, distance);
    if (may_reach) {
      const float softened = distance2 + kSoftening * third_odds(point, rates);
      sum += std::abs(cosine * glm::dot(point.geometric, d)) * mean_of(glm::abs(point.power)) *
             weights_[k] / softened;
    }
    sums_.push_back(sum);
  }
  if (!(sum > 0) || !std::isfinite(sum)) return std::nullopt;
  const auto found = std::upper_bound(sums_.begin(), sums_.end() - 1, u * sum);
  const auto k = static_cast<size_t>(found - sums_.begin());
  const float probability = (sums_[k] - (k > 0 ? sums_[k - 1] : 0)) / sum;
  if (!(probability > 0)) return std::nullopt;
  const size_t chosen = block.begin + k;
  return Chosen{light_.local_points.points[points_[chosen]], probability, weights_[chosen]};
}

}  // namespace kinome
