#pragma once

// Part of kinome/wide/numbers.h: operations across lanes, and memory access by lane indices.

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Loads p[i] in each lane; indices must not be negative.
KINOME_WIDE Float gather(const float* p, Int i) {
  return Float(hn::GatherIndex(FloatTag(), p, i.v));
}
KINOME_WIDE Int gather(const int32_t* p, Int i) {
  return Int(hn::GatherIndex(IntTag(), p, i.v));
}
KINOME_WIDE Uint gather(const uint32_t* p, Int i) {
  return Uint(hn::GatherIndex(UintTag(), p, i.v));
}
/// Selects lanes by index: lane i of a, with 0 <= i < kLanes; or lane i of a followed by b, with
/// 0 <= i < 2 kLanes.
KINOME_WIDE Float pick(Float a, Int i) {
  return Float(hn::TableLookupLanes(a.v, hn::IndicesFromVec(FloatTag(), i.v)));
}
KINOME_WIDE Float pick(Float a, Float b, Int i) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Float(hn::Vec<FloatTag>{_mm512_permutex2var_ps(a.v.raw, i.v.raw, b.v.raw)});
#else
  constexpr auto lanes = static_cast<int32_t>(kLanes);
  const Int within = i & (lanes - 1);
  return select(i < lanes, pick(a, within), pick(b, within));
#endif
}
KINOME_WIDE Uint pick(Uint a, Uint b, Int i) {
  return as_uint(pick(as_float(a), as_float(b), i));
}
/// Index of each lane: 0, 1, 2 ...
KINOME_WIDE Int iota() {
  return Int(hn::Iota(IntTag(), 0));
}

/// Transposes between four vectors and rows of four numbers in memory, one row per lane.
KINOME_WIDE void store_rows(Float a, Float b, Float c, Float d, float* p) {
  hn::StoreInterleaved4(a.v, b.v, c.v, d.v, FloatTag(), p);
}
KINOME_WIDE void load_rows(const float* p, Float& a, Float& b, Float& c, Float& d) {
  hn::LoadInterleaved4(FloatTag(), p, a.v, b.v, c.v, d.v);
}

/// Reductions over the lanes. The summation order depends on the instruction set.
KINOME_WIDE_FUNCTION(float, sum, Float, hn::GetLane(hn::SumOfLanes(FloatTag(), a.v)))
KINOME_WIDE_FUNCTION(float, smallest, Float, hn::GetLane(hn::MinOfLanes(FloatTag(), a.v)))
KINOME_WIDE_FUNCTION(float, largest, Float, hn::GetLane(hn::MaxOfLanes(FloatTag(), a.v)))
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
/// For each mask of kLanes bits, the indices of its set lanes, in order. Highway's Compress keeps
/// this table inside the function; GCC then copies it to the stack in each call, which takes most
/// of the time.
struct SelectedLanes {
  uint8_t of_mask[size_t{1} << kLanes][kLanes];
  constexpr SelectedLanes() : of_mask() {
    for (size_t mask = 0; mask < size_t{1} << kLanes; ++mask) {
      size_t next = 0;
      for (size_t lane = 0; lane < kLanes; ++lane) {
        if (mask >> lane & 1) of_mask[mask][next++] = static_cast<uint8_t>(lane);
      }
    }
  }
};
alignas(64) inline constexpr SelectedLanes kSelectedLanes;
#endif

/// Returns the values of true lanes first, in order; the remaining lanes are undefined.
KINOME_WIDE Float selected_first(Mask m, Float a) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  uint8_t bits[8];  // as many as Highway may write
  hn::StoreMaskBits(FloatTag(), m.v, bits);
  const hn::Rebind<uint8_t, IntTag> bytes;
  return pick(a, Int(hn::PromoteTo(IntTag(), hn::LoadU(bytes, kSelectedLanes.of_mask[bits[0]]))));
#else
  return Float(hn::Compress(a.v, m.v));
#endif
}

/// Stores the values of true lanes at p, in order, and returns their number. May overwrite all of
/// p[0 … kLanes - 1].
KINOME_WIDE size_t store_selected(Mask m, Float a, float* p) {
  selected_first(m, a).store(p);
  return count(m);
}
KINOME_WIDE size_t store_selected(Mask m, Uint a, uint32_t* p) {
  as_uint(selected_first(m, as_float(a))).store(p);
  return count(m);
}
/// Same, but leaves the memory after the last value unchanged.
KINOME_WIDE size_t store_only_selected(Mask m, Uint a, uint32_t* p) {
  const size_t n = count(m);
  const Uint first = as_uint(selected_first(m, as_float(a)));
  hn::BlendedStore(first.v, hn::FirstN(UintTag(), n), UintTag(), p);
  return n;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
