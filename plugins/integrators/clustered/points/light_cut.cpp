#include "clustered/points/light_cut.h"

#include <algorithm>

#include "clustered/kernels/cluster_kernels.h"
#include "transport/blocks/arena.h"

namespace kinome {
namespace {

/// Bounds of boxes that no ray hits, for the padding of the last group of each level.
constexpr float kInvertedLo = 1e20f;
constexpr float kInvertedHi = -1e20f;

simd::BoxTree make_box_tree(const std::vector<LightCell>& cells) {
  constexpr size_t kFanOut = simd::kFanOut;
  std::vector<Aabb> boxes;
  for (const LightCell& cell : cells) boxes.push_back(cell.box);
  simd::BoxTree tree;
  do {
    tree.level_start.push_back(static_cast<uint32_t>(tree.groups.size() / (6 * kFanOut)));
    std::vector<Aabb> parents((boxes.size() + kFanOut - 1) / kFanOut);
    for (size_t group = 0; group < parents.size(); ++group) {
      const size_t first = group * kFanOut;
      const size_t count = std::min(kFanOut, boxes.size() - first);
      for (int axis = 0; axis < 3; ++axis) {
        for (size_t i = 0; i < kFanOut; ++i) {
          tree.groups.push_back(i < count ? boxes[first + i].lo[axis] : kInvertedLo);
        }
        for (size_t i = 0; i < kFanOut; ++i) {
          tree.groups.push_back(i < count ? boxes[first + i].hi[axis] : kInvertedHi);
        }
      }
      for (size_t i = 0; i < count; ++i) parents[group].expand(boxes[first + i]);
    }
    boxes = std::move(parents);
  } while (boxes.size() > 1);
  return tree;
}

/// Selects one of a cell's points uniformly (4.3.3). Returns its offset from the first one.
uint32_t offset_in(const LightCell& cell, float u) {
  const auto offset = static_cast<uint32_t>(u * static_cast<float>(cell.count));
  return std::min(offset, cell.count - 1);
}

/// Adds a point to the selection's last group, which begins at `group`. Merges it with an equal
/// point. Searches only the last few, so that merging in a large cluster costs less than it saves.
void add_merged(uint32_t point, float weight, size_t group, PointSelection& selection) {
  constexpr size_t kMaxSearchedPoints = 16;
  const size_t size = selection.points.size();
  for (size_t i = std::max(group, size - std::min(size, kMaxSearchedPoints)); i < size; ++i) {
    if (selection.points[i] == point) {
      selection.weights[i] += weight;
      return;
    }
  }
  selection.points.push_back(point);
  selection.weights.push_back(weight);
}

/// Sorts numbers in [0, 1) into as many buckets, which stratified numbers fill evenly, and then by
/// insertion.
void sort_by_x(std::span<const Vec2> u, std::vector<Vec2>& sorted) {
  const size_t n = u.size();
  const auto bucket = [n](const Vec2& v) {
    return std::min(static_cast<size_t>(v.x * static_cast<float>(n)), n - 1);
  };
  thread_local std::vector<uint32_t> end;
  end.assign(n + 1, 0);
  for (const Vec2& v : u) ++end[bucket(v) + 1];
  for (size_t i = 1; i <= n; ++i) end[i] += end[i - 1];
  sorted.resize(n);
  for (const Vec2& v : u) sorted[end[bucket(v)]++] = v;
  for (size_t i = 1; i < n; ++i) {
    const Vec2 v = sorted[i];
    size_t k = i;
    for (; k > 0 && sorted[k - 1].x > v.x; --k) sorted[k] = sorted[k - 1];
    sorted[k] = v;
  }
}

/// Returns the sine of the half angle of the cone around cell.normal that contains the normals of
/// all its points; 1 from a right angle on.
float cone_sine(const LightCell& cell, const std::vector<Vec3>& normals) {
  float cosine = 1;
  for (uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
    cosine = std::min(cosine, glm::dot(cell.normal, normals[i]));
  }
  if (!(cosine > 0)) return 1;
  // Rounded up: a cosine's error of 1e-6 near 1 is one of 1e-3 in the sine.
  return std::min(1.f, std::sqrt(std::max(0.f, 1 - cosine * cosine) + 2e-6f));
}

}  // namespace

struct LightCut::Arrays {
  uint32_t rows;
  transport::Arena arena;
  Columns3 mean, lo, hi;
  float *light, *extent, *inverse_extent;
  /// Columns of local light; the padding has harmless values.
  Columns3 half, normal;
  float *sine, *inverse_one_plus_sine, *reach, *min_distance2;
  float unit_area = 1;
  simd::BoxTree boxes;
  std::vector<uint32_t> position;  ///< position of each cluster in the columns' layout

