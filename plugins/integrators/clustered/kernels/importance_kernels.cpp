#include "clustered/kernels/importance_kernels.h"

#include <cmath>

#include "kinome/math.h"
#include "kinome/wide/vectors.h"

namespace kinome::simd {
namespace {

using namespace wide::formulas;
using wide::Float;
using wide::Int;
using wide::Vec3;
using wide::VecOf;

/// Added to the cosine at a patch, because a patch has more than one normal.
constexpr float kMargin = 0.05f;
/// Fraction of the reflected light that a glossy lobe adds in all directions.
constexpr float kLobeFloor = 0.05f;

KINOME_WIDE Vec3 load(const float* const (&columns)[3], size_t i) {
  return {Float::load(columns[0] + i), Float::load(columns[1] + i), Float::load(columns[2] + i)};
}

template <class F>
VecOf<F> vector_of(const float (&v)[3]) {
  return {F(v[0]), F(v[1]), F(v[2])};
}

/// See reflected_fraction. The lobe is a GGX distribution of half vectors without masking.
template <class F>
F fraction_of(const ReflectingPatch& patch, const VecOf<F>& d, const F& arriving,
              const F& spread2) {
  const F diffuse = patch.diffuse * kInvPi * clamp(arriving, F(0.f), F(1.f));
  if (!(patch.glossy > 0)) return diffuse;
  const VecOf<F> sum = d + vector_of<F>(patch.viewer);
  const F height = max(dot(sum, vector_of<F>(patch.normal)), F(0.f));
  const F cosine2 = height * height / max(dot(sum, sum), F(1e-8f));
  const F alpha2 = min(patch.alpha2 + 0.25f * spread2, F(1.f));
  const F t = max(1.f + (alpha2 - 1.f) * cosine2, F(1e-6f));
  const F lobe = select(height > 0.f, alpha2 / (4 * kPi * t * t), F(0.f));
  return diffuse + select(arriving > 0.f, patch.glossy * (lobe + kLobeFloor), F(0.f));
}

/// Importance of light of unit flux at `to`, relative to the patch, that leaves around `normal`.
/// `size2`: squared extent of the light and the patch.
KINOME_WIDE Float importance_of(const ReflectingPatch& patch, Vec3 to, Vec3 normal, Float size2) {
  const Float squared = dot(to, to) + 1e-30f;
  const Float softened = squared + size2, spread2 = size2 / softened, spread = sqrt(spread2);
  const Vec3 d = to * (1.f / sqrt(squared));
  // Cells whose normals differ emit to more sides.
  const Float leaving = 1.f - length(normal) - dot(normal, d) + spread;
  const Float arriving = dot(d, vector_of<Float>(patch.normal)) + spread + kMargin;
  return fraction_of<Float>(patch, d, arriving, spread2) * clamp(leaving, Float(0.f), Float(1.f)) /
         softened;
}

}  // namespace

float reflected_fraction(const ReflectingPatch& patch, const float d[3], float arriving,
                         float spread2) {
  return fraction_of<float>(patch, {d[0], d[1], d[2]}, arriving, spread2);
}

void cell_importance(const ReflectingPatch& patch, const CellMeans& cells, const float* visibility,
                     size_t count, float* importance) {
  const Vec3 position = vector_of<Float>(patch.position);
  wide::for_lanes(count, [&](size_t i) {
    const Float value = importance_of(patch, load(cells.position, i) - position,
                                      load(cells.normal, i), Float::load(cells.spread2 + i));
    (value * Float::load(cells.flux + i) * Float::load(visibility + i)).store(importance + i);
  });
}

void point_importance(const ReflectingPatch& patch, float size2, const EmittingPoints& points,
                      const float* visibility, size_t count, float* importance) {
  const Vec3 position = vector_of<Float>(patch.position);
  wide::for_lanes(count, [&](size_t i) {
    const Float value = importance_of(patch, load(points.position, i) - position,
                                      load(points.normal, i), size2);
    const Float visible = gather(visibility, Int::load(points.cell + i));
    (value * Float::load(points.power + i) * visible).store(importance + i);
  });
}

void believed_visibility(const float* v, const float* sigma, float least, size_t count,
                         float* visibility) {
  wide::for_lanes(count, [&](size_t i) {
    max(max(Float::load(v + i), Float::load(sigma + i)), Float(least)).store(visibility + i);
  });
}

void add_normalized(const float* values, size_t count, float* sums) {
  Float total = 0.f;
  wide::for_lanes(count, [&](size_t i) { total += Float::load(values + i); });
  const float scale = 1 / sum(total);
  if (!(scale > 0) || !std::isfinite(scale)) return;
  wide::for_lanes(count, [&](size_t i) {
    mul_add(Float::load(values + i), Float(scale), Float::load(sums + i)).store(sums + i);
  });
}

}  // namespace kinome::simd
