#pragma once

// SIMD numbers with as many lanes as the file's instruction set has, at most 16; used in block
// functions of plugins. A formula is written once, as a template over its number type:
//
//   using namespace wide::formulas;  // select, max, sqrt ... of plain numbers
//
//   template <class F>
//   F schlick(F cos_theta, F r0) {
//     const F x = max(1.f - cos_theta, F(0.f));
//     return select(cos_theta > 0.f, mul_add(1.f - r0, x * x * x * x * x, r0), F(0.f));
//   }
//
// F is float in the function for one point, and wide::Float in the function for a block. Functions
// of wide numbers are found by argument-dependent lookup; most are friends, so that no other call
// finds them. Functions of float, int32_t, uint32_t,
// bool and GLM's vectors with the same names and meanings are in `formulas` (and in `wide`). They
// don't convert arguments: sqrt(2.0) and max(x, 0) for a float x don't compile. In formulas, use
// `&&` and `||` for masks, since `&` of two bools is an int; masks evaluate both sides.
//
// Only mul_add() and its variants are contracted (rounded once), if the instruction set supports
// it. They are never contracted for float.
//
// Highway doesn't support SSE2. For the x86-64 baseline, numbers have one lane with GCC, and four
// emulated lanes with clang.
//
// Code compiled for different instruction sets has different names (the inline namespace), so that
// the linker doesn't merge it. The interfaces of the core, which use columns, contain none of these
// types. All functions are stateless and thread-safe.

#ifndef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_STATIC
#endif
// Highway's AVX2 target needs this extension, which x86-64-v3 doesn't include.
#ifndef HWY_DISABLE_PCLMUL_AES
#define HWY_DISABLE_PCLMUL_AES
#endif
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include "kinome/columns.h"

#define KINOME_WIDE HWY_INLINE
/// Defines a function of one argument, a.
#define KINOME_WIDE_FUNCTION(Result, name, Type, value) \
  KINOME_WIDE Result name(Type a) {                     \
    return value;                                       \
  }

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using FloatTag = hn::CappedTag<float, kBlockLanes>;
using IntTag = hn::RebindToSigned<FloatTag>;
using UintTag = hn::RebindToUnsigned<FloatTag>;

/// Number of lanes; divides kBlockLanes.
inline constexpr size_t kLanes = hn::MaxLanes(FloatTag());
static_assert(kBlockLanes % kLanes == 0);

template <class T>
concept Real = std::same_as<T, float>;
template <class T>
concept Boolean = std::same_as<T, bool>;
template <class T>
concept Integer = std::same_as<T, int32_t> || std::same_as<T, uint32_t>;
/// Types that convert to a Float with equal lanes.
template <class T>
concept RealLiteral = Real<T> || std::same_as<T, int>;

/// True if Highway's vectors are plain numbers. Its rounding functions then lose the sign of 0.
inline constexpr bool kIsPlain = HWY_TARGET == HWY_SCALAR;

/// Boolean per lane.
struct Mask {
  hn::Mask<FloatTag> v;

  Mask() = default;
  KINOME_WIDE explicit Mask(hn::Mask<FloatTag> x) : v(x) {}
  KINOME_WIDE Mask(Boolean auto x)
      : v(hn::RebindMask(FloatTag(), hn::Ne(hn::Set(IntTag(), x ? 1 : 0), hn::Zero(IntTag())))) {}
  /// True where the value isn't 0.
  KINOME_WIDE static Mask load(const uint32_t* p) {
    const auto x = hn::LoadU(UintTag(), p);
    return Mask(hn::RebindMask(FloatTag(), hn::Ne(x, hn::Zero(UintTag()))));
  }
  /// Stores all bits set or 0 per lane, the -1 and 0 that Embree expects.
  KINOME_WIDE void store(uint32_t* p) const {
    hn::StoreU(hn::VecFromMask(UintTag(), hn::RebindMask(UintTag(), v)), UintTag(), p);
  }

  friend KINOME_WIDE Mask operator&(Mask a, Mask b) { return Mask(hn::And(a.v, b.v)); }
  friend KINOME_WIDE Mask operator|(Mask a, Mask b) { return Mask(hn::Or(a.v, b.v)); }
  friend KINOME_WIDE Mask operator^(Mask a, Mask b) { return Mask(hn::Xor(a.v, b.v)); }
  friend KINOME_WIDE Mask operator!(Mask a) { return Mask(hn::Not(a.v)); }
  friend KINOME_WIDE Mask operator&&(Mask a, Mask b) { return a & b; }
  friend KINOME_WIDE Mask operator||(Mask a, Mask b) { return a | b; }
  friend KINOME_WIDE Mask& operator&=(Mask& a, Mask b) { return a = a & b; }
  friend KINOME_WIDE Mask& operator|=(Mask& a, Mask b) { return a = a | b; }
  friend KINOME_WIDE bool any(Mask a) { return !hn::AllFalse(FloatTag(), a.v); }
  friend KINOME_WIDE bool all(Mask a) { return hn::AllTrue(FloatTag(), a.v); }
  friend KINOME_WIDE bool none(Mask a) { return hn::AllFalse(FloatTag(), a.v); }
  /// Index of the first true lane; there must be one.
  friend KINOME_WIDE size_t first_true(Mask a) { return hn::FindKnownFirstTrue(FloatTag(), a.v); }
  friend KINOME_WIDE Mask select(Mask m, Mask a, Mask b) { return (m & a) | (b & !m); }
};

