#include "cluster_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cluster_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kLanes>;
using BoxTag = hn::CappedTag<float, kFanOut>;

/// A cluster's largest cosine to the normal, over the corners of its box (4.2.2: "as soon as one
/// corner is above the horizon"): separable, since each axis picks its corner alone.
template <class V>
V corner_term(V normal, V lo, V hi) {
  return hn::Max(hn::Mul(normal, lo), hn::Mul(normal, hi));
}

float ClusterImportance(const ClusterColumns& c, const ImportanceQuery& q, float* columns,
                        float* lane_sums) {
  const Tag d;
  const size_t n = hn::Lanes(d);
  const auto nx = hn::Set(d, q.normal[0]);
  const auto ny = hn::Set(d, q.normal[1]);
  const auto nz = hn::Set(d, q.normal[2]);
  const auto zero = hn::Zero(d);
  const auto base = hn::Set(d, q.diffuse + q.glossy_floor);
  const auto glossy_hit = hn::Set(d, q.glossy_hit);
  // Weights are normalised: nothing above the horizon may vanish by underflow.
  const auto smallest = hn::Set(d, 1e-37f);
  // The average direction may lie below the horizon while a part of the cluster is above; the best
  // corner then bounds the form factor.
  const auto corner_share = hn::Set(d, 0.25f);

  float total = 0;
  size_t active = 0;
  for (size_t lane = 0; lane < kLanes; lane += n) {
    auto sum = zero;
    for (size_t row = 0; row < c.rows; ++row) {
      const size_t i = row * kLanes + lane;
      const auto corner =
          hn::Add(hn::Add(corner_term(nx, hn::LoadU(d, c.lo[0] + i), hn::LoadU(d, c.hi[0] + i)),
                          corner_term(ny, hn::LoadU(d, c.lo[1] + i), hn::LoadU(d, c.hi[1] + i))),
                  corner_term(nz, hn::LoadU(d, c.lo[2] + i), hn::LoadU(d, c.hi[2] + i)));
      const auto cosine = hn::Add(hn::Add(hn::Mul(nx, hn::LoadU(d, c.mean[0] + i)),
                                          hn::Mul(ny, hn::LoadU(d, c.mean[1] + i))),
                                  hn::Mul(nz, hn::LoadU(d, c.mean[2] + i)));
      const auto form_factor = hn::Max(cosine, hn::Mul(corner_share, corner));
      auto brdf = base;
      if (q.hits != nullptr) {
        const auto density = hn::Mul(hn::LoadU(d, q.hits + i), hn::LoadU(d, c.inverse_extent + i));
        brdf = hn::Add(brdf, hn::Mul(glossy_hit, density));
      }
      const auto weight = hn::LoadU(d, c.weight + i);
      const auto gamma = hn::Mul(hn::Mul(weight, form_factor), brdf);
      const auto can_contribute = hn::And(hn::Gt(corner, zero), hn::Gt(weight, zero));
      const auto importance = hn::IfThenElseZero(can_contribute, hn::Max(gamma, smallest));
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
    for (size_t row = 0; row < c.rows; ++row) {
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
HWY_EXPORT(CountBoxHits);

float cluster_importance(const ClusterColumns& clusters, const ImportanceQuery& query,
                         float* columns, float* lane_sums) {
  return HWY_DYNAMIC_DISPATCH(ClusterImportance)(clusters, query, columns, lane_sums);
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