  Arrays(const std::vector<LightCell>& cells, const LightPoints& points)
      : rows(static_cast<uint32_t>(padded(cells.size()) / kBlockLanes)),
        arena(cells.size()),
        mean(arena.three()),
        lo(arena.three()),
        hi(arena.three()),
        light(arena.floats()),
        extent(arena.floats()),
        inverse_extent(arena.floats()),
        boxes(make_box_tree(cells)),
        position(cells.size()) {
    double light_sum = 0, extent_sum = 0;
    for (const LightCell& cell : cells) {
      light_sum += cell.weight;
      extent_sum += cell.extent;
    }
    for (uint32_t c = 0; c < cells.size(); ++c) {
      const LightCell& cell = cells[c];
      const size_t i = position[c] = static_cast<uint32_t>((c % rows) * kBlockLanes + c / rows);
      mean.set(i, cell.mean);
      lo.set(i, cell.box.lo);
      hi.set(i, cell.box.hi);
      // Normalised, so that radiances of 1e-30 or 1e30 neither vanish nor overflow. Never rounded
      // to 0 if there is light.
      light[i] = relative_weight(cell.weight, light_sum);
      extent[i] = relative_weight(cell.extent, extent_sum);
      inverse_extent[i] = 1.f / cell.extent;
    }
    if (points.kind == LightPoints::Kind::kLocal) add_local(cells, points.normal);
  }

  void add_local(const std::vector<LightCell>& cells, const std::vector<Vec3>& normals) {
    half = arena.three(), normal = arena.three();
    for (float** const column : {&sine, &inverse_one_plus_sine, &reach, &min_distance2}) {
      *column = arena.floats();
      std::fill_n(*column, arena.capacity(), 1.f);
    }
    Aabb bounds;
    for (const LightCell& cell : cells) bounds.expand(cell.box);
    // Squared distances and areas are relative to the bounding box, so that scene size doesn't
    // matter.
    unit_area = glm::dot(bounds.extent(), bounds.extent());
    for (uint32_t c = 0; c < cells.size(); ++c) {
      const size_t i = position[c];
      const LightCell& cell = cells[c];
      const Vec3 around = glm::max(cell.box.hi - cell.mean, cell.mean - cell.box.lo);
      half.set(i, around);
      normal.set(i, cell.normal);
      const float radius = 0.5f * glm::length(cell.box.extent());
      sine[i] = cone_sine(cell, normals);
      inverse_one_plus_sine[i] = 1 / (1 + sine[i]);
      reach[i] = glm::dot(glm::abs(cell.normal), around) + sine[i] * glm::length(around);
      min_distance2[i] = 0.25f * radius * radius;
      inverse_extent[i] *= unit_area;
    }
  }