/// Number of true lanes.
KINOME_WIDE_FUNCTION(size_t, count, Mask, hn::CountTrue(FloatTag(), a.v))
/// True in the first n lanes.
KINOME_WIDE Mask first_lanes(size_t n) {
  return Mask(hn::FirstN(FloatTag(), n));
}

namespace detail {

/// std::min() and std::max() of Highway's vectors. x86 returns the second operand if one is NaN.
inline constexpr bool kIsX86 = HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128;
template <class V>
KINOME_WIDE V least(V a, V b) {
  return kIsX86 ? hn::Min(b, a) : hn::IfThenElse(hn::Lt(b, a), b, a);
}
template <class V>
KINOME_WIDE V greatest(V a, V b) {
  return kIsX86 ? hn::Max(b, a) : hn::IfThenElse(hn::Lt(a, b), b, a);
}

}  // namespace detail

#define KINOME_WIDE_OPERATOR(T, op, function)       \
  friend KINOME_WIDE T operator op(T a, T b) {      \
    return T(hn::function(a.v, b.v));               \
  }                                                 \
  friend KINOME_WIDE T& operator op##=(T& a, T b) { \
    return a = a op b;                              \
  }
#define KINOME_WIDE_COMPARISON(T, op, function)                      \
  friend KINOME_WIDE Mask operator op(T a, T b) {                    \
    return Mask(hn::RebindMask(FloatTag(), hn::function(a.v, b.v))); \
  }

/// Single-precision number per lane.
struct Float {
  hn::Vec<FloatTag> v;

  Float() = default;
  KINOME_WIDE explicit Float(hn::Vec<FloatTag> x) : v(x) {}
  KINOME_WIDE Float(RealLiteral auto x) : v(hn::Set(FloatTag(), static_cast<float>(x))) {}
  KINOME_WIDE static Float load(const float* p) { return Float(hn::LoadU(FloatTag(), p)); }
  KINOME_WIDE void store(float* p) const { hn::StoreU(v, FloatTag(), p); }

  KINOME_WIDE_OPERATOR(Float, +, Add)
  KINOME_WIDE_OPERATOR(Float, -, Sub)
  KINOME_WIDE_OPERATOR(Float, *, Mul)
  KINOME_WIDE_OPERATOR(Float, /, Div)
  KINOME_WIDE_COMPARISON(Float, <, Lt)
  KINOME_WIDE_COMPARISON(Float, <=, Le)
  KINOME_WIDE_COMPARISON(Float, >, Gt)
  KINOME_WIDE_COMPARISON(Float, >=, Ge)
  KINOME_WIDE_COMPARISON(Float, ==, Eq)

