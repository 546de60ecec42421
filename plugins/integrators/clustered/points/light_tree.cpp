#include "clustered/points/light_tree.h"

#include <numeric>
#include <queue>
#include <string>
#include <tuple>

#include "kinome/error.h"

namespace kinome {
namespace {

Vec3 normalized_or_zero(const Vec3& v) {
  const float length = glm::length(v);
  return length > 1e-6f ? v / length : Vec3(0.f);
}

template <class T>
void permute(std::vector<T>& values, const std::vector<uint32_t>& order) {
  if (values.empty()) return;
  std::vector<T> permuted(values.size());
  for (size_t i = 0; i < order.size(); ++i) permuted[i] = values[order[i]];
  values = std::move(permuted);
}

/// Sums over a cell's points, from the leaves up, in double precision: sums of 2^22 very different
/// powers must not lose the small ones.
struct Sums {
  double weight = 0;
  double extent = 0;
  double squared_deviation = 0;
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0};
  Aabb box;
};

Sums merge(const Sums& a, uint32_t count_a, const Sums& b, uint32_t count_b) {
  Sums sums{a.weight + b.weight,     a.extent + b.extent, 0,
            a.position + b.position, a.normal + b.normal, a.box};
  sums.box.expand(b.box);
  // Chan et al. 1979: pairwise update of the squared deviations, free of cancellation.
  const double delta = b.weight / count_b - a.weight / count_a;
  sums.squared_deviation = a.squared_deviation + b.squared_deviation +
                           delta * delta * count_a * count_b / (count_a + count_b);
  return sums;
}

class Builder {
 public:
  Builder(const LightPoints& points, std::vector<LightCell>& cells)
      : points_(points), cells_(cells), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    double total = 0;
    for (const Rgb& power : points.power) total += LightTree::weight_of(power);
    if (total > 0) deviation_scale_ = static_cast<double>(points.size()) / total;
    cells_.resize(2 * points.size() - 1);
    next_cell_ = 1;
    build(0, 0, static_cast<uint32_t>(points.size()));
  }
  const std::vector<uint32_t>& order() const { return order_; }

 private:
  Sums build(uint32_t cell, uint32_t first, uint32_t count) {
    uint32_t left = 0;
    Sums sums;
    if (count == 1) {
      sums = leaf_sums(order_[first]);
    } else {
      // Halves differ by at most one point, so that the leaves are on the last two levels.
      const uint32_t left_count = count / 2;
      partition(first, left_count, count);
      left = next_cell_;
      next_cell_ += 2;
      const Sums a = build(left, first, left_count);
      const Sums b = build(left + 1, first + left_count, count - left_count);
      sums = merge(a, left_count, b, count - left_count);
    }
    const bool distant = points_.kind == LightPoints::Kind::kDistant;
    LightCell& c = cells_[cell];
    c.box = sums.box;
    c.mean = Vec3(sums.position / static_cast<double>(count));
    if (distant) c.mean = normalized_or_zero(c.mean);
    c.normal = normalized_or_zero(Vec3(sums.normal / static_cast<double>(count)));
    c.weight = static_cast<float>(sums.weight);
    c.extent = static_cast<float>(sums.extent);
    c.variance = static_cast<float>(sums.squared_deviation * deviation_scale_ * deviation_scale_);
    c.first = first;
    c.count = count;
    c.left = left;
    return sums;
  }

  Sums leaf_sums(uint32_t point) const {
    Sums sums;
    sums.weight = LightTree::weight_of(points_.power[point]);
    sums.extent = points_.extent[point];
    sums.position = points_.position[point];
    // The box contains an area of the point's extent. Otherwise, no lobe ray would ever hit the box
    // of a single point (Åkerlund 2008, 4.2.2 counts rays that hit boxes). With a normal, the area
    // is a disk: its box must not rise above its plane, because it would seem to light other points
    // of the same floor.
    Vec3 reach(std::sqrt(points_.extent[point] / kPi));
    if (!points_.normal.empty()) {
      const Vec3 n = points_.normal[point];
      sums.normal = n;
      reach *= glm::sqrt(glm::max(1.f - n * n, 0.f));
    }
    sums.box = {points_.position[point] - reach, points_.position[point] + reach};
    return sums;
  }

