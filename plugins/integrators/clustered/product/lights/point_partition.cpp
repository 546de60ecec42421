#include "clustered/product/lights/point_partition.h"

#include <algorithm>
#include <numeric>
#include <queue>

namespace kinome {
namespace {

/// Distance that a turn of the normal by a right angle is worth, relative to the scene's size.
constexpr float kNormalShare = 0.15f;
/// Flux that is added to each point, relative to the mean flux. Prevents cells whose points all
/// have no flux and couldn't be split.
constexpr float kFluxFloor = 1e-3f;

}  // namespace

PointPartition::Coordinates PointPartition::coordinates(const OrientedPoint& point) const {
  const Vec3 n = point.normal * normal_scale_;
  return {point.position.x, point.position.y, point.position.z, n.x, n.y, n.z};
}

/// Splits leaves by priority. Each leaf owns a range of `order`.
struct PointPartition::Builder {
  struct Leaf {
    double priority;
    uint32_t node, begin, end;
    int axis;
    float split;
    bool operator<(const Leaf& other) const {
      return priority != other.priority ? priority < other.priority : node > other.node;
    }
  };
  std::vector<Coordinates> points;
  std::vector<float> flux;
  std::vector<uint32_t> order;
  std::vector<Node>& nodes;
  std::priority_queue<Leaf> leaves;

  void add(uint32_t node, uint32_t begin, uint32_t end) {
    double sum = 0, mean[kAxes] = {}, squares[kAxes] = {};
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t k = order[i];
      sum += flux[k];
      for (int a = 0; a < kAxes; ++a) mean[a] += flux[k] * static_cast<double>(points[k][a]);
    }
    double variance = 0, widest = 0;
    int axis = -1;
    for (int a = 0; a < kAxes; ++a) {
      mean[a] /= sum;
      for (uint32_t i = begin; i < end; ++i) {
        const double d = points[order[i]][a] - mean[a];
        squares[a] += flux[order[i]] * d * d;
      }
      squares[a] /= sum;
      variance += squares[a];
      if (squares[a] > widest) {
        widest = squares[a];
        axis = a;
      }
    }
    Leaf leaf{sum * variance, node, begin, end, axis, 0};
    if (axis >= 0) leaf.split = static_cast<float>(mean[axis]);
    leaves.push(leaf);
  }

  /// Returns false if the leaf can't be split, because its points differ only by rounding.
  bool split(const Leaf& leaf) {
    if (leaf.axis < 0) return false;
    const auto middle =
        std::partition(order.begin() + leaf.begin, order.begin() + leaf.end,
                       [&](uint32_t k) { return points[k][leaf.axis] < leaf.split; });
    const auto at = static_cast<uint32_t>(middle - order.begin());
    if (at == leaf.begin || at == leaf.end) return false;
    const auto below = static_cast<uint32_t>(nodes.size());
    nodes.resize(nodes.size() + 2);
    nodes[leaf.node].axis = static_cast<int16_t>(leaf.axis);
    nodes[leaf.node].split = leaf.split;
    nodes[leaf.node].below = below;
    nodes[leaf.node].above = below + 1;
    add(below, leaf.begin, at);
    add(below + 1, at, leaf.end);
    return true;
  }
};

PointPartition::PointPartition(std::span<const OrientedPoint> points, std::span<const float> flux,
                               uint32_t count) {
  if (points.empty() || count == 0) return;
  Aabb box;
  for (const OrientedPoint& p : points) box.expand(p.position);
  normal_scale_ = kNormalShare * max_component(box.extent());
  if (!(normal_scale_ > 0)) normal_scale_ = 1;
  nodes_.resize(1);
  Builder builder{{}, {flux.begin(), flux.end()}, {}, nodes_, {}};
  builder.points.reserve(points.size());
  for (const OrientedPoint& p : points) builder.points.push_back(coordinates(p));
  builder.order.resize(points.size());
  std::iota(builder.order.begin(), builder.order.end(), 0u);
  double sum = 0;
  for (const float f : flux) sum += f;
  const auto floor =
      static_cast<float>(sum > 0 ? kFluxFloor * sum / static_cast<double>(points.size()) : 1.);
  for (float& f : builder.flux) f += floor;
  builder.add(0, 0, static_cast<uint32_t>(points.size()));
  for (uint32_t leaves = 1; leaves < count && !builder.leaves.empty();) {
    const auto leaf = builder.leaves.top();
    builder.leaves.pop();
    if (builder.split(leaf)) ++leaves;
  }
  number(0);
}

void PointPartition::number(uint32_t root) {
  std::vector<uint32_t> stack{root};
  while (!stack.empty()) {
    Node& node = nodes_[stack.back()];
    stack.pop_back();
    if (node.axis < 0) {
      node.cell = size_++;
    } else {
      stack.push_back(node.above);
      stack.push_back(node.below);
    }
  }
}

uint32_t PointPartition::cell_of(const OrientedPoint& point) const {
  const Coordinates at = coordinates(point);
  uint32_t i = 0;
  while (nodes_[i].axis >= 0) {
    i = at[nodes_[i].axis] < nodes_[i].split ? nodes_[i].below : nodes_[i].above;
  }
  return nodes_[i].cell;
}

}  // namespace kinome