  /// True for NaN, unlike Highway's operator.
  friend KINOME_WIDE Mask operator!=(Float a, Float b) { return !(a == b); }
  friend KINOME_WIDE Float operator+(Float a) { return a; }
  friend KINOME_WIDE Float operator-(Float a) { return Float(hn::Neg(a.v)); }
  /// a b + c, a b - c and c - a b, rounded once if the instruction set can.
  friend KINOME_WIDE Float mul_add(Float a, Float b, Float c) {
    return Float(hn::MulAdd(a.v, b.v, c.v));
  }
  friend KINOME_WIDE Float mul_sub(Float a, Float b, Float c) {
    return Float(hn::MulSub(a.v, b.v, c.v));
  }
  friend KINOME_WIDE Float neg_mul_add(Float a, Float b, Float c) {
    return Float(hn::NegMulAdd(a.v, b.v, c.v));
  }
  /// Like std::min() and std::max(), including signed zeros and NaN: return a if the arguments are
  /// equal or one is NaN.
  friend KINOME_WIDE Float min(Float a, Float b) { return Float(detail::least(a.v, b.v)); }
  friend KINOME_WIDE Float max(Float a, Float b) { return Float(detail::greatest(a.v, b.v)); }
  /// Requires lo <= hi. NaN stays NaN.
  friend KINOME_WIDE Float clamp(Float a, Float lo, Float hi) { return min(max(a, lo), hi); }
  friend KINOME_WIDE Float abs(Float a) { return Float(hn::Abs(a.v)); }
  friend KINOME_WIDE Float copysign(Float a, Float sign) {
    return Float(hn::CopySign(a.v, sign.v));
  }
  friend KINOME_WIDE Float sqr(Float a) { return a * a; }
  /// Correctly rounded.
  friend KINOME_WIDE Float sqrt(Float a) { return Float(hn::Sqrt(a.v)); }
  /// Treats negative values from rounding as 0.
  friend KINOME_WIDE Float safe_sqrt(Float a) { return sqrt(max(a, 0.f)); }
  friend KINOME_WIDE Float lerp(Float a, Float b, Float t) { return a * (1.f - t) + b * t; }
  /// Round down, up, or to nearest (halves to even). The sign of 0 is kept.
  friend KINOME_WIDE Float floor(Float a) {
    return kIsPlain ? Float(std::floor(hn::GetLane(a.v))) : Float(hn::Floor(a.v));
  }
  friend KINOME_WIDE Float ceil(Float a) {
    return kIsPlain ? Float(std::ceil(hn::GetLane(a.v))) : Float(hn::Ceil(a.v));
  }
  friend KINOME_WIDE Float round(Float a) {
    return kIsPlain ? Float(std::nearbyint(hn::GetLane(a.v))) : Float(hn::Round(a.v));
  }
  friend KINOME_WIDE Mask is_nan(Float a) { return a != a; }
  friend KINOME_WIDE Mask is_finite(Float a) { return abs(a) < HUGE_VALF; }
};
/// Signed 32-bit integer per lane; overflow wraps around.
struct Int {
  hn::Vec<IntTag> v;

  Int() = default;
  KINOME_WIDE explicit Int(hn::Vec<IntTag> x) : v(x) {}
  KINOME_WIDE Int(std::same_as<int32_t> auto x) : v(hn::Set(IntTag(), x)) {}
  KINOME_WIDE static Int load(const int32_t* p) { return Int(hn::LoadU(IntTag(), p)); }
  KINOME_WIDE static Int load(const uint32_t* p) {
    return Int(hn::BitCast(IntTag(), hn::LoadU(UintTag(), p)));
  }
  KINOME_WIDE void store(int32_t* p) const { hn::StoreU(v, IntTag(), p); }
  KINOME_WIDE void store(uint32_t* p) const { hn::StoreU(hn::BitCast(UintTag(), v), UintTag(), p); }

  KINOME_WIDE_OPERATOR(Int, +, Add)
  KINOME_WIDE_OPERATOR(Int, -, Sub)
  KINOME_WIDE_OPERATOR(Int, *, Mul)
  KINOME_WIDE_OPERATOR(Int, &, And)
  KINOME_WIDE_OPERATOR(Int, |, Or)
  KINOME_WIDE_OPERATOR(Int, ^, Xor)
  KINOME_WIDE_COMPARISON(Int, <, Lt)
  KINOME_WIDE_COMPARISON(Int, >, Gt)
  KINOME_WIDE_COMPARISON(Int, ==, Eq)
  KINOME_WIDE_COMPARISON(Int, !=, Ne)

  friend KINOME_WIDE Mask operator<=(Int a, Int b) { return !(a > b); }
  friend KINOME_WIDE Mask operator>=(Int a, Int b) { return !(a < b); }
  friend KINOME_WIDE Int operator-(Int a) { return Int(hn::Neg(a.v)); }
  friend KINOME_WIDE Int operator~(Int a) { return Int(hn::Not(a.v)); }
  friend KINOME_WIDE Int select(Mask m, Int a, Int b) {
    return Int(hn::IfThenElse(hn::RebindMask(IntTag(), m.v), a.v, b.v));
  }
  friend KINOME_WIDE Int select(Mask m, Int a) {
    return Int(hn::IfThenElseZero(hn::RebindMask(IntTag(), m.v), a.v));
  }
  friend KINOME_WIDE Int min(Int a, Int b) { return Int(hn::Min(a.v, b.v)); }
  friend KINOME_WIDE Int max(Int a, Int b) { return Int(hn::Max(a.v, b.v)); }
  friend KINOME_WIDE Int clamp(Int a, Int lo, Int hi) { return min(max(a, lo), hi); }
  friend KINOME_WIDE Int abs(Int a) { return Int(hn::Abs(a.v)); }
};
/// Unsigned 32-bit integer per lane.
struct Uint {
  hn::Vec<UintTag> v;

  Uint() = default;
  KINOME_WIDE explicit Uint(hn::Vec<UintTag> x) : v(x) {}
  KINOME_WIDE Uint(Integer auto x) : v(hn::Set(UintTag(), static_cast<uint32_t>(x))) {}
  KINOME_WIDE static Uint load(const uint32_t* p) { return Uint(hn::LoadU(UintTag(), p)); }
  KINOME_WIDE void store(uint32_t* p) const { hn::StoreU(v, UintTag(), p); }