  static float relative_weight(float weight, double sum) {
    return weight > 0 ? std::max(static_cast<float>(weight / sum), 1e-30f) : 0.f;
  }
};

LightCut::LightCut(const LightTree& tree, uint32_t size, CutCriterion criterion)
    : kind_(tree.points().kind) {
  for (const uint32_t cell : select_cut(tree, std::max(size, 1u), criterion)) {
    cells_.push_back(tree.cells()[cell]);
  }
  arrays_ = std::make_unique<Arrays>(cells_, tree.points());
}

LightCut::~LightCut() = default;

void LightCut::layout(ClusterPmf& pmf) const {
  pmf.size_ = size();
  pmf.rows_ = arrays_->rows;
  pmf.columns_.resize(arrays_->arena.capacity());
}

std::span<const float> LightCut::luminances() const {
  return {arrays_->light, arrays_->arena.capacity()};
}

std::span<const float> LightCut::extents() const {
  return {arrays_->extent, arrays_->arena.capacity()};
}

void LightCut::weigh_reflected(std::span<const float> weights, const Point& point,
                               ClusterPmf& pmf) const {
  static_assert(ClusterPmf::kLanes == kBlockLanes);
  layout(pmf);
  const Arrays& a = *arrays_;
  const simd::ClusterColumns clusters{a.rows,
                                      {a.mean.x, a.mean.y, a.mean.z},
                                      {a.lo.x, a.lo.y, a.lo.z},
                                      {a.hi.x, a.hi.y, a.hi.z},
                                      weights.data(),
                                      a.inverse_extent};

  simd::ImportanceQuery query;
  for (int axis = 0; axis < 3; ++axis) query.normal[axis] = point.normal[axis];
  query.diffuse = point.diffuse * kInvPi;
  const float per_sample = point.glossy / static_cast<float>(point.lobe.count + 1);
  query.glossy_floor = per_sample * (0.5f * kInvPi);
  pmf.hits_.clear();
  if (point.lobe.count > 0) {
    pmf.hits_.assign(pmf.columns_.size(), 0.f);
    // Distant light: a lobe ray hits a cluster's box only near the sphere of unit directions, not
    // boxes elsewhere along the ray. Local light: at any distance (4.2.2).
    const bool local = kind_ == LightPoints::Kind::kLocal;
    simd::LobeRays rays{{0, 0, 0},       local ? 0 : 1 - 1e-4f, local ? 1e30f : 1 + 1e-4f,
                        point.lobe.x,    point.lobe.y,          point.lobe.z,
                        point.lobe.count};
    for (int axis = 0; axis < 3 && local; ++axis) rays.origin[axis] = point.position[axis];
    simd::count_box_hits(a.boxes, rays, a.position.data(), pmf.hits_.data());
    query.glossy_hit = per_sample;
    query.hits = pmf.hits_.data();
  }
  std::array<float, kBlockLanes> lane_sums{};
  if (kind_ == LightPoints::Kind::kLocal) {
    const simd::LocalColumns local{{a.half.x, a.half.y, a.half.z},
                                   {a.normal.x, a.normal.y, a.normal.z},
                                   a.sine,
                                   a.inverse_one_plus_sine,
                                   a.reach,
                                   a.min_distance2};
    for (int axis = 0; axis < 3; ++axis) query.position[axis] = point.position[axis];
    query.unit_area = a.unit_area;
    simd::local_cluster_importance(clusters, local, query, pmf.columns_.data(), lane_sums.data());
  } else {
    simd::cluster_importance(clusters, query, pmf.columns_.data(), lane_sums.data());
  }
  for (uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    pmf.lane_start_[lane + 1] = pmf.lane_start_[lane] + lane_sums[lane];
  }
  pmf.total_ = pmf.lane_start_[kBlockLanes];
}

void LightCut::weigh(std::span<const float> weights, ClusterPmf& pmf) const {
  layout(pmf);
  const auto lit = std::count_if(weights.begin(), weights.end(), [](float w) { return w > 0; });
  const float even = simd::kEvenShare / static_cast<float>(std::max<std::ptrdiff_t>(lit, 1));
  for (uint32_t lane = 0; lane < kBlockLanes; ++lane) {
    float sum = 0;
    for (uint32_t row = 0; row < pmf.rows_; ++row) {
      const size_t i = row * kBlockLanes + lane;
      if (weights[i] > 0) sum += weights[i] + even;
      pmf.columns_[i] = sum;
    }
    pmf.lane_start_[lane + 1] = pmf.lane_start_[lane] + sum;
  }
  pmf.total_ = pmf.lane_start_[kBlockLanes];
}

void LightCut::sample_points(const ClusterPmf& pmf, std::span<const Vec2> u,
                             PointSelection& selection) const {
  if (pmf.empty() || u.empty()) return;
  thread_local std::vector<Vec2> sorted;
  sort_by_x(u, sorted);
  // With sorted numbers, one traversal of the running sums finds all clusters.
  const float inverse_count = 1.f / static_cast<float>(u.size());
  uint32_t lane = 0, row = 0, cluster = ~0u;
  float weight = 0;
  size_t group = 0;  // where this cluster's points begin in the selection
  for (const Vec2& number : sorted) {
    const float target = number.x * pmf.total_;
    const uint32_t next_lane = pmf.lane_of(target, lane);
    if (next_lane != lane) row = 0;
    lane = next_lane;
    const float in_lane = target - pmf.lane_start_[lane];
    const float* const column = pmf.columns_.data() + lane;
    while (row < pmf.rows_ && column[row * ClusterPmf::kLanes] <= in_lane) ++row;
    // Rounding moved the target past the end: takes the last entry of positive probability.
    if (row == pmf.rows_) row = pmf.last_row(lane);
    if (lane * pmf.rows_ + row != cluster) {
      cluster = lane * pmf.rows_ + row;
      weight = static_cast<float>(cells_[cluster].count) / pmf.probability(cluster) * inverse_count;
      group = selection.points.size();
    }
    add_merged(cells_[cluster].first + offset_in(cells_[cluster], number.y), weight, group,
               selection);
  }
}

uint32_t LightCut::cluster_of(uint32_t point) const {
  // Clusters are in the order of their points.
  const auto after =
      std::upper_bound(cells_.begin(), cells_.end(), point,
                       [](uint32_t p, const LightCell& cell) { return p < cell.first; });
  return static_cast<uint32_t>(after - cells_.begin()) - 1;
}

float LightCut::point_probability(const ClusterPmf& pmf, uint32_t point) const {
  const uint32_t cluster = cluster_of(point);
  return pmf.probability(cluster) / static_cast<float>(cells_[cluster].count);
}

uint32_t ClusterPmf::lane_of(float target, uint32_t first) const {
  uint32_t lane = first;
  for (uint32_t l = first; l < kLanes && lane_start_[l] <= target; ++l) {
    if (lane_start_[l + 1] > lane_start_[l]) lane = l;
  }
  return lane;
}

uint32_t ClusterPmf::last_row(uint32_t lane) const {
  uint32_t row = rows_ - 1;
  while (row > 0 && columns_[row * kLanes + lane] == columns_[(row - 1) * kLanes + lane]) --row;
  return row;
}

float ClusterPmf::probability(uint32_t c) const {
  const size_t i = position(c);
  const float below = i >= kLanes ? columns_[i - kLanes] : 0.f;
  return (columns_[i] - below) / total_;
}

float ClusterPmf::hits(uint32_t c) const {
  return hits_.empty() ? 0.f : hits_[position(c)];
}

}  // namespace kinome
