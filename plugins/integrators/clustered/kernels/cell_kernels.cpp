#include "clustered/kernels/cell_kernels.h"

#include <cmath>

#include "clustered/kernels/lane_blocks.h"
#include "clustered/kernels/vector_columns.h"

namespace kinome::simd {
namespace {

using wide::Float;
using wide::kLanes;
using wide::Mask;
using wide::Uint;
using wide::Vec3;

/// Minimum light of a mixed cell, as a share of its flux, per cosine of its highest point; and the
/// minimum of this cosine.
constexpr float kMixedShare = 0.4f;
constexpr float kMinCosine = 0.02f;
/// Minimum light of a cell, as a share of its flux, because its importance flux may point
/// elsewhere.
constexpr float kMinShare = 1e-3f;
/// Minimum stratum of a straddling cell, as a share of its stratum without a control term.
constexpr float kStraddlingShare = 0.02f;
/// Rounding error of the bounds.
constexpr float kRounding = 1e-6f;

/// Returns the sum of kCellLanes values from `first` on. values(i) returns the vector that begins
/// at i.
template <class Function>
KINOME_WIDE float sum_block(size_t first, const Function& values) {
  Float total = 0.f;
  for (size_t i = first; i < first + kCellLanes; i += kLanes) total += values(i);
  return sum(total);
}

struct Range {
  Float lo, hi;
};

/// Returns the minimum and maximum cosine between a normal n and the directions of a rectangle in
/// latitude and longitude, d = (sin phi sin theta, cos theta, -cos phi sin theta): exact up to
/// rounding. Along phi, the cosine is a sine curve: its extremes are at the ends, or in between
/// where the slope changes its sign. Along theta, it is a sine curve, too.
template <class Column>
KINOME_WIDE Range cosine_range(const float n[3], const Column& edge) {
  const Float nx = n[0], ny = n[1], nz = n[2];
  const float amplitude = std::sqrt(n[0] * n[0] + n[2] * n[2]);
  const Float sin_phi0 = edge(0), cos_phi0 = edge(1), sin_phi1 = edge(2), cos_phi1 = edge(3);
  const Float g0 = neg_mul_add(nz, cos_phi0, nx * sin_phi0);
  const Float g1 = neg_mul_add(nz, cos_phi1, nx * sin_phi1);
  const Float slope0 = mul_add(nz, sin_phi0, nx * cos_phi0);
  const Float slope1 = mul_add(nz, sin_phi1, nx * cos_phi1);
  const Float low = select(slope0 < 0.f && slope1 > 0.f, -amplitude, min(g0, g1));
  const Float high = select(slope0 > 0.f && slope1 < 0.f, amplitude, max(g0, g1));

  const Float cos0 = edge(4), sin0 = edge(5), cos1 = edge(6), sin1 = edge(7);
  // Values and slopes of g sin theta + ny cos theta.
  const auto at = [&](Float g, Float sine, Float cosine) { return mul_add(g, sine, ny * cosine); };
  const auto slope = [&](Float g, Float sine, Float cosine) {
    return neg_mul_add(ny, sine, g * cosine);
  };
  const auto extreme = [&](Float g) { return sqrt(mul_add(g, g, ny * ny)); };
  const Mask dips = slope(low, sin0, cos0) < 0.f && slope(low, sin1, cos1) > 0.f;
  const Mask peaks = slope(high, sin0, cos0) > 0.f && slope(high, sin1, cos1) < 0.f;
  return {select(dips, -extreme(low), min(at(low, sin0, cos0), at(low, sin1, cos1))),
          select(peaks, extreme(high), max(at(high, sin0, cos0), at(high, sin1, cos1)))};
}

}  // namespace

void PatchCells::reserve(size_t padded_cells) {
  // A compressed store writes a whole vector, and mixed ids are behind those above.
  const size_t needed = padded_cells + 2 * kCellLanes;
  if (stride_ >= needed) return;
  stride_ = needed;
  above_.resize(kAboveColumns * stride_);
  mixed_.resize(kMixedColumns * stride_);
  ids_.resize(2 * stride_);
}

void classify_cells(const CellColumns& cells, std::span<const uint32_t> blocks,
                    const float local_normal[3], float sine, const CellKnowledge& knowledge,
                    const float* transmittance, PatchCells& patch) {
  patch.reserve(cells.count);
  Float control[9];
  for (Float& c : control) c = 0.f;
  size_t above = 0, mixed = 0;
  uint32_t* const ids = patch.ids();
  // Mixed ids are stored behind the space for all ids above, and moved up in the end.
  uint32_t* const mixed_ids = ids + cells.count + kCellLanes;
  wide::for_lanes_of_blocks(blocks, [&](size_t i) {
    const auto of = [&](const float* column) { return Float::load(column + i); };
    const Range range = cosine_range(local_normal, [&](int k) { return of(cells.edges[k]); });
    const Float flux = of(cells.flux);
    const Mask is_lit = flux > 0.f;
    const Mask is_above = is_lit && range.lo >= sine + kRounding;
    const Mask is_below = range.hi <= -sine - kRounding;
    const Mask is_mixed = is_lit && !(is_above || is_below);
    const Float t = transmittance ? of(transmittance) : Float(1.f);
    const Float v = t * of(knowledge.visibility), sigma = t * of(knowledge.sigma);
    const Uint id = as_uint(wide::iota() + static_cast<int32_t>(i));
    if (any(is_above)) {
      const auto put = [&](int column, Float value) {
        store_selected(is_above, value, patch.above_column(column) + above);
      };
      for (int k = 0; k < 9; ++k) control[k] += select(is_above, v * of(cells.vector_flux[k]));
      for (int axis = 0; axis < 3; ++axis) {
        put(PatchCells::kSigmaX + axis, sigma * of(cells.importance_flux[axis]));
      }
      put(PatchCells::kMinFlux, sigma * kMinShare * flux);
      above += store_selected(is_above, id, ids + above);
    }
    if (any(is_mixed)) {
      const auto put = [&](int column, Float value) {
        store_selected(is_mixed, value, patch.mixed_column(column) + mixed);
      };
      for (int k = 0; k < 8; ++k) put(PatchCells::kEdges + k, of(cells.edges[k]));
      for (int axis = 0; axis < 3; ++axis) {
        put(PatchCells::kFluxX + axis, of(cells.importance_flux[axis]));
      }
      put(PatchCells::kFlux, flux);
      put(PatchCells::kSigma, sigma);
      put(PatchCells::kSigmaMixed, t * of(knowledge.sigma_mixed));
      put(PatchCells::kVisibility, v);
      for (int k = 0; k < 9; ++k) put(PatchCells::kControl + k, v * of(cells.vector_flux[k]));
      mixed += store_selected(is_mixed, id, mixed_ids + mixed);
    }
  });
  for (; above % kCellLanes != 0; ++above) {
    for (int k = 0; k < PatchCells::kAboveColumns; ++k) patch.above_column(k)[above] = 0;
    ids[above] = 0;
  }
  for (; mixed % kCellLanes != 0; ++mixed) {
    for (int k = 0; k < PatchCells::kMixedColumns; ++k) patch.mixed_column(k)[mixed] = 0;
    mixed_ids[mixed] = 0;
  }
  for (size_t i = 0; i < mixed; ++i) ids[above + i] = mixed_ids[i];
  patch.above = above;
  patch.mixed = mixed;
  for (int k = 0; k < 9; ++k) patch.control[k] = sum(control[k]);
}

float diffuse_strata(const PatchCells& patch, const GroupNormal& normal, float scale, float* p,
                     float* block_sums, float* mixed_visibility, float control[9],
                     float straddling[3]) {
  const Vec3 n(normal.world[0], normal.world[1], normal.world[2]);
  float total = 0;
  {
    const float* const sigma_x = patch.above_column(PatchCells::kSigmaX);
    const float* const sigma_y = patch.above_column(PatchCells::kSigmaY);
    const float* const sigma_z = patch.above_column(PatchCells::kSigmaZ);
    const float* const least = patch.above_column(PatchCells::kMinFlux);
    for (size_t i = 0; i < patch.above; i += kCellLanes) {
      total += * block_sums++ = sum_block(i, [&](size_t k) {
        const Float mean = dot(n, load(sigma_x, sigma_y, sigma_z, k));
        const Float value = max(mean, Float::load(least + k)) * scale;
        value.store(p + k);
        return value;
      });
    }
  }
  Float sums[9], over_horizon[3];
  for (Float& s : sums) s = 0.f;
  for (Float& s : over_horizon) s = 0.f;
  const float above_limit = normal.sine + kRounding, below_limit = -normal.sine - kRounding;
  for (size_t i = 0; i < patch.mixed; i += kCellLanes) {
    total += * block_sums++ = sum_block(i, [&](size_t k) {
      const auto column = [&](int c) { return Float::load(patch.mixed_column(c) + k); };
      const Range range =
          cosine_range(normal.local, [&](int c) { return column(PatchCells::kEdges + c); });
      const Mask is_above = range.lo >= above_limit, is_below = range.hi <= below_limit;
      const Vec3 flux(column(PatchCells::kFluxX), column(PatchCells::kFluxY),
                      column(PatchCells::kFluxZ));
      const Float least = select(is_above, kMinShare, kMixedShare * max(range.hi, kMinCosine));
      const Float sigma =
          select(is_above, column(PatchCells::kSigma), column(PatchCells::kSigmaMixed));
      const Float mean = max(dot(n, flux), column(PatchCells::kFlux) * least);
      Float value = select(!is_below, mean * sigma * scale);
      const Float v = column(PatchCells::kVisibility);
      if (patch.is_flat) {
        const Mask straddles = !(is_above || is_below);
        value = select(straddles,
                       max(column(PatchCells::kStraddlingSigma) * scale, kStraddlingShare * value),
                       value);
        select(is_above, v, select(straddles, -v)).store(mixed_visibility + k);
        for (int c = 0; c < 3; ++c) {
          over_horizon[c] += select(straddles, column(PatchCells::kStraddling + c));
        }
      } else {
        select(is_above, v).store(mixed_visibility + k);
      }
      value.store(p + patch.above + k);
      for (int c = 0; c < 9; ++c) sums[c] += select(is_above, column(PatchCells::kControl + c));
      return value;
    });
  }
  for (int k = 0; k < 9; ++k) control[k] = patch.control[k] + sum(sums[k]);
  for (int c = 0; c < 3; ++c) straddling[c] = sum(over_horizon[c]);
  return total;
}

float glossy_importance(const CellColumns& cells, const GlossyQuery& query, float* importance,
                        float* block_sums) {
  const Vec3 n(query.normal[0], query.normal[1], query.normal[2]);
  const Vec3 viewer(query.viewer[0], query.viewer[1], query.viewer[2]);
  const float width = query.alpha2 + query.spread;
  const float slack = 2 * std::sqrt(query.spread);
  float total = 0;
  for (size_t i = 0; i < cells.count; i += kCellLanes) {
    total += * block_sums++ = sum_block(i, [&](size_t k) {
      const Vec3 c = load(cells.axis, k), h = viewer + c;
      const Float cosine2 = max(sqr(dot(n, h)) / max(dot(h, h), 1e-12f), 1e-4f);
      const Float radius = Float::load(cells.radius + k);
      // A cell of radius r turns the half vector by about r / 2; half of its square is added to a2.
      const Float a2 = min(radius * radius * 0.125f + width, 1.f);
      const Float lobe = a2 / sqr(mul_add(cosine2, a2 - 1.f, 1.f));
      const Mask is_visible = dot(n, c) + (radius + slack) > 0.f;
      const Float value = select(is_visible, Float::load(cells.flux + k) * lobe);
      value.store(importance + k);
      return value;
    });
  }
  return total;
}

}  // namespace kinome::simd
