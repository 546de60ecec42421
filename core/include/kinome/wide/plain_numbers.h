#pragma once

// Part of kinome/wide/numbers.h: the same functions for plain numbers, which have one lane.

#include "kinome/wide/numbers.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Versions for plain numbers.
inline namespace formulas {

KINOME_WIDE bool any(Boolean auto a) {
  return a;
}
KINOME_WIDE bool all(Boolean auto a) {
  return a;
}
KINOME_WIDE bool none(Boolean auto a) {
  return !a;
}
KINOME_WIDE size_t count(Boolean auto a) {
  return a ? 1 : 0;
}

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
KINOME_WIDE float abs(Real auto a) {
  return std::abs(a);
}
KINOME_WIDE int32_t abs(std::same_as<int32_t> auto a) {
  return std::abs(a);
}
KINOME_WIDE float copysign(Real auto a, Real auto sign) {
  return std::copysign(a, sign);
}
KINOME_WIDE float sqrt(Real auto a) {
  return std::sqrt(a);
}
KINOME_WIDE float lerp(Real auto a, Real auto b, Real auto t) {
  return a * (1.f - t) + b * t;
}
KINOME_WIDE float floor(Real auto a) {
  return std::floor(a);
}
KINOME_WIDE float ceil(Real auto a) {
  return std::ceil(a);
}
KINOME_WIDE float round(Real auto a) {
  return std::nearbyint(a);
}
KINOME_WIDE bool is_nan(Real auto a) {
  return a != a;
}
KINOME_WIDE bool is_finite(Real auto a) {
  return std::abs(a) < HUGE_VALF;
}

template <int bits>
KINOME_WIDE int32_t shift_left(std::same_as<int32_t> auto a) {
  return a << bits;
}
template <int bits>
KINOME_WIDE int32_t shift_right(std::same_as<int32_t> auto a) {
  return a >> bits;
}
template <int bits>
KINOME_WIDE uint32_t shift_left(std::same_as<uint32_t> auto a) {
  return a << bits;
}
template <int bits>
KINOME_WIDE uint32_t shift_right(std::same_as<uint32_t> auto a) {
  return a >> bits;
}
KINOME_WIDE int32_t to_int(Real auto a) {
  return static_cast<int32_t>(a);
}
KINOME_WIDE int32_t round_to_int(Real auto a) {
  return static_cast<int32_t>(std::nearbyint(a));
}
KINOME_WIDE float to_float(Integer auto a) {
  return static_cast<float>(a);
}
KINOME_WIDE int32_t as_int(Real auto a) {
  return std::bit_cast<int32_t>(a);
}
KINOME_WIDE int32_t as_int(std::same_as<uint32_t> auto a) {
  return static_cast<int32_t>(a);
}
KINOME_WIDE uint32_t as_uint(Real auto a) {
  return std::bit_cast<uint32_t>(a);
}
KINOME_WIDE uint32_t as_uint(std::same_as<int32_t> auto a) {
  return static_cast<uint32_t>(a);
}
KINOME_WIDE float as_float(Integer auto a) {
  return std::bit_cast<float>(a);
}

KINOME_WIDE float gather(const float* p, std::same_as<int32_t> auto i) {
  return p[i];
}
KINOME_WIDE int32_t gather(const int32_t* p, std::same_as<int32_t> auto i) {
  return p[i];
}
KINOME_WIDE uint32_t gather(const uint32_t* p, std::same_as<int32_t> auto i) {
  return p[i];
}
KINOME_WIDE float sum(Real auto a) {
  return a;
}
KINOME_WIDE float smallest(Real auto a) {
  return a;
}
KINOME_WIDE float largest(Real auto a) {
  return a;
}

}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
