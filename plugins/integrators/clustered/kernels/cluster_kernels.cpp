#include "clustered/kernels/cluster_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clustered/kernels/cluster_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kLanes>;
using BoxTag = hn::CappedTag<float, kFanOut>;

/// Share of the best corner's cosine that a cluster's form factor has at least.
constexpr float kCornerShare = 0.25f;

/// A cluster's largest cosine to the normal, over the corners of its box (4.2.2: "as soon as one
/// corner is above the horizon"): separable, since each axis picks its corner alone.
template <class V>
V corner_term(V normal, V lo, V hi) {
  return hn::Max(hn::Mul(normal, lo), hn::Mul(normal, hi));
}

/// 1 / sqrt(x) for finite x > 0 to 1e-5: the machine's estimate and a Newton step, faster than a
/// root and a division. Estimates differ from one make of processor to another.
template <class V>
V inverse_sqrt(V x) {
  const Tag d;
  const V y = hn::ApproximateReciprocalSqrt(x);
  const V half = hn::Mul(hn::Mul(hn::Set(d, 0.5f), x), y);
  return hn::Mul(y, hn::NegMulAdd(half, y, hn::Set(d, 1.5f)));
}

/// One vector of clusters: how likely each is, and whether it can contribute at all.
template <class V, class M>
struct Importances {
  V value;
  M can_contribute;
};

/// Distant light: directions. G is the cosine at the shading point alone.
struct Distant {
  const ClusterColumns& c;
  const ImportanceQuery& q;

  auto operator()(Tag d, size_t i) const {
    const auto zero = hn::Zero(d);
    const auto nx = hn::Set(d, q.normal[0]);
    const auto ny = hn::Set(d, q.normal[1]);
    const auto nz = hn::Set(d, q.normal[2]);
    const auto corner =
        hn::Add(hn::Add(corner_term(nx, hn::LoadU(d, c.lo[0] + i), hn::LoadU(d, c.hi[0] + i)),
                        corner_term(ny, hn::LoadU(d, c.lo[1] + i), hn::LoadU(d, c.hi[1] + i))),
                corner_term(nz, hn::LoadU(d, c.lo[2] + i), hn::LoadU(d, c.hi[2] + i)));
    const auto cosine = hn::Add(
        hn::Add(hn::Mul(nx, hn::LoadU(d, c.mean[0] + i)), hn::Mul(ny, hn::LoadU(d, c.mean[1] + i))),
        hn::Mul(nz, hn::LoadU(d, c.mean[2] + i)));
    // The average direction may lie below the horizon while a part of the cluster is above; the
    // best corner then bounds the form factor.
    const auto form_factor = hn::Max(cosine, hn::Mul(hn::Set(d, kCornerShare), corner));
    auto brdf = hn::Set(d, q.diffuse + q.glossy_floor);
    if (q.hits != nullptr) {
      const auto density = hn::Mul(hn::LoadU(d, q.hits + i), hn::LoadU(d, c.inverse_extent + i));
      brdf = hn::Add(brdf, hn::Mul(hn::Set(d, q.glossy_hit), density));
    }
    const auto weight = hn::LoadU(d, c.weight + i);
    const auto possible = hn::And(hn::Gt(corner, zero), hn::Gt(weight, zero));
    return Importances<decltype(weight), decltype(possible)>{
        hn::Mul(hn::Mul(weight, form_factor), brdf), possible};
  }
};

/// Local light: positions with a cone of normals. G = cos cos' / r² (thesis 2.2), where each cosine
/// is that of the average, but no less than a share of the best that the box and the cone allow,
/// and r no less than half the box's radius: a cluster around the shading point stays finite.
struct Local {
  const ClusterColumns& c;
  const LocalColumns& l;
  const ImportanceQuery& q;

