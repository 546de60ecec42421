#include "clustered/kernels/importance_kernels.h"

#include <cmath>

#include "clustered/kernels/vector_columns.h"
#include "kinome/math.h"

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
/// The same fraction for light that is reflected to other surfaces, and the minimum cosines there.
constexpr float kSentFloor = 0.02f;

template <class F>
VecOf<F> vector_of(const float (&v)[3]) {
  return {F(v[0]), F(v[1]), F(v[2])};
}

template <class F>
struct Response {
  F fraction;  ///< see reflected_fraction
  F density;   ///< density of eye rays, per solid angle
};
/// The lobe is a GGX distribution of half vectors without masking.
template <class F>
Response<F> response_of(const ReflectingPatch& patch, const VecOf<F>& d, const F& arriving,
                        const F& spread2) {
  const F by_cosine = kInvPi * clamp(arriving, F(0.f), F(1.f));
  const F diffuse = patch.diffuse * by_cosine;
  if (!(patch.glossy > 0)) return {diffuse, by_cosine};
  const VecOf<F> sum = d + vector_of<F>(patch.viewer);
  const F height = max(dot(sum, vector_of<F>(patch.normal)), F(0.f));
  const F cosine2 = height * height / max(dot(sum, sum), F(1e-8f));
  const F alpha2 = min(patch.alpha2 + 0.25f * spread2, F(1.f));
  const F t = max(1.f + (alpha2 - 1.f) * cosine2, F(1e-6f));
  const F lobe = select(height > 0.f, alpha2 / (4 * kPi * t * t), F(0.f));
  const F glossy = select(arriving > 0.f, patch.glossy * (lobe + kLobeFloor), F(0.f));
  return {diffuse + glossy, lerp(lobe, by_cosine, F(patch.diffuse_share))};
}

struct Connection {
  Response<Float> response;
  Float geometry;
};
/// Connects a patch to light at `to`, relative to the patch, that leaves around `normal`. `size2`:
/// squared extent of the light and the patch.
KINOME_WIDE Connection connect(const ReflectingPatch& patch, Vec3 to, Vec3 normal, Float size2) {
  const Float squared = dot(to, to) + 1e-30f;
  const Float softened = squared + size2, spread2 = size2 / softened, spread = sqrt(spread2);
  const Vec3 d = to * (1.f / sqrt(squared));
  // Cells with different normals emit in more directions.
  const Float leaving = 1.f - length(normal) - dot(normal, d) + spread;
  const Float arriving = dot(d, vector_of<Float>(patch.normal)) + spread + kMargin;
  return {response_of<Float>(patch, d, arriving, spread2),
          clamp(leaving, Float(0.f), Float(1.f)) / softened};
}

template <class F>
struct SentLobeOf {
  VecOf<F> normal, light;
  F alpha2, diffuse, glossy;
};
/// See sent_fraction.
template <class F>
F sent_of(const SentLobeOf<F>& lobe, const VecOf<F>& d, const F& spread2) {
  const F in = max(dot(lobe.normal, lobe.light), F(kSentFloor));
  const F out = max(dot(lobe.normal, d), F(kSentFloor));
  const F alpha2 = min(lobe.alpha2 + 0.25f * spread2, max(lobe.alpha2, F(1.f)));
  const VecOf<F> sum = lobe.light + d;
  const F length2 = max(dot(sum, sum), F(1e-8f));
  const F cosine = dot(sum, lobe.normal);
  const F t = max(1.f + (alpha2 - 1.f) * cosine * cosine / length2, F(1e-6f));
  const F density = alpha2 * kInvPi / (t * t);
  const auto root = [&](const F& c) { return sqrt(alpha2 + (1.f - alpha2) * c * c); };
  const F masked = 0.5f / (out * root(in) + in * root(out));  // Heitz 2014, eq. 99
  // Schlick's approximation: at grazing angles, materials that hardly reflect along the normal are
  // mirrors. The cosine with the half vector is half the length of the sum.
  const F grazing = 1.f - min(0.5f * sqrt(length2), F(1.f)), grazing2 = grazing * grazing;
  const F fresnel = lerp(lobe.glossy, F(1.f), grazing2 * grazing2 * grazing);
  return in * (lobe.diffuse * kInvPi + density * masked * fresnel +
               lobe.glossy * (kSentFloor * kInvPi));
}

}  // namespace

float reflected_fraction(const ReflectingPatch& patch, const float d[3], float arriving,
                         float spread2) {
  return response_of<float>(patch, {d[0], d[1], d[2]}, arriving, spread2).fraction;
}

void cell_importance(const ReflectingPatch& patch, const CellMeans& cells, const float* visibility,
                     size_t count, float* importance) {
  const Vec3 position = vector_of<Float>(patch.position);
  wide::for_lanes(count, [&](size_t i) {
    const Connection to = connect(patch, load(cells.position, i) - position, load(cells.normal, i),
                                  Float::load(cells.spread2 + i));
    const Float value = to.response.fraction * to.geometry * Float::load(cells.flux + i);
    (value * Float::load(visibility + i)).store(importance + i);
  });
}

void point_importance(const ReflectingPatch& patch, float size2, const EmittingPoints& points,
                      const float* visibility, size_t count, float* importance) {
  const Vec3 position = vector_of<Float>(patch.position);
  wide::for_lanes(count, [&](size_t i) {
    const Connection to = connect(patch, load(points.position, i) - position,
                                  load(points.normal, i), size2);
    const Float by_eye = patch.eye_rays * to.response.density * to.geometry *
                         Float::load(points.eye_ratio + i);
    const Float value = to.response.fraction * to.geometry * Float::load(points.power + i);
    const Float visible = gather(visibility, Int::load(points.cell + i));
    (value * visible / (1.f + by_eye)).store(importance + i);
  });
}

float sent_fraction(const SentLobe& lobe, const float d[3], float spread2) {
  return sent_of<float>({vector_of<float>(lobe.normal), vector_of<float>(lobe.light), lobe.alpha2,
                         lobe.diffuse, lobe.glossy},
                        {d[0], d[1], d[2]}, spread2);
}

void sent_to_patch(const ReflectingPatch& patch, float size2, const SendingPoints& points,
                   size_t count, float* fraction) {
  const Vec3 position = vector_of<Float>(patch.position);
  wide::for_lanes(count, [&](size_t i) {
    const Vec3 to = position - load(points.position, i);
    const Float squared = dot(to, to) + 1e-30f;
    const SentLobeOf<Float> lobe{load(points.normal, i), load(points.light, i),
                                 Float::load(points.alpha2 + i), Float::load(points.diffuse + i),
                                 Float::load(points.glossy + i)};
    sent_of<Float>(lobe, to * (1.f / sqrt(squared)), size2 / (squared + size2)).store(fraction + i);
  });
}

void assumed_visibility(const float* v, const float* sigma, float least, size_t count,
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
