#include "kit/scenes/receivers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinome::check {

Vec2 square_of_direction(const Vec3& d) {
  const float phi = std::atan2(d.y, d.x) / (2 * kPi);
  return {std::clamp(phi < 0 ? phi + 1 : phi, 0.f, 1.f), std::clamp(0.5f + 0.5f * d.z, 0.f, 1.f)};
}

Vec3 direction_of_square(const Vec2& uv) {
  const float z = 2 * uv.y - 1, r = 2 * safe_sqrt(uv.y * (1 - uv.y)), phi = 2 * kPi * uv.x;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// ---- Receiver

Receiver Receiver::plane(const Vec3& centre, const Frame& frame, const Vec2& half_extent) {
  Receiver receiver;
  receiver.centre_ = centre;
  receiver.frame_ = frame;
  receiver.half_extent_ = half_extent;
  receiver.area_ = 4 * double{half_extent.x} * double{half_extent.y};
  return receiver;
}

Receiver Receiver::sphere(const Vec3& centre, float radius) {
  Receiver receiver;
  receiver.is_sphere_ = true;
  receiver.centre_ = centre;
  receiver.radius_ = radius;
  receiver.area_ = 4 * std::numbers::pi * double{radius} * double{radius};
  return receiver;
}

Receiver::Point Receiver::at(const Vec2& uv) const {
  if (is_sphere_) {
    const Vec3 n = direction_of_square(uv);
    return {centre_ + radius_ * n, n};
  }
  const Vec2 local = (2.f * uv - 1.f) * half_extent_;
  return {centre_ + frame_.s * local.x + frame_.t * local.y, frame_.n};
}

int Receiver::crossings_of(const Vec3& o, const Vec3& d, Crossing (&out)[2]) const {
  int count = 0;
  const Vec3 from = o - centre_;
  if (is_sphere_) {
    const float along = -glm::dot(from, d);
    const Vec3 nearest = from + along * d;
    const float across2 = sqr(radius_) - glm::dot(nearest, nearest);
    if (!(across2 > 0)) return 0;
    const float half = std::sqrt(across2);
    for (const float t : {along - half, along + half}) {
      if (t > 0) out[count++] = {square_of_direction((from + t * d) / radius_), t < along};
    }
    return count;
  }
  const float speed = glm::dot(d, frame_.n);
  const float t = -glm::dot(from, frame_.n) / speed;
  if (!(t > 0 && t < kInfinity)) return 0;
  const Vec3 p = from + t * d;
  const Vec2 local = Vec2(glm::dot(p, frame_.s), glm::dot(p, frame_.t)) / half_extent_;
  if (!(std::abs(local.x) < 1 && std::abs(local.y) < 1)) return 0;
  out[count++] = {0.5f * local + 0.5f, speed < 0};
  return count;
}

// ---- ProbeGrid

ProbeGrid::ProbeGrid(const std::vector<Vec2>& points) : weights_(kSide * kSide) {
  const auto count = static_cast<float>(points.size());
  const float uniform = (points.empty() ? 1.f : 0.5f) / (kSide * kSide);
  std::fill(weights_.begin(), weights_.end(), uniform);
  for (const Vec2& p : points) {
    const auto x = std::min(static_cast<uint32_t>(p.x * kSide), kSide - 1);
    const auto y = std::min(static_cast<uint32_t>(p.y * kSide), kSide - 1);
    weights_[y * kSide + x] += 0.5f / count;
  }
  cells_ = GridDistribution(kSide, kSide, weights_);
}

ProbeGrid::Sample ProbeGrid::sample(Random& random) const {
  const GridDistribution::Cell cell = cells_.sample(random.unit2());
  const Vec2 corner(static_cast<float>(cell.column), static_cast<float>(cell.row));
  const double weight = double{weights_[cell.row * kSide + cell.column]};
  return {(corner + cell.u) / static_cast<float>(kSide),
          weight * (kSide * kSide) / cells_.total()};
}

// ---- ReceiverCells

ReceiverCells::ReceiverCells(const std::vector<Hit>& probes, double expected) {
  constexpr double kMinHits = 500;
  constexpr int kMaxParts = 16;
  std::vector<Vec2> sides[2];
  for (const Hit& hit : probes) sides[hit.is_front].push_back(hit.uv);
  const bool is_front = sides[1].size() >= sides[0].size();
  for (const bool side : {is_front, !is_front}) {
    std::vector<Vec2>& points = sides[side];
    const double share = probes.empty() ? 0
                                        : static_cast<double>(points.size()) /
                                              static_cast<double>(probes.size());
    const int parts =
        std::clamp(static_cast<int>(expected * share / kMinHits), 0, kMaxParts);
    if (parts == 0 && side != is_front) {
      roots_[side] = roots_[!side];  // too few hits: use the cells of the other side
    } else {
      roots_[side] = divide(points, 0, points.size(), std::max(parts, 1), 0);
    }
  }
}

size_t ReceiverCells::divide(std::vector<Vec2>& points, size_t first, size_t last, int parts,
                             int depth) {
  const size_t index = nodes_.size();
  nodes_.emplace_back();
  if (parts < 2 || last - first < 2) {
    nodes_[index].cell = count_++;
    return index;
  }
  const int axis = depth % 2;
  const auto begin = points.begin();
  const size_t middle = (first + last) / 2;
  std::nth_element(begin + static_cast<long>(first), begin + static_cast<long>(middle),
                   begin + static_cast<long>(last),
                   [axis](const Vec2& a, const Vec2& b) { return a[axis] < b[axis]; });
  const float at = points[middle][axis];
  const size_t lower = divide(points, first, middle, parts / 2, depth + 1);
  const size_t upper = divide(points, middle, last, parts / 2, depth + 1);
  nodes_[index] = {axis, at, 0, lower, upper};
  return index;
}

size_t ReceiverCells::cell_of(const Vec2& uv, bool is_front) const {
  size_t node = roots_[is_front];
  while (nodes_[node].axis >= 0) {
    const Node& n = nodes_[node];
    node = uv[n.axis] < n.middle ? n.lower : n.upper;
  }
  return nodes_[node].cell;
}

// ---- CellFlux

void CellFlux::add(size_t cell, const Rgb& flux) {
  current_.emplace_back(cell, double{luminance(flux)});
  current_channels_ += glm::dvec3(flux);
  ++contributions_;
}

void CellFlux::end_sample() {
  ++samples_;
  for (size_t i = 0; i < current_.size(); ++i) {
    const auto [cell, value] = current_[i];
    sums_[cell] += value;
    squares_[cell] += value * value;
    for (size_t k = 0; k < i; ++k) {
      if (current_[k].first == cell) squares_[cell] += 2 * value * current_[k].second;
    }
  }
  for (int c = 0; c < 3; ++c) channels_[c].add(current_channels_[c]);
  current_.clear();
  current_channels_ = glm::dvec3(0.);
}

std::vector<Estimate> CellFlux::estimates() const {
  const auto n = static_cast<double>(samples_);
  std::vector<Estimate> all;
  for (size_t i = 0; i < sums_.size(); ++i) {
    const double mean = sums_[i] / n;
    all.push_back({mean, std::max(0., squares_[i] / n - mean * mean) / n});
  }
  for (const Moments& channel : channels_) {
    all.push_back({channel.mean(), channel.variance_of_mean()});
  }
  return all;
}

double CellFlux::total() const {
  return channels_[0].mean() + channels_[1].mean() + channels_[2].mean();
}

}  // namespace kinome::check