  auto operator()(Tag d, size_t i) const {
    using V = hn::Vec<Tag>;
    const V zero = hn::Zero(d);
    const V one = hn::Set(d, 1.f);
    const V share = hn::Set(d, kCornerShare);
    V distance2 = zero, above = zero, box_above = zero, toward = zero;
    for (int axis = 0; axis < 3; ++axis) {
      const V to = hn::Sub(hn::LoadU(d, c.mean[axis] + i), hn::Set(d, q.position[axis]));
      const float n = q.normal[axis];
      distance2 = hn::MulAdd(to, to, distance2);
      above = hn::MulAdd(hn::Set(d, n), to, above);
      box_above = hn::MulAdd(hn::Set(d, std::abs(n)), hn::LoadU(d, l.half[axis] + i), box_above);
      toward = hn::NegMulAdd(hn::LoadU(d, l.normal[axis] + i), to, toward);
    }
    const V softened = hn::Max(distance2, hn::LoadU(d, l.least_distance2 + i));
    const V inverse = inverse_sqrt(hn::Min(softened, hn::Set(d, 1e36f)));
    const V distance = hn::Mul(softened, inverse);  // no less than that of the mean
    // Rounding must not hide what is just above.
    const V rounding = hn::Mul(hn::Set(d, 1e-5f), distance);
    const V best_above = hn::Add(hn::Add(above, box_above), rounding);
    // Some normal of the cone faces the shading point from somewhere in the box, or not: v is on
    // the cone's side where axis . v > -sine |v|.
    const V sine = hn::LoadU(d, l.cone_sine + i);
    const V best_toward =
        hn::Add(hn::MulAdd(sine, distance, hn::LoadU(d, l.reach + i)), hn::Add(toward, rounding));
    const V weight = hn::LoadU(d, c.weight + i);
    const auto possible =
        hn::And(hn::And(hn::Gt(best_above, zero), hn::Gt(best_toward, zero)), hn::Gt(weight, zero));

    const V cosine = hn::Max(hn::Mul(above, inverse),
                             hn::Mul(share, hn::Min(hn::Mul(best_above, inverse), one)));
    const V light = hn::Max(
        hn::Mul(hn::MulAdd(toward, inverse, sine), hn::LoadU(d, l.inverse_one_plus_sine + i)),
        hn::Mul(share, hn::Min(hn::Mul(best_toward, inverse), one)));
    const V form_factor = hn::Mul(hn::Mul(cosine, light),
                                  hn::Mul(hn::Mul(inverse, inverse), hn::Set(d, q.unit_area)));
    V value = hn::Mul(form_factor, hn::Set(d, q.diffuse + q.glossy_floor));
    if (q.hits != nullptr) {
      // Eq. 4.4 divides by the cluster's solid angle A cos' / r², and so cancels G's.
      const V density = hn::Mul(hn::LoadU(d, q.hits + i), hn::LoadU(d, c.inverse_extent + i));
      value = hn::MulAdd(hn::Mul(hn::Set(d, q.glossy_hit), density), cosine, value);
    }
    return Importances<V, decltype(possible)>{hn::Mul(weight, value), possible};
  }
};

/// Running sums over all clusters of what `importance_of` says.
template <class ImportanceOf>
HWY_INLINE float fill_columns(const ImportanceOf& importance_of, size_t rows, float* columns,
                              float* lane_sums) {
  const Tag d;
  const size_t n = hn::Lanes(d);
  const auto zero = hn::Zero(d);
  // Weights are normalised: nothing above the horizon may vanish by underflow.
  const auto smallest = hn::Set(d, 1e-37f);
  float total = 0;
  size_t active = 0;
  for (size_t lane = 0; lane < kLanes; lane += n) {
    auto sum = zero;
    for (size_t row = 0; row < rows; ++row) {
      const size_t i = row * kLanes + lane;
      const auto [value, can_contribute] = importance_of(d, i);
      const auto importance = hn::IfThenElseZero(can_contribute, hn::Max(value, smallest));
      active += hn::CountTrue(d, can_contribute);
      hn::StoreU(importance, d, columns + i);
      sum = hn::Add(sum, importance);
    }
    hn::StoreU(sum, d, lane_sums + lane);
  }
  for (size_t lane = 0; lane < kLanes; ++lane) total += lane_sums[lane];
  if (active == 0) return 0;

  const auto floor = hn::Set(d, total * (kEvenShare / static_cast<float>(active)));
  for (size_t lane = 0; lane < kLanes; lane += n) {
    auto sum = zero;
    for (size_t row = 0; row < rows; ++row) {
      const size_t i = row * kLanes + lane;
      const auto importance = hn::LoadU(d, columns + i);
      sum = hn::Add(sum, hn::IfThenElseZero(hn::Gt(importance, zero), hn::Add(importance, floor)));
      hn::StoreU(sum, d, columns + i);
    }
    hn::StoreU(sum, d, lane_sums + lane);
  }
  total = 0;
  for (size_t lane = 0; lane < kLanes; ++lane) total += lane_sums[lane];
  return total;
}