  KINOME_WIDE_OPERATOR(Uint, +, Add)
  KINOME_WIDE_OPERATOR(Uint, -, Sub)
  KINOME_WIDE_OPERATOR(Uint, *, Mul)
  KINOME_WIDE_OPERATOR(Uint, &, And)
  KINOME_WIDE_OPERATOR(Uint, |, Or)
  KINOME_WIDE_OPERATOR(Uint, ^, Xor)
  KINOME_WIDE_COMPARISON(Uint, <, Lt)
  KINOME_WIDE_COMPARISON(Uint, >, Gt)
  KINOME_WIDE_COMPARISON(Uint, ==, Eq)
  KINOME_WIDE_COMPARISON(Uint, !=, Ne)

  friend KINOME_WIDE Mask operator<=(Uint a, Uint b) { return !(a > b); }
  friend KINOME_WIDE Mask operator>=(Uint a, Uint b) { return !(a < b); }
  friend KINOME_WIDE Uint operator~(Uint a) { return Uint(hn::Not(a.v)); }
  friend KINOME_WIDE Uint select(Mask m, Uint a, Uint b) {
    return Uint(hn::IfThenElse(hn::RebindMask(UintTag(), m.v), a.v, b.v));
  }
  friend KINOME_WIDE Uint select(Mask m, Uint a) {
    return Uint(hn::IfThenElseZero(hn::RebindMask(UintTag(), m.v), a.v));
  }
  friend KINOME_WIDE Uint min(Uint a, Uint b) { return Uint(hn::Min(a.v, b.v)); }
  friend KINOME_WIDE Uint max(Uint a, Uint b) { return Uint(hn::Max(a.v, b.v)); }
  friend KINOME_WIDE Uint clamp(Uint a, Uint lo, Uint hi) { return min(max(a, lo), hi); }
};

#undef KINOME_WIDE_OPERATOR
#undef KINOME_WIDE_COMPARISON

template <class T>
concept WideInteger = std::same_as<T, Int> || std::same_as<T, Uint>;
/// Shifts by 0 to 31 bits; right shifts of an Int keep its sign.
template <int bits, WideInteger T>
KINOME_WIDE T shift_left(T a) {
  return T(hn::ShiftLeft<bits>(a.v));
}
template <int bits, WideInteger T>
KINOME_WIDE T shift_right(T a) {
  return T(hn::ShiftRight<bits>(a.v));
}

/// Returns a where the mask is true, and b elsewhere. The value not selected may be
/// anything, NaN included.
KINOME_WIDE Float select(Mask m, Float a, Float b) {
  return Float(hn::IfThenElse(m.v, a.v, b.v));
}
/// Returns a where the mask is true, and 0 elsewhere.
KINOME_WIDE Float select(Mask m, Float a) {
  return Float(hn::IfThenElseZero(m.v, a.v));
}

/// Truncates toward 0. The result for numbers out of int32_t's range is unspecified.
KINOME_WIDE Int to_int(Float a) {
#if HWY_TARGET == HWY_SCALAR
  a = select(a == a, a, 0.f);  // Highway's plain conversion is not defined for NaN
#endif
  return Int(hn::ConvertTo(IntTag(), a.v));
}
/// Rounds as round() does.
KINOME_WIDE_FUNCTION(Int, round_to_int, Float, Int(hn::NearestInt(a.v)))
KINOME_WIDE_FUNCTION(Float, to_float, Int, Float(hn::ConvertTo(FloatTag(), a.v)))
KINOME_WIDE_FUNCTION(Int, as_int, Float, Int(hn::BitCast(IntTag(), a.v)))
KINOME_WIDE_FUNCTION(Int, as_int, Uint, Int(hn::BitCast(IntTag(), a.v)))
KINOME_WIDE_FUNCTION(Uint, as_uint, Float, Uint(hn::BitCast(UintTag(), a.v)))
KINOME_WIDE_FUNCTION(Uint, as_uint, Int, Uint(hn::BitCast(UintTag(), a.v)))
KINOME_WIDE_FUNCTION(Float, as_float, Int, Float(hn::BitCast(FloatTag(), a.v)))
KINOME_WIDE_FUNCTION(Float, as_float, Uint, Float(hn::BitCast(FloatTag(), a.v)))
/// Rounded once, like the conversion of a plain number.
KINOME_WIDE Float to_float(Uint a) {
  const Float high = to_float(as_int(shift_right<16>(a)));
  const Float low = to_float(as_int(a & 0xffff));
  return high * 65536.f + low;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide

#include "kinome/wide/lanes.h"
#include "kinome/wide/plain_numbers.h"
