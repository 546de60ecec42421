#include "clustered/kernels/cluster_kernels.h"

#include <cmath>

#include "clustered/kernels/cluster_formulas.h"

namespace kinome::simd {
namespace {

using namespace wide;

struct RaySlabs {
  float origin[3];
  float t_min, t_max;
  float inverse[3];
  size_t near[3];  ///< offset in a group of the bounds that the ray reaches first
  size_t far[3];
};

RaySlabs make_slabs(const LobeRays& rays, size_t i) {
  constexpr float kTiny = 1e-12f;  // keeps 0 * infinity out of the slabs
  const float direction[3] = {rays.dx[i], rays.dy[i], rays.dz[i]};
  RaySlabs ray;
  ray.t_min = rays.t_min;
  ray.t_max = rays.t_max;
  for (size_t axis = 0; axis < 3; ++axis) {
    const float v = direction[axis];
    const bool negative = std::signbit(v);
    ray.origin[axis] = rays.origin[axis];
    ray.inverse[axis] = 1.f / (std::abs(v) > kTiny ? v : std::copysign(kTiny, v));
    ray.near[axis] = (2 * axis + (negative ? 1 : 0)) * kFanOut;
    ray.far[axis] = (2 * axis + (negative ? 0 : 1)) * kFanOut;
  }
  return ray;
}

/// Writes the indices of the group's boxes that the ray intersects to `met`, and returns their
/// number. `first` is the index of the group's first box. `met` needs space for all boxes and one
/// more vector. Bounds are ordered by the direction's sign, so that inverted boxes are never hit.
size_t find_met(const float* group, const RaySlabs& ray, uint32_t first, uint32_t* met) {
  size_t count = 0;
  for (size_t k = 0; k < kFanOut; k += kLanes) {
    Float near = ray.t_min, far = ray.t_max;
    for (int axis = 0; axis < 3; ++axis) {
      const float o = ray.origin[axis], inverse = ray.inverse[axis];
      near = max(near, (Float::load(group + ray.near[axis] + k) - o) * inverse);
      far = min(far, (Float::load(group + ray.far[axis] + k) - o) * inverse);
    }
    const Uint box = as_uint(iota() + static_cast<int32_t>(first + k));
    count += store_selected(near <= far, box, met + count);
  }
  return count;
}

}  // namespace

float cluster_importance(const ClusterColumns& clusters, const ImportanceQuery& query,
                         float* columns, float* lane_sums) {
  return sum_importances<Float>(DistantImportance<Float>{clusters, query}, clusters.rows, columns,
                                lane_sums);
}

float local_cluster_importance(const ClusterColumns& clusters, const LocalColumns& local,
                               const ImportanceQuery& query, float* columns, float* lane_sums) {
  return sum_importances<Float>(LocalImportance<Float>{clusters, local, query}, clusters.rows,
                                columns, lane_sums);
}

void count_box_hits(const BoxTree& tree, const LobeRays& rays, const uint32_t* position,
                    float* hits) {
  constexpr size_t kGroup = 6 * kFanOut;
  struct Entry {
    uint32_t level, group;
  };
  // Depth first: at most kFanOut - 1 siblings wait on each level, and 8 levels hold 2^32 boxes.
  Entry stack[8 * kFanOut];
  const auto top = static_cast<uint32_t>(tree.level_start.size() - 1);
  for (size_t i = 0; i < rays.count; ++i) {
    const RaySlabs ray = make_slabs(rays, i);
    size_t depth = 0;
    stack[depth++] = {top, 0};
    while (depth > 0) {
      const Entry entry = stack[--depth];
      const size_t group = tree.level_start[entry.level] + entry.group;
      uint32_t met[kFanOut + kLanes];
      const size_t count = find_met(tree.groups.data() + group * kGroup, ray,
                                    entry.group * static_cast<uint32_t>(kFanOut), met);
      for (size_t k = 0; k < count; ++k) {
        if (entry.level == 0) {
          hits[position[met[k]]] += 1;
        } else {
          stack[depth++] = {entry.level - 1, met[k]};
        }
      }
    }
  }
}

}  // namespace kinome::simd
