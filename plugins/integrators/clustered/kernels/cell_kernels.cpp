#include "clustered/kernels/cell_kernels.h"

// A scalar target, too, wherever the baseline is one: tests compare with it.
#define HWY_COMPILE_ALL_ATTAINABLE
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "clustered/kernels/cell_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace kinome::simd {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kCellLanes>;
using V = hn::Vec<Tag>;
using IdTag = hn::RebindToUnsigned<Tag>;

/// What a mixed cell may count of its flux where its mean says less, per cosine of its highest
/// point; and the least of that cosine.
constexpr float kMixedShare = 0.4f;
constexpr float kLeastCosine = 0.02f;
/// The least that a cell counts, as a share of its flux: its importance flux may point elsewhere.
constexpr float kLeastShare = 1e-3f;
/// Rounding of the bounds.
constexpr float kRounding = 1e-6f;

struct Range {
  V lo, hi;
};

/// The smallest and largest cosine between a normal n and the directions of a rectangle in
/// latitude and longitude, d = (sin phi sin theta, cos theta, -cos phi sin theta): exact up to
/// rounding. Along phi the cosine is a sine curve (its extremes lie at the ends or where the slope
/// changes its sign in between), along theta again one.
template <class Column>
HWY_INLINE Range cosine_range(const float n[3], const Column& edge) {
  const Tag d;
  const V zero = hn::Zero(d);
  const V nx = hn::Set(d, n[0]), ny = hn::Set(d, n[1]), nz = hn::Set(d, n[2]);
  const float amplitude = std::sqrt(n[0] * n[0] + n[2] * n[2]);
  const V s0 = edge(0), c0 = edge(1), s1 = edge(2), c1 = edge(3);
  const V g0 = hn::NegMulAdd(nz, c0, hn::Mul(nx, s0));
  const V g1 = hn::NegMulAdd(nz, c1, hn::Mul(nx, s1));
  const V slope0 = hn::MulAdd(nz, s0, hn::Mul(nx, c0));
  const V slope1 = hn::MulAdd(nz, s1, hn::Mul(nx, c1));
  const auto dips = hn::And(hn::Lt(slope0, zero), hn::Gt(slope1, zero));
  const auto peaks = hn::And(hn::Gt(slope0, zero), hn::Lt(slope1, zero));
  const V low = hn::IfThenElse(dips, hn::Set(d, -amplitude), hn::Min(g0, g1));
  const V high = hn::IfThenElse(peaks, hn::Set(d, amplitude), hn::Max(g0, g1));

  const V cos0 = edge(4), sin0 = edge(5), cos1 = edge(6), sin1 = edge(7);
  const V y0 = hn::Mul(ny, cos0), y1 = hn::Mul(ny, cos1), ny2 = hn::Mul(ny, ny);
  Range range;
  {
    const V at0 = hn::MulAdd(low, sin0, y0), at1 = hn::MulAdd(low, sin1, y1);
    const V d0 = hn::NegMulAdd(ny, sin0, hn::Mul(low, cos0));
    const V d1 = hn::NegMulAdd(ny, sin1, hn::Mul(low, cos1));
    const auto inside = hn::And(hn::Lt(d0, zero), hn::Gt(d1, zero));
    const V extreme = hn::Neg(hn::Sqrt(hn::MulAdd(low, low, ny2)));
    range.lo = hn::IfThenElse(inside, extreme, hn::Min(at0, at1));
  }
  const V at0 = hn::MulAdd(high, sin0, y0), at1 = hn::MulAdd(high, sin1, y1);
  const V d0 = hn::NegMulAdd(ny, sin0, hn::Mul(high, cos0));
  const V d1 = hn::NegMulAdd(ny, sin1, hn::Mul(high, cos1));
  const auto inside = hn::And(hn::Gt(d0, zero), hn::Lt(d1, zero));
  const V extreme = hn::Sqrt(hn::MulAdd(high, high, ny2));
  range.hi = hn::IfThenElse(inside, extreme, hn::Max(at0, at1));
  return range;
}

/// The lanes of the mask, one after the other; what lies behind them, up to a vector's length, is
/// overwritten. (To compress into memory takes some processors a hundred cycles.)
template <class D, class Vector, class Mask>
HWY_INLINE void store_compressed(Vector values, Mask mask, D d, hn::TFromD<D>* to) {
  hn::StoreU(hn::Compress(values, mask), d, to);
}