float ClusterImportance(const ClusterColumns& c, const ImportanceQuery& q, float* columns,
                        float* lane_sums) {
  return fill_columns(Distant{c, q}, c.rows, columns, lane_sums);
}

float LocalClusterImportance(const ClusterColumns& c, const LocalColumns& l,
                             const ImportanceQuery& q, float* columns, float* lane_sums) {
  return fill_columns(Local{c, l, q}, c.rows, columns, lane_sums);
}

struct RaySlabs {
  float origin[3];
  float t_min, t_max;
  float inverse[3];
  size_t near[3];  ///< offset in a group of the bounds that the ray meets first
  size_t far[3];
};

/// A bit for each of the group's boxes that the ray meets. Bounds are ordered by the direction's
/// sign, so that an inverted box is never met.
HWY_INLINE uint32_t hit_mask(const float* group, const RaySlabs& ray) {
  const BoxTag d;
  const size_t n = hn::Lanes(d);
  uint32_t mask = 0;
  for (size_t k = 0; k < kFanOut; k += n) {
    auto near = hn::Set(d, ray.t_min);
    auto far = hn::Set(d, ray.t_max);
    for (int axis = 0; axis < 3; ++axis) {
      const auto o = hn::Set(d, ray.origin[axis]);
      const auto inverse = hn::Set(d, ray.inverse[axis]);
      near = hn::Max(near, hn::Mul(hn::Sub(hn::LoadU(d, group + ray.near[axis] + k), o), inverse));
      far = hn::Min(far, hn::Mul(hn::Sub(hn::LoadU(d, group + ray.far[axis] + k), o), inverse));
    }
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Le(near, far), bits);
    mask |= (static_cast<uint32_t>(bits[0]) & ((1u << n) - 1)) << k;
  }
  return mask;
}

HWY_INLINE RaySlabs make_slabs(const LobeRays& rays, size_t i) {
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

void CountBoxHits(const BoxTree& tree, const LobeRays& rays, const uint32_t* position,
                  float* hits) {
  constexpr size_t kGroup = 6 * kFanOut;
  struct Entry {
    uint32_t level, group;
  };
  // Depth-first: at most kFanOut - 1 siblings wait on each level, and 11 levels hold 2^32 boxes.
  Entry stack[11 * kFanOut];
  const uint32_t top = static_cast<uint32_t>(tree.level_start.size() - 1);
  for (size_t i = 0; i < rays.count; ++i) {
    const RaySlabs ray = make_slabs(rays, i);
    size_t depth = 0;
    stack[depth++] = {top, 0};
    while (depth > 0) {
      const Entry entry = stack[--depth];
      const size_t group = tree.level_start[entry.level] + entry.group;
      uint32_t mask = hit_mask(tree.groups.data() + group * kGroup, ray);
      for (; mask != 0; mask &= mask - 1) {
        const uint32_t box = entry.group * static_cast<uint32_t>(kFanOut) +
                             static_cast<uint32_t>(__builtin_ctz(mask));
        if (entry.level == 0) {
          hits[position[box]] += 1;
        } else {
          stack[depth++] = {entry.level - 1, box};
        }
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinome::simd {

HWY_EXPORT(ClusterImportance);
HWY_EXPORT(LocalClusterImportance);
HWY_EXPORT(CountBoxHits);

float cluster_importance(const ClusterColumns& clusters, const ImportanceQuery& query,
                         float* columns, float* lane_sums) {
  return HWY_DYNAMIC_DISPATCH(ClusterImportance)(clusters, query, columns, lane_sums);
}

float local_cluster_importance(const ClusterColumns& clusters, const LocalColumns& local,
                               const ImportanceQuery& query, float* columns, float* lane_sums) {
  return HWY_DYNAMIC_DISPATCH(LocalClusterImportance)(clusters, local, query, columns, lane_sums);
}

void count_box_hits(const BoxTree& tree, const LobeRays& rays, const uint32_t* position,
                    float* hits) {
  HWY_DYNAMIC_DISPATCH(CountBoxHits)(tree, rays, position, hits);
}

std::string instruction_set() {
  // Lower bits stand for better targets; the list starts with the best.
  return hwy::TargetName(hwy::SupportedAndGeneratedTargets().front());
}

void use_scalar_target(bool scalar) {
  hwy::SetSupportedTargetsForTest(scalar ? HWY_SCALAR | HWY_EMU128 : 0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace kinome::simd
#endif
