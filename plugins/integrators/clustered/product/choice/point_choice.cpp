#include "clustered/product/choice/point_choice.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/tiles/spread.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

using wide::Float;
using wide::Mask;

/// Fraction of the squared distance at which paths from the eye and light points find equal amounts
/// of light. It is added to squared distances, which softens the probabilities.
constexpr float kSoftening = 0.3f;

}  // namespace

PointChoice::Block PointChoice::take(const LocalChoice& choice, uint32_t bits, uint32_t edges) {
  Block taken{points_.size(), points_.size()};
  const LocalChoice::Block block = choice.block(bits);
  points_.resize(taken.begin + padded(block.size));
  if (columns_[kPower].size() < points_.size()) {
    for (auto& column : columns_) column.resize(2 * points_.size());
  }
  for (uint32_t i = 0; i < block.size; ++i) {
    const LightPoint& point = light_.local_points.points[block.point[i]];
    const bool is_padding = block.weight[i] == 0;
    if (is_padding || !point.is_plain || point.edges + edges > light_.local->max_depth()) continue;
    const size_t k = taken.end++;
    points_[k] = block.point[i];
    columns_[kWeight][k] = block.weight[i];
    for (int axis = 0; axis < 3; ++axis) {
      columns_[kPosition + axis][k] = block.columns.position[axis][i];
      columns_[kNormal + axis][k] = block.columns.normal[axis][i];
      columns_[kGeometric + axis][k] = block.columns.geometric[axis][i];
    }
    columns_[kPower][k] = mean_of(glm::abs(point.power)) * block.weight[i];
    columns_[kOdds][k] = third_odds(point, choice.rates());
  }
  points_.resize(padded(taken.end));
  for (size_t k = taken.end; k < points_.size(); ++k) {
    for (auto& column : columns_) column[k] = 0;
  }
  return taken;
}

std::optional<PointChoice::Chosen> PointChoice::choose(const SurfaceInteraction& y, Block block,
                                                       float u) {
  const bool transmits = y.shape->bsdf().transmits();
  const wide::Vec3 from(y.p.x, y.p.y, y.p.z), plane(y.n.x, y.n.y, y.n.z);
  const Vec3 up = y.frame.n * (y.wi.z >= 0 ? 1.f : -1.f);
  const wide::Vec3 side(up.x, up.y, up.z);
  const size_t count = block.end - block.begin;
  if (chances_.size() < padded(count)) chances_.resize(padded(count));
  Float sums = 0;
  wide::for_lanes(count, [&](size_t i) {
    const size_t k = block.begin + i;
    const auto load = [&](int number) {
      return wide::Vec3(Float::load(&columns_[number][k]), Float::load(&columns_[number + 1][k]),
                        Float::load(&columns_[number + 2][k]));
    };
    const wide::Vec3 to = load(kPosition) - from;
    const Float distance2 = dot(to, to), inverse = 1.f / sqrt(distance2);
    const Float cosine = dot(side, to) * inverse;
    Mask may_reach = distance2 > 0.f && dot(load(kNormal), to) < 0.f;
    may_reach &= abs(dot(plane, to)) > y.p_error;  // see SurfaceInteraction::resolves
    if (!transmits) may_reach &= cosine > 0.f;
    const Float softened = distance2 + kSoftening * Float::load(&columns_[kOdds][k]);
    const Float weight = abs(cosine * dot(load(kGeometric), to) * inverse) *
                         Float::load(&columns_[kPower][k]) / softened;
    const Float chosen_by = select(may_reach, weight);
    chosen_by.store(&chances_[i]);
    sums += chosen_by;
  });
  const float sum = wide::sum(sums);
  if (!(sum > 0) || !std::isfinite(sum)) return std::nullopt;
  float left = u * sum;
  size_t chosen = count;
  for (size_t i = 0; i < count; ++i) {
    if (!(chances_[i] > 0)) continue;
    chosen = i;  // the last one, in case of rounding
    left -= chances_[i];
    if (left < 0) break;
  }
  const size_t k = block.begin + chosen;
  return Chosen{light_.local_points.points[points_[k]], chances_[chosen] / sum,
                columns_[kWeight][k]};
}

}  // namespace kinome