void ClassifyCells(const CellColumns& cells, const float local[3], float sine,
                   const CellKnowledge& know, const float* transmittance, PatchCells& patch) {
  const Tag d;
  const IdTag du;
  const size_t lanes = hn::Lanes(d);
  const V zero = hn::Zero(d);
  V control[9];
  for (V& c : control) c = zero;
  size_t above = 0, mixed = 0;
  uint32_t* const ids = patch.ids();
  // Mixed ids are kept behind all that could be above, and moved up in the end.
  uint32_t* const mixed_ids = ids + cells.count + kCellLanes;
  for (size_t i = 0; i < cells.count; i += lanes) {
    const Range range =
        cosine_range(local, [&](int k) { return hn::LoadU(d, cells.edges[k] + i); });
    const auto lit = hn::Gt(hn::LoadU(d, cells.flux + i), zero);
    const auto is_above = hn::And(lit, hn::Ge(range.lo, hn::Set(d, sine + kRounding)));
    const auto is_below = hn::Le(range.hi, hn::Set(d, -sine - kRounding));
    const auto is_mixed = hn::AndNot(hn::Or(is_above, is_below), lit);
    const V t = transmittance ? hn::LoadU(d, transmittance + i) : hn::Set(d, 1.f);
    const V v = hn::Mul(t, hn::LoadU(d, know.visibility + i));
    const V sigma = hn::Mul(t, hn::LoadU(d, know.sigma + i));
    const auto id = hn::Iota(du, static_cast<uint32_t>(i));
    if (!hn::AllFalse(d, is_above)) {
      for (int k = 0; k < 9; ++k) {
        control[k] = hn::Add(
            control[k],
            hn::IfThenElseZero(is_above, hn::Mul(v, hn::LoadU(d, cells.vector_flux[k] + i))));
      }
      for (int axis = 0; axis < 3; ++axis) {
        store_compressed(hn::Mul(sigma, hn::LoadU(d, cells.importance_flux[axis] + i)), is_above, d,
                         patch.above_column(PatchCells::kSigmaX + axis) + above);
      }
      store_compressed(
          hn::Mul(hn::Mul(sigma, hn::Set(d, kLeastShare)), hn::LoadU(d, cells.flux + i)), is_above,
          d, patch.above_column(PatchCells::kLeast) + above);
      store_compressed(id, hn::RebindMask(du, is_above), du, ids + above);
      above += hn::CountTrue(d, is_above);
    }
    if (!hn::AllFalse(d, is_mixed)) {
      const auto put = [&](int column, V value) {
        store_compressed(value, is_mixed, d, patch.mixed_column(column) + mixed);
      };
      for (int k = 0; k < 8; ++k) put(PatchCells::kEdges + k, hn::LoadU(d, cells.edges[k] + i));
      for (int axis = 0; axis < 3; ++axis) {
        put(PatchCells::kFluxX + axis, hn::LoadU(d, cells.importance_flux[axis] + i));
      }
      put(PatchCells::kFlux, hn::LoadU(d, cells.flux + i));
      put(PatchCells::kSigma, sigma);
      put(PatchCells::kSigmaMixed, hn::Mul(t, hn::LoadU(d, know.sigma_mixed + i)));
      put(PatchCells::kVisibility, v);
      for (int k = 0; k < 9; ++k) {
        put(PatchCells::kControl + k, hn::Mul(v, hn::LoadU(d, cells.vector_flux[k] + i)));
      }
      store_compressed(id, hn::RebindMask(du, is_mixed), du, mixed_ids + mixed);
      mixed += hn::CountTrue(d, is_mixed);
    }
  }
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
  for (int k = 0; k < 9; ++k) patch.control[k] = hn::GetLane(hn::SumOfLanes(d, control[k]));
}

