#pragma once

#include <cmath>

#include "clustered/kernels/cluster_kernels.h"
#include "kinome/wide/vectors.h"

/// What cluster_importance and local_cluster_importance compute, over numbers F: wide::Float, or
/// float, one cluster after the other, with which tests compare.
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

/// Share of the best corner's cosine that a cluster's form factor has at least.
inline constexpr float kCornerShare = 0.25f;

/// How likely clusters are, and whether they can contribute at all.
template <class F>
struct Importances {
  F value;
  MaskOf<F> can_contribute;
};

/// Distant light: directions. G is the cosine at the shading point alone.
template <class F>
struct DistantImportance {
  const ClusterColumns& c;
  const ImportanceQuery& q;

  Importances<F> operator()(size_t i) const {
    // A cluster's largest cosine is over the corners of its box (4.2.2: "as soon as one corner is
    // above the horizon"): separable, since each axis picks its corner alone.
    F corner = 0.f, cosine = 0.f;
    for (int axis = 0; axis < 3; ++axis) {
      const float n = q.normal[axis];
      corner += max(n * load_number<F>(c.lo[axis] + i), n * load_number<F>(c.hi[axis] + i));
      cosine += n * load_number<F>(c.mean[axis] + i);
    }
    // The average direction may lie below the horizon while a part of the cluster is above; the
    // best corner then bounds the form factor.
    const F form_factor = max(cosine, kCornerShare * corner);
    F brdf = q.diffuse + q.glossy_floor;
    if (q.hits != nullptr) {
      brdf += q.glossy_hit * (load_number<F>(q.hits + i) * load_number<F>(c.inverse_extent + i));
    }
    const F weight = load_number<F>(c.weight + i);
    return {weight * form_factor * brdf, corner > 0.f && weight > 0.f};
  }
};

/// Local light: positions with a cone of normals. G = cos cos' / r² (thesis 2.2), where each cosine
/// is that of the average, but no less than a share of the best that the box and the cone allow,
/// and r no less than half the box's radius: a cluster around the shading point stays finite.
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
    const F softened = max(distance2, load_number<F>(l.least_distance2 + i));
    const F inverse = 1.f / sqrt(min(softened, F(1e36f)));
    const F distance = softened * inverse;  // no less than that of the mean
    // Rounding must not hide what is just above.
    const F rounding = 1e-5f * distance;
    const F best_above = above + box_above + rounding;
    // Some normal of the cone faces the shading point from somewhere in the box, or not: v is on
    // the cone's side where axis . v > -sine |v|.
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
      // Eq. 4.4 divides by the cluster's solid angle A cos' / r², and so cancels G's.
      const F density = load_number<F>(q.hits + i) * load_number<F>(c.inverse_extent + i);
      value = mul_add(q.glossy_hit * density, cosine, value);
    }
    return {weight * value, possible};
  }
};

/// Running sums over all clusters of what `importance_of` says, and in `lane_sums` each lane's;
/// returns the total.
template <class F, class ImportanceOf>
float sum_importances(const ImportanceOf& importance_of, size_t rows, float* columns,
                      float* lane_sums) {
  // Weights are normalised: nothing above the horizon may vanish by underflow.
  constexpr float kSmallest = 1e-37f;
  float total = 0;
  size_t active = 0;
  for (size_t lane = 0; lane < kBlockLanes; lane += kLanesOf<F>) {
    F sum = 0.f;
    for (size_t row = 0; row < rows; ++row) {
      const size_t i = row * kBlockLanes + lane;
      const auto [value, can_contribute] = importance_of(i);
      const F importance = select(can_contribute, max(value, F(kSmallest)));
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
