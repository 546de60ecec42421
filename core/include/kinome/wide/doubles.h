#pragma once

// Double precision with as many lanes as wide::Float, for shapes that need more accuracy than float
// has. Formulas over D are for double and wide::Double and give the same bits for both, because
// nothing is contracted. FloatOf<D> is the single-precision number of D, DoubleOf<F> the reverse;
// comparisons return Float's masks.

#include "kinome/wide/functions.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Half of a number's lanes in each precision, or the only lane.
using HalfTag = hn::CappedTag<float, (kLanes + 1) / 2>;
using DoubleTag = hn::Rebind<double, HalfTag>;

template <class T>
concept PlainDouble = std::same_as<T, double>;
/// Types that convert to a Double with equal lanes.
template <class T>
concept DoubleLiteral = PlainDouble<T> || std::same_as<T, int>;

struct Double {
  hn::Vec<DoubleTag> low, high;  ///< first and second half of the lanes

  Double() = default;
  KINOME_WIDE Double(hn::Vec<DoubleTag> l, hn::Vec<DoubleTag> h) : low(l), high(h) {}
  KINOME_WIDE Double(DoubleLiteral auto x)
      : low(hn::Set(DoubleTag(), static_cast<double>(x))), high(low) {}
};

KINOME_WIDE Double to_double(Float a) {
#if HWY_TARGET == HWY_SCALAR
  const auto v = hn::PromoteTo(DoubleTag(), a.v);
  return {v, v};
#else
  return {hn::PromoteTo(DoubleTag(), hn::LowerHalf(HalfTag(), a.v)),
          hn::PromoteTo(DoubleTag(), hn::UpperHalf(HalfTag(), a.v))};
#endif
}
/// Rounds to single precision; infinity if out of range.
KINOME_WIDE Float to_float(Double a) {
#if HWY_TARGET == HWY_SCALAR
  // Highway's own demotion stops at the largest finite number here.
  return Float(static_cast<float>(hn::GetLane(a.low)));
#else
  return Float(
      hn::Combine(FloatTag(), hn::DemoteTo(HalfTag(), a.high), hn::DemoteTo(HalfTag(), a.low)));
#endif
}

#define KINOME_WIDE_OPERATOR(op, function)                                   \
  KINOME_WIDE Double operator op(Double a, Double b) {                       \
    return {hn::function(a.low, b.low), hn::function(a.high, b.high)};       \
  }                                                                          \
  KINOME_WIDE Double& operator op##=(Double& a, Double b) {                  \
    return a = a op b;                                                       \
  }
KINOME_WIDE_OPERATOR(+, Add)
KINOME_WIDE_OPERATOR(-, Sub)
KINOME_WIDE_OPERATOR(*, Mul)
KINOME_WIDE_OPERATOR(/, Div)
#undef KINOME_WIDE_OPERATOR
KINOME_WIDE Double operator-(Double a) {
  return {hn::Neg(a.low), hn::Neg(a.high)};
}

namespace detail {

using DoubleMask = hn::Mask<DoubleTag>;

/// Conversion between one single-precision mask and the double-precision masks of both halves.
KINOME_WIDE Mask joined(DoubleMask low, DoubleMask high) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Mask(hn::Mask<FloatTag>{
      static_cast<__mmask16>(static_cast<unsigned>(low.raw) | static_cast<unsigned>(high.raw) << 8)});
#else
  const auto one = hn::Set(DoubleTag(), 1.0);
  return to_float(wide::Double(hn::IfThenElseZero(low, one), hn::IfThenElseZero(high, one))) > 0.f;
#endif
}
struct DoubleMasks {
  DoubleMask low, high;
};
KINOME_WIDE DoubleMasks halves(Mask m) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return {DoubleMask{static_cast<__mmask8>(m.v.raw)}, DoubleMask{static_cast<__mmask8>(m.v.raw >> 8)}};
#else
  const wide::Double ones = to_double(select(m, 1.f));
  const auto zero = hn::Zero(DoubleTag());
  return {hn::Gt(ones.low, zero), hn::Gt(ones.high, zero)};