float DiffuseStrata(const PatchCells& patch, const GroupNormal& normal, float scale, float* p,
                    float* block_sums, float* mixed_visibility, float control[9]) {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const V zero = hn::Zero(d);
  const V scales = hn::Set(d, scale);
  float total = 0;
  const auto finish_block = [&](size_t block, V sum) {
    const float value = hn::GetLane(hn::SumOfLanes(d, sum));
    block_sums[block] = value;
    total += value;
  };
  {
    const V nx = hn::Set(d, normal.world[0] * scale), ny = hn::Set(d, normal.world[1] * scale),
            nz = hn::Set(d, normal.world[2] * scale);
    const float* const sx = patch.above_column(PatchCells::kSigmaX);
    const float* const sy = patch.above_column(PatchCells::kSigmaY);
    const float* const sz = patch.above_column(PatchCells::kSigmaZ);
    const float* const least = patch.above_column(PatchCells::kLeast);
    for (size_t block = 0; block < patch.above / kCellLanes; ++block) {
      V sum = zero;
      for (size_t i = block * kCellLanes; i < (block + 1) * kCellLanes; i += lanes) {
        V value = hn::Mul(nx, hn::LoadU(d, sx + i));
        value = hn::MulAdd(ny, hn::LoadU(d, sy + i), value);
        value = hn::MulAdd(nz, hn::LoadU(d, sz + i), value);
        value = hn::Max(value, hn::Mul(scales, hn::LoadU(d, least + i)));
        hn::StoreU(value, d, p + i);
        sum = hn::Add(sum, value);
      }
      finish_block(block, sum);
    }
  }
  V sums[9];
  for (V& s : sums) s = zero;
  const V nx = hn::Set(d, normal.world[0]), ny = hn::Set(d, normal.world[1]),
          nz = hn::Set(d, normal.world[2]);
  const V above_limit = hn::Set(d, normal.sine + kRounding);
  const V below_limit = hn::Set(d, -normal.sine - kRounding);
  float* const mixed_p = p + patch.above;
  for (size_t block = 0; block < patch.mixed / kCellLanes; ++block) {
    V sum = zero;
    for (size_t i = block * kCellLanes; i < (block + 1) * kCellLanes; i += lanes) {
      const auto column = [&](int k) { return hn::LoadU(d, patch.mixed_column(k) + i); };
      const Range range =
          cosine_range(normal.local, [&](int k) { return column(PatchCells::kEdges + k); });
      const auto is_above = hn::Ge(range.lo, above_limit);
      const auto is_below = hn::Le(range.hi, below_limit);
      const V flux = column(PatchCells::kFlux);
      V mean = hn::Mul(nx, column(PatchCells::kFluxX));
      mean = hn::MulAdd(ny, column(PatchCells::kFluxY), mean);
      mean = hn::MulAdd(nz, column(PatchCells::kFluxZ), mean);
      const V least = hn::IfThenElse(
          is_above, hn::Set(d, kLeastShare),
          hn::Mul(hn::Set(d, kMixedShare), hn::Max(range.hi, hn::Set(d, kLeastCosine))));
      const V sigma =
          hn::IfThenElse(is_above, column(PatchCells::kSigma), column(PatchCells::kSigmaMixed));
      V value = hn::Mul(hn::Mul(hn::Max(mean, hn::Mul(flux, least)), sigma), scales);
      value = hn::IfThenZeroElse(is_below, value);
      hn::StoreU(value, d, mixed_p + i);
      sum = hn::Add(sum, value);
      hn::StoreU(hn::IfThenElseZero(is_above, column(PatchCells::kVisibility)), d,
                 mixed_visibility + i);
      for (int k = 0; k < 9; ++k) {
        sums[k] = hn::Add(sums[k], hn::IfThenElseZero(is_above, column(PatchCells::kControl + k)));
      }
    }
    finish_block(patch.above / kCellLanes + block, sum);
  }
  for (int k = 0; k < 9; ++k) {
    control[k] = patch.control[k] + hn::GetLane(hn::SumOfLanes(d, sums[k]));
  }
  return total;
}

