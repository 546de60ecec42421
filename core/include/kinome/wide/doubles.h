#pragma once

// Double precision with as many lanes as wide::Float, for shapes that need more accuracy than float
// has. Formulas are templates over D, which is double or wide::Double. Both give the same bits,
// because operations are never contracted. FloatOf<D> is the single-precision number of D,
// DoubleOf<F> the reverse; comparisons return Float's masks.

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

#define KINOME_WIDE_OPERATOR(op, function)                             \
  friend KINOME_WIDE Double operator op(Double a, Double b) {          \
    return {hn::function(a.low, b.low), hn::function(a.high, b.high)}; \
  }                                                                    \
  friend KINOME_WIDE Double& operator op##=(Double& a, Double b) {     \
    return a = a op b;                                                 \
  }
struct Double {
  hn::Vec<DoubleTag> low, high;  ///< first and second half of the lanes

  Double() = default;
  KINOME_WIDE Double(hn::Vec<DoubleTag> l, hn::Vec<DoubleTag> h) : low(l), high(h) {}
  KINOME_WIDE Double(DoubleLiteral auto x)
      : low(hn::Set(DoubleTag(), static_cast<double>(x))), high(low) {}

  KINOME_WIDE_OPERATOR(+, Add)
  KINOME_WIDE_OPERATOR(-, Sub)
  KINOME_WIDE_OPERATOR(*, Mul)
  KINOME_WIDE_OPERATOR(/, Div)

  friend KINOME_WIDE Double operator-(Double a) { return {hn::Neg(a.low), hn::Neg(a.high)}; }
  friend KINOME_WIDE Double sqrt(Double a) { return {hn::Sqrt(a.low), hn::Sqrt(a.high)}; }
  friend KINOME_WIDE Double abs(Double a) { return {hn::Abs(a.low), hn::Abs(a.high)}; }
  friend KINOME_WIDE Double copysign(Double a, Double sign) {
    return {hn::CopySign(a.low, sign.low), hn::CopySign(a.high, sign.high)};
  }
  /// Same treatment of NaN and signed zeros as for Float.
  friend KINOME_WIDE Double min(Double a, Double b) {
    return {detail::least(a.low, b.low), detail::least(a.high, b.high)};
  }
  friend KINOME_WIDE Double max(Double a, Double b) {
    return {detail::greatest(a.low, b.low), detail::greatest(a.high, b.high)};
  }
};
#undef KINOME_WIDE_OPERATOR

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
KINOME_WIDE_FUNCTION(Mask, is_finite, Double, abs(a) < HUGE_VAL)

/// Rounds to the nearest integer, halves to even; for |a| < 2^51.
KINOME_WIDE Double round(Double a) {
  const Double rounder = 0x1.8p52;
  return (a + rounder) - rounder;
}

/// For wide numbers, sincos() and atan2() have only float's accuracy: errors up to 2^-23 (sincos)
/// and 4 ulp of a float (atan2).
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

  friend KINOME_WIDE DVec3 operator+(DVec3 a, DVec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend KINOME_WIDE DVec3 operator-(DVec3 a, DVec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend KINOME_WIDE DVec3 operator-(DVec3 a) { return {-a.x, -a.y, -a.z}; }
  friend KINOME_WIDE DVec3 operator*(DVec3 a, Double b) { return {a.x * b, a.y * b, a.z * b}; }
  friend KINOME_WIDE DVec3 operator/(DVec3 a, Double b) { return {a.x / b, a.y / b, a.z / b}; }
  friend KINOME_WIDE DVec3 select(Mask m, DVec3 a, DVec3 b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
  }
  friend KINOME_WIDE Double dot(DVec3 a, DVec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend KINOME_WIDE Double length(DVec3 a) { return sqrt(dot(a, a)); }
  friend KINOME_WIDE DVec3 normalize(DVec3 a) { return a * (1.0 / length(a)); }
};

KINOME_WIDE DVec3 operator*(const glm::dmat3& m, DVec3 a) {
  return matrix_times(m, a);
}
/// Product with the transpose of m.
KINOME_WIDE DVec3 operator*(DVec3 a, const glm::dmat3& m) {
  return matrix_times(glm::transpose(m), a);
}
KINOME_WIDE_FUNCTION(DVec3, to_double, Vec3, DVec3(to_double(a.x), to_double(a.y), to_double(a.z)))
KINOME_WIDE_FUNCTION(Vec3, to_float, DVec3, Vec3(to_float(a.x), to_float(a.y), to_float(a.z)))

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

KINOME_WIDE_FUNCTION(double, to_double, Real auto, a)
KINOME_WIDE_FUNCTION(float, to_float, PlainDouble auto, static_cast<float>(a))
KINOME_WIDE glm::dvec3 to_double(const glm::vec3& a) {
  return glm::dvec3(a);
}
KINOME_WIDE glm::vec3 to_float(const glm::dvec3& a) {
  return glm::vec3(a);
}
KINOME_WIDE_FUNCTION(double, sqrt, PlainDouble auto, std::sqrt(a))
KINOME_WIDE_FUNCTION(double, abs, PlainDouble auto, std::abs(a))
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
KINOME_WIDE_FUNCTION(bool, is_finite, PlainDouble auto, std::abs(a) < HUGE_VAL)

}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