#endif
}

}  // namespace detail

#define KINOME_WIDE_COMPARISON(op, function)                                         \
  KINOME_WIDE Mask operator op(Double a, Double b) {                                 \
    return detail::joined(hn::function(a.low, b.low), hn::function(a.high, b.high)); \
  }
KINOME_WIDE_COMPARISON(<, Lt)
KINOME_WIDE_COMPARISON(<=, Le)
KINOME_WIDE_COMPARISON(>, Gt)
KINOME_WIDE_COMPARISON(>=, Ge)
KINOME_WIDE_COMPARISON(==, Eq)
#undef KINOME_WIDE_COMPARISON
KINOME_WIDE Mask operator!=(Double a, Double b) {
  return !(a == b);
}

KINOME_WIDE Double select(Mask m, Double a, Double b) {
  const auto [low, high] = detail::halves(m);
  return {hn::IfThenElse(low, a.low, b.low), hn::IfThenElse(high, a.high, b.high)};
}
KINOME_WIDE Double sqrt(Double a) {
  return {hn::Sqrt(a.low), hn::Sqrt(a.high)};
}
KINOME_WIDE Double abs(Double a) {
  return {hn::Abs(a.low), hn::Abs(a.high)};
}
KINOME_WIDE Double copysign(Double a, Double sign) {
  return {hn::CopySign(a.low, sign.low), hn::CopySign(a.high, sign.high)};
}
/// Same treatment of NaN and signed zeros as for Float.
KINOME_WIDE Double min(Double a, Double b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return {hn::Min(b.low, a.low), hn::Min(b.high, a.high)};
#else
  return {hn::IfThenElse(hn::Lt(b.low, a.low), b.low, a.low),
          hn::IfThenElse(hn::Lt(b.high, a.high), b.high, a.high)};
#endif
}
KINOME_WIDE Double max(Double a, Double b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return {hn::Max(b.low, a.low), hn::Max(b.high, a.high)};
#else
  return {hn::IfThenElse(hn::Lt(a.low, b.low), b.low, a.low),
          hn::IfThenElse(hn::Lt(a.high, b.high), b.high, a.high)};
#endif
}
KINOME_WIDE Mask is_finite(Double a) {
  return abs(a) < HUGE_VAL;
}

/// Rounds to the nearest integer, halves to even; for |a| < 2^51.
KINOME_WIDE Double round(Double a) {
  const Double rounder = 0x1.8p52;
  return (a + rounder) - rounder;
}

/// For wide numbers, the following functions have only float's accuracy: 2^-23, and 4 ulp of a
/// float.
inline void sincos(Double x, Double& s, Double& c) {
  const Double n = round(x * (2 * std::numbers::inv_pi));
  const Float r = to_float(x - n * (std::numbers::pi / 2));
  Float sine, cosine;
  detail::sincos(detail::Quadrant{r, to_int(to_float(n))}, sine, cosine);
  s = to_double(sine);
  c = to_double(cosine);
}
inline Double atan2(Double y, Double x) {
  return to_double(atan2(to_float(y), to_float(x)));
}

/// Position or direction in each lane.
struct DVec3 {
  Double x, y, z;

  DVec3() = default;
  KINOME_WIDE DVec3(Double x_, Double y_, Double z_) : x(x_), y(y_), z(z_) {}
  KINOME_WIDE DVec3(const glm::dvec3& a) : x(a.x), y(a.y), z(a.z) {}
};