float GlossyImportance(const CellColumns& cells, const GlossyQuery& q, float* importance,
                       float* block_sums) {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  const V one = hn::Set(d, 1.f);
  const V nx = hn::Set(d, q.normal[0]), ny = hn::Set(d, q.normal[1]), nz = hn::Set(d, q.normal[2]);
  const V ox = hn::Set(d, q.viewer[0]), oy = hn::Set(d, q.viewer[1]), oz = hn::Set(d, q.viewer[2]);
  const V width = hn::Set(d, q.alpha2 + q.spread);
  // A cell of radius r turns the half vector by about r / 2; half of that squared is its share.
  const V extent = hn::Set(d, 0.125f);
  const V slack = hn::Set(d, 2 * std::sqrt(q.spread));
  float total = 0;
  for (size_t block = 0; block < cells.count / kCellLanes; ++block) {
    V sum = hn::Zero(d);
    for (size_t i = block * kCellLanes; i < (block + 1) * kCellLanes; i += lanes) {
      const V cx = hn::LoadU(d, cells.axis[0] + i), cy = hn::LoadU(d, cells.axis[1] + i),
              cz = hn::LoadU(d, cells.axis[2] + i);
      const V hx = hn::Add(ox, cx), hy = hn::Add(oy, cy), hz = hn::Add(oz, cz);
      const V hh = hn::MulAdd(hx, hx, hn::MulAdd(hy, hy, hn::Mul(hz, hz)));
      const V nh = hn::MulAdd(nx, hx, hn::MulAdd(ny, hy, hn::Mul(nz, hz)));
      const V cosine2 =
          hn::Max(hn::Set(d, 1e-4f), hn::Div(hn::Mul(nh, nh), hn::Max(hh, hn::Set(d, 1e-12f))));
      const V radius = hn::LoadU(d, cells.radius + i);
      const V a2 = hn::Min(one, hn::MulAdd(hn::Mul(radius, radius), extent, width));
      const V denominator = hn::MulAdd(cosine2, hn::Sub(a2, one), one);
      const V lobe = hn::Div(a2, hn::Mul(denominator, denominator));
      const V nc = hn::MulAdd(nx, cx, hn::MulAdd(ny, cy, hn::Mul(nz, cz)));
      const auto visible = hn::Gt(hn::Add(nc, hn::Add(radius, slack)), hn::Zero(d));
      const V value = hn::IfThenElseZero(visible, hn::Mul(hn::LoadU(d, cells.flux + i), lobe));
      hn::StoreU(value, d, importance + i);
      sum = hn::Add(sum, value);
    }
    block_sums[block] = hn::GetLane(hn::SumOfLanes(d, sum));
    total += block_sums[block];
  }
  return total;
}

float SumBlocks(const float* values, size_t count, float* block_sums) {
  const Tag d;
  const size_t lanes = hn::Lanes(d);
  float total = 0;
  for (size_t block = 0; block < count / kCellLanes; ++block) {
    V sum = hn::Zero(d);
    for (size_t i = block * kCellLanes; i < (block + 1) * kCellLanes; i += lanes) {
      sum = hn::Add(sum, hn::LoadU(d, values + i));
    }
    block_sums[block] = hn::GetLane(hn::SumOfLanes(d, sum));
    total += block_sums[block];
  }
  return total;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinome::simd {

HWY_EXPORT(ClassifyCells);
HWY_EXPORT(DiffuseStrata);
HWY_EXPORT(GlossyImportance);
HWY_EXPORT(SumBlocks);

void PatchCells::reserve(size_t padded_cells) {
  // A compressed store writes a whole vector, and mixed ids lie behind those above.
  const size_t needed = padded_cells + 2 * kCellLanes;
  if (stride_ >= needed) return;
  stride_ = needed;
  above_.resize(kAboveColumns * stride_);
  mixed_.resize(kMixedColumns * stride_);
  ids_.resize(2 * stride_);
}

void classify_cells(const CellColumns& cells, const float local_normal[3], float sine,
                    const CellKnowledge& knowledge, const float* transmittance, PatchCells& patch) {
  patch.reserve(cells.count);
  HWY_DYNAMIC_DISPATCH(ClassifyCells)
  (cells, local_normal, sine, knowledge, transmittance, patch);
}

float diffuse_strata(const PatchCells& patch, const GroupNormal& normal, float scale, float* p,
                     float* block_sums, float* mixed_visibility, float control[9]) {
  return HWY_DYNAMIC_DISPATCH(DiffuseStrata)(patch, normal, scale, p, block_sums, mixed_visibility,
                                             control);
}

float glossy_importance(const CellColumns& cells, const GlossyQuery& query, float* importance,
                        float* block_sums) {
  return HWY_DYNAMIC_DISPATCH(GlossyImportance)(cells, query, importance, block_sums);
}

float sum_blocks(const float* values, size_t count, float* block_sums) {
  return HWY_DYNAMIC_DISPATCH(SumBlocks)(values, count, block_sums);
}

}  // namespace kinome::simd
#endif