  /// Moves the first left_count points along the box's longest axis to the front.
  void partition(uint32_t first, uint32_t left_count, uint32_t count) {
    Aabb box;
    for (uint32_t i = first; i < first + count; ++i) box.expand(points_.position[order_[i]]);
    const Vec3 extent = box.extent();
    int axis = 0;
    if (extent.y > extent[axis]) axis = 1;
    if (extent.z > extent[axis]) axis = 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + left_count, begin + count, [&](uint32_t a, uint32_t b) {
      const float x = points_.position[a][axis], y = points_.position[b][axis];
      return x != y ? x < y : a < b;  // any fixed order for equal coordinates
    });
  }

  const LightPoints& points_;
  std::vector<LightCell>& cells_;
  std::vector<uint32_t> order_;
  uint32_t next_cell_ = 0;
  double deviation_scale_ = 1;  ///< 1 / the mean weight
};

}  // namespace

void check_light_points(const LightPoints& points) {
  const size_t size = points.size();
  if (size == 0) throw Error("light points: none given");
  const bool local = points.kind == LightPoints::Kind::kLocal;
  if (points.power.size() != size || points.extent.size() != size ||
      points.normal.size() != (local ? size : 0) ||
      (!points.emission_id.empty() && points.emission_id.size() != size)) {
    throw Error("light points: the numbers of positions, powers, extents and normals differ");
  }
  if (!points.emission_id.empty() && (!local || !points.emission)) {
    throw Error("light points: emission_id requires local light points and an emission");
  }
  for (size_t i = 0; i < size; ++i) {
    if (!is_finite(points.position[i]) || !is_finite(points.power[i]) ||
        !(points.extent[i] > 0 && std::isfinite(points.extent[i]))) {
      throw Error("light points: number " + std::to_string(i) +
                  " has a position or power that is not finite, or no extent");
    }
  }
}

LightTree::LightTree(LightPoints points) : points_(std::move(points)) {
  check_light_points(points_);
  const Builder builder(points_, cells_);
  permute(points_.position, builder.order());
  permute(points_.normal, builder.order());
  permute(points_.power, builder.order());
  permute(points_.extent, builder.order());
  permute(points_.emission_id, builder.order());
}

std::vector<uint32_t> select_cut(const LightTree& tree, uint32_t size, CutCriterion criterion) {
  const std::vector<LightCell>& cells = tree.cells();
  struct Candidate {
    float criterion, weight, extent;
    uint32_t cell;
    bool operator<(const Candidate& other) const {
      // The heap returns the largest first; a smaller index counts as larger.
      return std::tie(criterion, weight, extent, other.cell) <
             std::tie(other.criterion, other.weight, other.extent, cell);
    }
  };
  const auto candidate = [&](uint32_t i) {
    const LightCell& c = cells[i];
    return Candidate{criterion == CutCriterion::kVariance ? c.variance : c.weight, c.weight,
                     c.extent, i};
  };
  std::priority_queue<Candidate> open;
  std::vector<uint32_t> cut;
  const auto place = [&](uint32_t i) {
    if (cells[i].left == 0) {
      cut.push_back(i);
    } else {
      open.push(candidate(i));
    }
  };
  place(0);
  while (!open.empty() && cut.size() + open.size() < size) {
    const uint32_t split = open.top().cell;
    open.pop();
    place(cells[split].left);
    place(cells[split].left + 1);
  }
  for (; !open.empty(); open.pop()) cut.push_back(open.top().cell);
  // In the tree's order of points, so that neighbours in the cut are neighbours in space.
  std::sort(cut.begin(), cut.end(),
            [&](uint32_t a, uint32_t b) { return cells[a].first < cells[b].first; });
  return cut;
}

}  // namespace kinome
