#pragma once

// Four vectors at once: their transpose, and their sums over the lanes.

#include <cstring>

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Transposes four vectors to rows of four numbers in memory, one row per lane, each `stride`
/// numbers after the last.
KINOME_WIDE void store_rows(Float a, Float b, Float c, Float d, float* p, size_t stride) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  const FloatTag tag;
  const hn::Repartition<double, FloatTag> pair;
  const auto low_ab = hn::BitCast(pair, hn::InterleaveLower(tag, a.v, b.v));
  const auto low_cd = hn::BitCast(pair, hn::InterleaveLower(tag, c.v, d.v));
  const auto high_ab = hn::BitCast(pair, hn::InterleaveUpper(tag, a.v, b.v));
  const auto high_cd = hn::BitCast(pair, hn::InterleaveUpper(tag, c.v, d.v));
  // Each quarter of `of_four` is the row of one lane, which is four after the lane of the last.
  const auto store = [&](const hn::Vec<FloatTag>& of_four, float* to) {
    const hn::Half<FloatTag> half;
    const hn::Half<decltype(half)> quarter;
    const auto low = hn::LowerHalf(half, of_four), high = hn::UpperHalf(half, of_four);
    hn::StoreU(hn::LowerHalf(quarter, low), quarter, to);
    hn::StoreU(hn::UpperHalf(quarter, low), quarter, to + 4 * stride);
    hn::StoreU(hn::LowerHalf(quarter, high), quarter, to + 8 * stride);
    hn::StoreU(hn::UpperHalf(quarter, high), quarter, to + 12 * stride);
  };
  store(hn::BitCast(tag, hn::InterleaveLower(pair, low_ab, low_cd)), p);
  store(hn::BitCast(tag, hn::InterleaveUpper(pair, low_ab, low_cd)), p + stride);
  store(hn::BitCast(tag, hn::InterleaveLower(pair, high_ab, high_cd)), p + 2 * stride);
  store(hn::BitCast(tag, hn::InterleaveUpper(pair, high_ab, high_cd)), p + 3 * stride);
#else
  float rows[4 * kLanes];
  store_rows(a, b, c, d, rows);
  for (size_t i = 0; i < kLanes; ++i) {
    std::memcpy(p + i * stride, rows + 4 * i, 4 * sizeof(float));
  }
#endif
}

/// Stores the sums over the lanes of four vectors. They have the same bits as sum().
KINOME_WIDE void store_sums(const Float* vectors, float* p) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL || HWY_TARGET == HWY_AVX2
  const hn::FixedTag<float, 4> four;
  const auto fold = [&](const Float& a) {
    const hn::Half<FloatTag> half;
    const auto folded = hn::Add(hn::LowerHalf(half, a.v), hn::UpperHalf(half, a.v));
#if HWY_TARGET == HWY_AVX2
    return folded;
#else
    return hn::Add(hn::LowerHalf(four, folded), hn::UpperHalf(four, folded));
#endif
  };
  const auto fold_two = [&](const Float& first, const Float& second) {
    const auto a = fold(first), b = fold(second);
    return hn::Add(hn::InterleaveLower(four, a, b), hn::InterleaveUpper(four, a, b));
  };
  const auto ab = fold_two(vectors[0], vectors[1]), cd = fold_two(vectors[2], vectors[3]);
  hn::StoreU(hn::Add(hn::ConcatLowerLower(four, cd, ab), hn::ConcatUpperUpper(four, cd, ab)), four,
             p);
#else
  for (size_t i = 0; i < 4; ++i) p[i] = sum(vectors[i]);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