KINOME_WIDE DVec3 operator+(DVec3 a, DVec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
KINOME_WIDE DVec3 operator-(DVec3 a, DVec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
KINOME_WIDE DVec3 operator-(DVec3 a) {
  return {-a.x, -a.y, -a.z};
}
KINOME_WIDE DVec3 operator*(DVec3 a, Double b) {
  return {a.x * b, a.y * b, a.z * b};
}
KINOME_WIDE DVec3 operator/(DVec3 a, Double b) {
  return {a.x / b, a.y / b, a.z / b};
}
KINOME_WIDE DVec3 operator*(const glm::dmat3& m, DVec3 a) {
  return {m[0][0] * a.x + m[1][0] * a.y + m[2][0] * a.z,
          m[0][1] * a.x + m[1][1] * a.y + m[2][1] * a.z,
          m[0][2] * a.x + m[1][2] * a.y + m[2][2] * a.z};
}
/// Product with the transpose of m.
KINOME_WIDE DVec3 operator*(DVec3 a, const glm::dmat3& m) {
  return {m[0][0] * a.x + m[0][1] * a.y + m[0][2] * a.z,
          m[1][0] * a.x + m[1][1] * a.y + m[1][2] * a.z,
          m[2][0] * a.x + m[2][1] * a.y + m[2][2] * a.z};
}
KINOME_WIDE DVec3 select(Mask m, DVec3 a, DVec3 b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
KINOME_WIDE Double dot(DVec3 a, DVec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
KINOME_WIDE Double length(DVec3 a) {
  return sqrt(dot(a, a));
}
KINOME_WIDE DVec3 normalize(DVec3 a) {
  return a * (1.0 / length(a));
}
KINOME_WIDE DVec3 to_double(Vec3 a) {
  return {to_double(a.x), to_double(a.y), to_double(a.z)};
}
KINOME_WIDE Vec3 to_float(DVec3 a) {
  return {to_float(a.x), to_float(a.y), to_float(a.z)};
}

template <>
struct NumberTraits<double> {
  using Mask = bool;
};
template <>
struct NumberTraits<Double> {
  using Mask = wide::Mask;
};
template <class N>
struct Precisions;
template <>
struct Precisions<float> {
  using OtherNumber = double;
};
template <>
struct Precisions<Float> {
  using OtherNumber = Double;
};
template <>
struct Precisions<double> {
  using OtherNumber = float;
  using DVec3 = glm::dvec3;
};
template <>
struct Precisions<Double> {
  using OtherNumber = Float;
  using DVec3 = wide::DVec3;
};

inline namespace formulas {

template <class F>
using DoubleOf = typename Precisions<F>::OtherNumber;
template <class D>
using FloatOf = typename Precisions<D>::OtherNumber;
template <class D>
using DVecOf = typename Precisions<D>::DVec3;

KINOME_WIDE double to_double(Real auto a) {
  return a;
}
KINOME_WIDE float to_float(PlainDouble auto a) {
  return static_cast<float>(a);
}
KINOME_WIDE glm::dvec3 to_double(const glm::vec3& a) {
  return glm::dvec3(a);
}
KINOME_WIDE glm::vec3 to_float(const glm::dvec3& a) {
  return glm::vec3(a);
}
KINOME_WIDE double sqrt(PlainDouble auto a) {
  return std::sqrt(a);
}
KINOME_WIDE double abs(PlainDouble auto a) {
  return std::abs(a);
}
KINOME_WIDE double copysign(PlainDouble auto a, PlainDouble auto sign) {
  return std::copysign(a, sign);
}
KINOME_WIDE double min(PlainDouble auto a, PlainDouble auto b) {
  return std::min(a, b);
}
KINOME_WIDE double max(PlainDouble auto a, PlainDouble auto b) {
  return std::max(a, b);
}
KINOME_WIDE void sincos(PlainDouble auto x, double& s, double& c) {
  s = std::sin(x), c = std::cos(x);
}
KINOME_WIDE double atan2(PlainDouble auto y, PlainDouble auto x) {
  return std::atan2(y, x);
}
KINOME_WIDE bool is_finite(PlainDouble auto a) {
  return std::abs(a) < HUGE_VAL;
}

}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
