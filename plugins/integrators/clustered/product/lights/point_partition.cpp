#include "clustered/product/lights/point_partition.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <queue>
#include <utility>

#include "kinome/scheduler.h"

namespace kinome {
namespace {

/// Distance that a turn of the normal by a right angle is worth, relative to the scene's size.
constexpr float kNormalShare = 0.15f;
/// Flux that is added to each point, relative to the mean flux. Prevents cells whose points all
/// have no flux and couldn't be split.
constexpr float kFluxFloor = 1e-3f;
/// Number of ranges from which on each thread halves its own ranges, and minimum number of points
/// of a range that is halved before it is known whether its halves are needed.
constexpr size_t kMinRanges = 16;
constexpr uint32_t kMinPointsOfRange = 32;

}  // namespace

PointPartition::Coordinates PointPartition::coordinates(const OrientedPoint& point) const {
  const Vec3 n = point.normal * normal_scale_;
  return {point.position.x, point.position.y, point.position.z, n.x, n.y, n.z};
}

/// Halves ranges of points, of which the tree's leaves are made.
struct PointPartition::Builder {
  /// Coordinates of a point, with zeros up to a number of lanes that compilers vectorise.
  static constexpr int kLanes = 8;
  struct alignas(kLanes * sizeof(float)) Row {
    float at[kLanes];
  };
  /// Points whose indices are `order[begin]` to `order[end - 1]`.
  struct Range {
    double priority = 0;
    uint32_t begin = 0, end = 0;
    int axis = -1;  ///< along which it is halved at `split`; -1: its points differ only by rounding
    float split = 0;
    std::unique_ptr<std::array<Range, 2>> halves;  ///< below and above `split`; nullptr: none yet
  };
  std::vector<Row> points;
  std::vector<float> flux;
  std::vector<uint32_t> order;

  Range measured(uint32_t begin, uint32_t end) const {
    double sum = 0, mean[kLanes] = {}, squares[kLanes] = {};
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t k = order[i];
      sum += flux[k];
      for (int a = 0; a < kLanes; ++a) mean[a] += flux[k] * static_cast<double>(points[k].at[a]);
    }
    for (double& m : mean) m /= sum;
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t k = order[i];
      for (int a = 0; a < kLanes; ++a) {
        const double d = points[k].at[a] - mean[a];
        squares[a] += flux[k] * d * d;
      }
    }
    Range range;
    range.begin = begin, range.end = end;
    double variance = 0, widest = 0;
    for (int a = 0; a < kAxes; ++a) {
      squares[a] /= sum;
      variance += squares[a];
      if (squares[a] > widest) {
        widest = squares[a];
        range.axis = a;
      }
    }
    if (range.axis >= 0) range.split = static_cast<float>(mean[range.axis]);
    range.priority = sum * variance;
    return range;
  }

  /// Makes the halves of a range that has none, if possible.
  void halve(Range& range) {
    if (range.axis < 0 || range.halves) return;
    const auto middle =
        std::partition(order.begin() + range.begin, order.begin() + range.end,
                       [&](uint32_t k) { return points[k].at[range.axis] < range.split; });
    const auto at = static_cast<uint32_t>(middle - order.begin());
    if (at == range.begin || at == range.end) {
      range.axis = -1;
      return;
    }
    range.halves = std::make_unique<std::array<Range, 2>>(
        std::array<Range, 2>{measured(range.begin, at), measured(at, range.end)});
  }

  /// Halves a range, and its halves in turn, down to ranges of `least` points.
  void halve_all(Range& range, uint32_t least) {
    if (range.end - range.begin <= least) return;
    halve(range);
    if (!range.halves) return;
    for (Range& half : *range.halves) halve_all(half, least);
  }

  /// Makes the same halves by several threads. Halves depend on their range alone.
  void halve_all(Range& root, uint32_t least, const Scheduler& scheduler) {
    std::vector<Range*> level{&root};
    while (!level.empty() && level.size() < kMinRanges) {
      scheduler.parallel_for(level.size(), [&](size_t i) {
        if (level[i]->end - level[i]->begin > least) halve(*level[i]);
      });
      std::vector<Range*> next;
      for (Range* const range : level) {
        if (range->halves) next.insert(next.end(), {&(*range->halves)[0], &(*range->halves)[1]});
      }
      level = std::move(next);
    }
    scheduler.parallel_for(level.size(), [&](size_t i) { halve_all(*level[i], least); });
  }
};

PointPartition::PointPartition(std::span<const OrientedPoint> points, std::span<const float> flux,
                               uint32_t count, const Scheduler* scheduler,
                               std::vector<uint32_t>* cells) {
  if (points.empty() || count == 0) return;
  Aabb box;
  for (const OrientedPoint& p : points) box.expand(p.position);
  normal_scale_ = kNormalShare * max_component(box.extent());
  if (!(normal_scale_ > 0)) normal_scale_ = 1;
  nodes_.resize(1);
  const auto size = static_cast<uint32_t>(points.size());
  Builder builder{std::vector<Builder::Row>(size), {flux.begin(), flux.end()}, {}};
  for (uint32_t i = 0; i < size; ++i) {
    const Coordinates at = coordinates(points[i]);
    std::copy(at.begin(), at.end(), builder.points[i].at);
  }
  builder.order.resize(size);
  std::iota(builder.order.begin(), builder.order.end(), 0u);
  double sum = 0;
  for (const float f : flux) sum += f;
  const auto floor = static_cast<float>(sum > 0 ? kFluxFloor * sum / size : 1.);
  for (float& f : builder.flux) f += floor;
  Builder::Range root = builder.measured(0, size);
  if (scheduler) {
    builder.halve_all(root, std::max(size / count, kMinPointsOfRange), *scheduler);
  }
  /// Leaf of the tree so far. The one with the highest priority is split next.
  struct Leaf {
    Builder::Range* range;
    uint32_t node;
    bool operator<(const Leaf& other) const {
      return range->priority != other.range->priority ? range->priority < other.range->priority
                                                      : node > other.node;
    }
  };
  std::priority_queue<Leaf> leaves;
  leaves.push({&root, 0});
  std::vector<const Builder::Range*> range_of{&root};  // of each node
  for (uint32_t made = 1; made < count && !leaves.empty();) {
    const Leaf leaf = leaves.top();
    leaves.pop();
    builder.halve(*leaf.range);
    if (!leaf.range->halves) continue;
    const auto below = static_cast<uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    Node& node = nodes_[leaf.node];
    node.axis = static_cast<int16_t>(leaf.range->axis);
    node.split = leaf.range->split;
    node.below = below;
    node.above = below + 1;
    for (uint32_t half = 0; half < 2; ++half) {
      range_of.push_back(&(*leaf.range->halves)[half]);
      leaves.push({&(*leaf.range->halves)[half], below + half});
    }
    ++made;
  }
  number_cells();
  if (!cells) return;
  cells->resize(size);
  for (size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].axis >= 0) continue;
    for (uint32_t k = range_of[i]->begin; k < range_of[i]->end; ++k) {
      (*cells)[builder.order[k]] = nodes_[i].cell;
    }
  }
}

void PointPartition::number_cells() {
  std::vector<uint32_t> stack{0};
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
