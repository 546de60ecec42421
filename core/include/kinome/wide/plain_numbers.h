#pragma once

// Part of kinome/wide/numbers.h: the same functions for plain numbers, which have one lane.

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Versions for plain numbers.
inline namespace formulas {

KINOME_WIDE_FUNCTION(bool, any, Boolean auto, a)
KINOME_WIDE_FUNCTION(bool, all, Boolean auto, a)
KINOME_WIDE_FUNCTION(bool, none, Boolean auto, !a)
KINOME_WIDE_FUNCTION(size_t, count, Boolean auto, a ? 1 : 0)

/// For numbers, masks and GLM's vectors.
template <class T>
KINOME_WIDE T select(bool m, const T& a, const std::type_identity_t<T>& b) {
  return m ? a : b;
}
template <class T>
KINOME_WIDE T select(bool m, const T& a) {
  return m ? a : T(0);
}

KINOME_WIDE float mul_add(Real auto a, Real auto b, Real auto c) {
  return a * b + c;
}
KINOME_WIDE float mul_sub(Real auto a, Real auto b, Real auto c) {
  return a * b - c;
}
KINOME_WIDE float neg_mul_add(Real auto a, Real auto b, Real auto c) {
  return c - a * b;
}
template <class T>
concept Number = Real<T> || Integer<T>;
template <Number T>
KINOME_WIDE T min(T a, T b) {
  return std::min(a, b);
}
template <Number T>
KINOME_WIDE T max(T a, T b) {
  return std::max(a, b);
}
template <Number T>
KINOME_WIDE T clamp(T a, T lo, T hi) {
  return min(max(a, lo), hi);
}
KINOME_WIDE_FUNCTION(float, abs, Real auto, std::abs(a))
KINOME_WIDE_FUNCTION(int32_t, abs, std::same_as<int32_t> auto, std::abs(a))
KINOME_WIDE float copysign(Real auto a, Real auto sign) {
  return std::copysign(a, sign);
}
KINOME_WIDE_FUNCTION(float, sqrt, Real auto, std::sqrt(a))
KINOME_WIDE float lerp(Real auto a, Real auto b, Real auto t) {
  return a * (1.f - t) + b * t;
}
KINOME_WIDE_FUNCTION(float, floor, Real auto, std::floor(a))
KINOME_WIDE_FUNCTION(float, ceil, Real auto, std::ceil(a))
KINOME_WIDE_FUNCTION(float, round, Real auto, std::nearbyint(a))
KINOME_WIDE_FUNCTION(bool, is_nan, Real auto, a != a)
KINOME_WIDE_FUNCTION(bool, is_finite, Real auto, std::abs(a) < HUGE_VALF)

KINOME_WIDE_FUNCTION(int32_t, to_int, Real auto, static_cast<int32_t>(a))
KINOME_WIDE_FUNCTION(int32_t, round_to_int, Real auto, static_cast<int32_t>(std::nearbyint(a)))
KINOME_WIDE_FUNCTION(float, to_float, Integer auto, static_cast<float>(a))
KINOME_WIDE_FUNCTION(int32_t, as_int, Real auto, std::bit_cast<int32_t>(a))
KINOME_WIDE_FUNCTION(int32_t, as_int, std::same_as<uint32_t> auto, static_cast<int32_t>(a))
KINOME_WIDE_FUNCTION(uint32_t, as_uint, Real auto, std::bit_cast<uint32_t>(a))
KINOME_WIDE_FUNCTION(uint32_t, as_uint, std::same_as<int32_t> auto, static_cast<uint32_t>(a))
KINOME_WIDE_FUNCTION(float, as_float, Integer auto, std::bit_cast<float>(a))
KINOME_WIDE_FUNCTION(float, sum, Real auto, a)
KINOME_WIDE_FUNCTION(float, smallest, Real auto, a)
KINOME_WIDE_FUNCTION(float, largest, Real auto, a)

template <int bits, Integer T>
KINOME_WIDE T shift_left(T a) {
  return a << bits;
}
template <int bits, Integer T>
KINOME_WIDE T shift_right(T a) {
  return a >> bits;
}
template <Number T>
KINOME_WIDE T gather(const T* p, std::same_as<int32_t> auto i) {
  return p[i];
}

}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
