#pragma once

#include <cmath>

#include "clustered/kernels/cluster_kernels.h"
#include "kinome/wide/vectors.h"

/// Formulas of cluster_importance and local_cluster_importance. F is wide::Float, or float for a
/// scalar reference in tests.
namespace kinome::simd {
inline namespace HWY_NAMESPACE {

using namespace wide::formulas;

template <class F>
inline constexpr size_t kLanesOf = std::same_as<F, float> ? 1 : wide::kLanes;

template <class F>
KINOME_WIDE F load_number(const float* p) {
  if constexpr (std::same_as<F, float>) {
    return *p;
  } else {
    return F::load(p);
  }
}
KINOME_WIDE void store_number(float value, float* p) {
  *p = value;
}
KINOME_WIDE void store_number(wide::Float value, float* p) {
  value.store(p);
}

/// Minimum form factor of a cluster, as a share of the best corner's cosine.
inline constexpr float kCornerShare = 0.25f;

/// Importances of clusters, and whether they can contribute at all.
template <class F>
struct Importances {
  F value;
  MaskOf<F> can_contribute;
};

/// Distant light: directions. The form factor G is the cosine at the shading point.
template <class F>
struct DistantImportance {
  const ClusterColumns& c;
  const ImportanceQuery& q;

  Importances<F> operator()(size_t i) const {
    // Maximum cosine over the corners of the cluster's box (4.2.2: "as soon as one corner is above
    // the horizon"). It is separable, because each axis chooses its corner by itself.
    F corner = 0.f, cosine = 0.f;
    for (int axis = 0; axis < 3; ++axis) {
      const float n = q.normal[axis];
      corner += max(n * load_number<F>(c.lo[axis] + i), n * load_number<F>(c.hi[axis] + i));
      cosine += n * load_number<F>(c.mean[axis] + i);
    }
    // The mean direction may be below the horizon while a part of the cluster is above. The best
    // corner then bounds the form factor.
    const F form_factor = max(cosine, kCornerShare * corner);
    F brdf = q.diffuse + q.glossy_floor;
    if (q.hits != nullptr) {
      brdf += q.glossy_hit * (load_number<F>(q.hits + i) * load_number<F>(c.inverse_extent + i));
    }
    const F weight = load_number<F>(c.weight + i);
    return {weight * form_factor * brdf, corner > 0.f && weight > 0.f};
  }
};

/// Local light: positions with a cone of normals. G = cos cos' / r² (thesis 2.2). Each cosine is
/// that of the mean, but at least a share of the maximum in the box and the cone. r is at least
/// half the box's radius, so that a cluster around the shading point stays finite.
template <class F>
struct LocalImportance {
  const ClusterColumns& c;
  const LocalColumns& l;
  const ImportanceQuery& q;

  Importances<F> operator()(size_t i) const {
    F distance2 = 0.f, above = 0.f, box_above = 0.f, toward = 0.f;
    for (int axis = 0; axis < 3; ++axis) {
      const F to = load_number<F>(c.mean[axis] + i) - q.position[axis];
      const float n = q.normal[axis];
      distance2 = mul_add(to, to, distance2);
      above = mul_add(F(n), to, above);
      box_above = mul_add(F(std::abs(n)), load_number<F>(l.half[axis] + i), box_above);
      toward = neg_mul_add(load_number<F>(l.normal[axis] + i), to, toward);
    }
    const F softened = max(distance2, load_number<F>(l.min_distance2 + i));
    const F inverse = 1.f / sqrt(min(softened, F(1e36f)));
    const F distance = softened * inverse;  // at least that of the mean
    // Rounding must not hide points just above the horizon.
    const F rounding = 1e-5f * distance;
    const F best_above = above + box_above + rounding;
    // Positive if any normal of the cone faces the shading point from any position in the box: some
    // normal faces along v if axis . v > -sine |v|.
    const F sine = load_number<F>(l.cone_sine + i);
    const F best_toward =
        mul_add(sine, distance, load_number<F>(l.reach + i)) + (toward + rounding);
    const F weight = load_number<F>(c.weight + i);
    const MaskOf<F> possible = best_above > 0.f && best_toward > 0.f && weight > 0.f;

    const F cosine = max(above * inverse, kCornerShare * min(best_above * inverse, F(1.f)));
    const F light =
        max(mul_add(toward, inverse, sine) * load_number<F>(l.inverse_one_plus_sine + i),
            kCornerShare * min(best_toward * inverse, F(1.f)));
    const F form_factor = cosine * light * (inverse * inverse * q.unit_area);
    F value = form_factor * (q.diffuse + q.glossy_floor);
    if (q.hits != nullptr) {
      // Eq. 4.4 divides by the cluster's solid angle A cos' / r², which cancels that of G.
      const F density = load_number<F>(q.hits + i) * load_number<F>(c.inverse_extent + i);
      value = mul_add(q.glossy_hit * density, cosine, value);
    }
    return {weight * value, possible};
  }
};

/// Writes running sums of `importance_of` over all clusters, down each lane, and the sum of each
/// lane to `lane_sums`. Returns the total.
template <class F, class ImportanceOf>
float sum_importances(const ImportanceOf& importance_of, size_t rows, float* columns,
                      float* lane_sums) {
  // Weights are normalised. Clusters above the horizon must not vanish by underflow.
  constexpr float kMinImportance = 1e-37f;
  float total = 0;
  size_t active = 0;
  for (size_t lane = 0; lane < kBlockLanes; lane += kLanesOf<F>) {
    F sum = 0.f;
    for (size_t row = 0; row < rows; ++row) {
      const size_t i = row * kBlockLanes + lane;
      const auto [value, can_contribute] = importance_of(i);
      const F importance = select(can_contribute, max(value, F(kMinImportance)));
      active += count(can_contribute);
      store_number(importance, columns + i);
      sum += importance;
    }
    store_number(sum, lane_sums + lane);
  }
  for (size_t lane = 0; lane < kBlockLanes; ++lane) total += lane_sums[lane];
  if (active == 0) return 0;

  const F floor = total * (kEvenShare / static_cast<float>(active));
  for (size_t lane = 0; lane < kBlockLanes; lane += kLanesOf<F>) {
    F sum = 0.f;
    for (size_t row = 0; row < rows; ++row) {
      const size_t i = row * kBlockLanes + lane;
      const F importance = load_number<F>(columns + i);
      sum += select(importance > 0.f, importance + floor);
      store_number(sum, columns + i);
    }
    store_number(sum, lane_sums + lane);
  }
  total = 0;
  for (size_t lane = 0; lane < kBlockLanes; ++lane) total += lane_sums[lane];
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
