#pragma once

// Numbers of as many lanes as the instruction set has that a file is compiled for, at most 16: what
// block functions of plugins compute with. A formula is written once, as a template over its
// number:
//
//   using namespace wide::formulas;  // select, max, sqrt ... of plain numbers
//
//   template <class F>
//   F schlick(F cos_theta, F r0) {
//     const F x = max(1.f - cos_theta, F(0.f));
//     return select(cos_theta > 0.f, mul_add(1.f - r0, x * x * x * x * x, r0), F(0.f));
//   }
//
// F is float in the function for one point and wide::Float in the one for a block. Functions of
// wide numbers are found by their arguments; those of float, int32_t, uint32_t, bool and GLM's
// vectors, of the same names and meanings, are in `formulas` (and in `wide`). There, numbers don't
// convert: sqrt(2.0) and max(x, 0) of a float x don't compile. Beside `&`, `|` and `!`, masks have
// `&&` and `||`, which formulas use: of two bools, `&` makes an int. Both sides are computed in any
// case.
//
// Only what says mul_add is contracted, where the instruction set can; never for float.
//
// Highway knows no SSE2: built for the x86-64 baseline, numbers have one lane by GCC, and four
// emulated ones by clang.
//
// What is compiled for different instruction sets has different names (the inline namespace), so
// that the linker can't take one for the other. Nothing here is seen in the interfaces of the core,
// which are over columns. No function has state; all may be called by any number of threads.

#ifndef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_STATIC
#endif
// Of what AVX2 brings in Highway's sense, the only thing that x86-64-v3 lacks.
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

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using FloatTag = hn::CappedTag<float, kBlockLanes>;
using IntTag = hn::RebindToSigned<FloatTag>;
using UintTag = hn::RebindToUnsigned<FloatTag>;

/// Lanes of a number; divides kBlockLanes.
inline constexpr size_t kLanes = hn::MaxLanes(FloatTag());
static_assert(kBlockLanes % kLanes == 0);

template <class T>
concept Real = std::same_as<T, float>;
template <class T>
concept Boolean = std::same_as<T, bool>;
template <class T>
concept Integer = std::same_as<T, int32_t> || std::same_as<T, uint32_t>;
/// What converts to a Float of equal lanes.
template <class T>
concept RealLiteral = Real<T> || std::same_as<T, int>;

/// One truth a lane.
struct Mask {
  hn::Mask<FloatTag> v;

  Mask() = default;
  KINOME_WIDE explicit Mask(hn::Mask<FloatTag> x) : v(x) {}
  KINOME_WIDE Mask(Boolean auto x)
      : v(hn::RebindMask(FloatTag(), hn::Ne(hn::Set(IntTag(), x ? 1 : 0), hn::Zero(IntTag())))) {}
  /// True where a value isn't 0.
  KINOME_WIDE static Mask load(const uint32_t* p) {
    const auto x = hn::LoadU(UintTag(), p);
    return Mask(hn::RebindMask(FloatTag(), hn::Ne(x, hn::Zero(UintTag()))));
  }
  /// All bits of a value or none: what Embree takes for -1 and 0, too.
  KINOME_WIDE void store(uint32_t* p) const {
    hn::StoreU(hn::VecFromMask(UintTag(), hn::RebindMask(UintTag(), v)), UintTag(), p);
  }
};

KINOME_WIDE Mask operator&(Mask a, Mask b) {
  return Mask(hn::And(a.v, b.v));
}
KINOME_WIDE Mask operator|(Mask a, Mask b) {
  return Mask(hn::Or(a.v, b.v));
}
KINOME_WIDE Mask operator^(Mask a, Mask b) {
  return Mask(hn::Xor(a.v, b.v));
}
KINOME_WIDE Mask operator!(Mask a) {
  return Mask(hn::Not(a.v));
}
KINOME_WIDE Mask operator&&(Mask a, Mask b) {
  return a & b;
}
KINOME_WIDE Mask operator||(Mask a, Mask b) {
  return a | b;
}
KINOME_WIDE Mask& operator&=(Mask& a, Mask b) {
  return a = a & b;
}
KINOME_WIDE Mask& operator|=(Mask& a, Mask b) {
  return a = a | b;
}
KINOME_WIDE bool any(Mask a) {
  return !hn::AllFalse(FloatTag(), a.v);
}
KINOME_WIDE bool all(Mask a) {
  return hn::AllTrue(FloatTag(), a.v);
}
KINOME_WIDE bool none(Mask a) {
  return hn::AllFalse(FloatTag(), a.v);
}
/// How many lanes are true.
KINOME_WIDE size_t count(Mask a) {
  return hn::CountTrue(FloatTag(), a.v);
}
/// The first lane that is true; there must be one.
KINOME_WIDE size_t first_true(Mask a) {
  return hn::FindKnownFirstTrue(FloatTag(), a.v);
}
/// True in the first n lanes.
KINOME_WIDE Mask first_lanes(size_t n) {
  return Mask(hn::FirstN(FloatTag(), n));
}

/// Single precision.
struct Float {
  hn::Vec<FloatTag> v;

  Float() = default;
  KINOME_WIDE explicit Float(hn::Vec<FloatTag> x) : v(x) {}
  KINOME_WIDE Float(RealLiteral auto x) : v(hn::Set(FloatTag(), static_cast<float>(x))) {}
  KINOME_WIDE static Float load(const float* p) { return Float(hn::LoadU(FloatTag(), p)); }
  KINOME_WIDE void store(float* p) const { hn::StoreU(v, FloatTag(), p); }
};
/// 32 bits with a sign; overflow wraps around.
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
};
/// 32 bits without a sign.
struct Uint {
  hn::Vec<UintTag> v;

  Uint() = default;
  KINOME_WIDE explicit Uint(hn::Vec<UintTag> x) : v(x) {}
  KINOME_WIDE Uint(Integer auto x) : v(hn::Set(UintTag(), static_cast<uint32_t>(x))) {}
  KINOME_WIDE static Uint load(const uint32_t* p) { return Uint(hn::LoadU(UintTag(), p)); }
  KINOME_WIDE void store(uint32_t* p) const { hn::StoreU(v, UintTag(), p); }
};

#define KINOME_WIDE_OPERATOR(T, op, function) \
  KINOME_WIDE T operator op(T a, T b) {       \
    return T(hn::function(a.v, b.v));         \
  }                                           \
  KINOME_WIDE T& operator op##=(T& a, T b) {  \
    return a = a op b;                        \
  }
#define KINOME_WIDE_COMPARISON(T, op, function)                      \
  KINOME_WIDE Mask operator op(T a, T b) {                           \
    return Mask(hn::RebindMask(FloatTag(), hn::function(a.v, b.v))); \
  }
KINOME_WIDE_OPERATOR(Float, +, Add)
KINOME_WIDE_OPERATOR(Float, -, Sub)
KINOME_WIDE_OPERATOR(Float, *, Mul)
KINOME_WIDE_OPERATOR(Float, /, Div)
KINOME_WIDE_OPERATOR(Int, +, Add)
KINOME_WIDE_OPERATOR(Int, -, Sub)
KINOME_WIDE_OPERATOR(Int, *, Mul)
KINOME_WIDE_OPERATOR(Int, &, And)
KINOME_WIDE_OPERATOR(Int, |, Or)
KINOME_WIDE_OPERATOR(Int, ^, Xor)
KINOME_WIDE_OPERATOR(Uint, +, Add)
KINOME_WIDE_OPERATOR(Uint, -, Sub)
KINOME_WIDE_OPERATOR(Uint, *, Mul)
KINOME_WIDE_OPERATOR(Uint, &, And)
KINOME_WIDE_OPERATOR(Uint, |, Or)
KINOME_WIDE_OPERATOR(Uint, ^, Xor)
KINOME_WIDE_COMPARISON(Float, <, Lt)
KINOME_WIDE_COMPARISON(Float, <=, Le)
KINOME_WIDE_COMPARISON(Float, >, Gt)
KINOME_WIDE_COMPARISON(Float, >=, Ge)
KINOME_WIDE_COMPARISON(Float, ==, Eq)
KINOME_WIDE_COMPARISON(Int, <, Lt)
KINOME_WIDE_COMPARISON(Int, >, Gt)
KINOME_WIDE_COMPARISON(Int, ==, Eq)
KINOME_WIDE_COMPARISON(Int, !=, Ne)
KINOME_WIDE_COMPARISON(Uint, <, Lt)
KINOME_WIDE_COMPARISON(Uint, >, Gt)
KINOME_WIDE_COMPARISON(Uint, ==, Eq)
KINOME_WIDE_COMPARISON(Uint, !=, Ne)
#undef KINOME_WIDE_OPERATOR
#undef KINOME_WIDE_COMPARISON

/// True of NaN, which Highway's isn't.
KINOME_WIDE Mask operator!=(Float a, Float b) {
  return !(a == b);
}
KINOME_WIDE Mask operator<=(Int a, Int b) {
  return !(a > b);
}
KINOME_WIDE Mask operator>=(Int a, Int b) {
  return !(a < b);
}
KINOME_WIDE Mask operator<=(Uint a, Uint b) {
  return !(a > b);
}
KINOME_WIDE Mask operator>=(Uint a, Uint b) {
  return !(a < b);
}
KINOME_WIDE Float operator+(Float a) {
  return a;
}
KINOME_WIDE Float operator-(Float a) {
  return Float(hn::Neg(a.v));
}
KINOME_WIDE Int operator-(Int a) {
  return Int(hn::Neg(a.v));
}
KINOME_WIDE Int operator~(Int a) {
  return Int(hn::Not(a.v));
}
KINOME_WIDE Uint operator~(Uint a) {
  return Uint(hn::Not(a.v));
}
/// By 0 to 31 bits; an Int's sign is kept to the right.
template <int bits>
KINOME_WIDE Int shift_left(Int a) {
  return Int(hn::ShiftLeft<bits>(a.v));
}
template <int bits>
KINOME_WIDE Int shift_right(Int a) {
  return Int(hn::ShiftRight<bits>(a.v));
}
template <int bits>
KINOME_WIDE Uint shift_left(Uint a) {
  return Uint(hn::ShiftLeft<bits>(a.v));
}
template <int bits>
KINOME_WIDE Uint shift_right(Uint a) {
  return Uint(hn::ShiftRight<bits>(a.v));
}

/// a where the mask is true, b elsewhere. What isn't taken may be anything, NaN included.
KINOME_WIDE Float select(Mask m, Float a, Float b) {
  return Float(hn::IfThenElse(m.v, a.v, b.v));
}
KINOME_WIDE Int select(Mask m, Int a, Int b) {
  return Int(hn::IfThenElse(hn::RebindMask(IntTag(), m.v), a.v, b.v));
}
KINOME_WIDE Uint select(Mask m, Uint a, Uint b) {
  return Uint(hn::IfThenElse(hn::RebindMask(UintTag(), m.v), a.v, b.v));
}
KINOME_WIDE Mask select(Mask m, Mask a, Mask b) {
  return (m & a) | (b & !m);
}
/// a or 0.
KINOME_WIDE Float select(Mask m, Float a) {
  return Float(hn::IfThenElseZero(m.v, a.v));
}
KINOME_WIDE Int select(Mask m, Int a) {
  return Int(hn::IfThenElseZero(hn::RebindMask(IntTag(), m.v), a.v));
}
KINOME_WIDE Uint select(Mask m, Uint a) {
  return Uint(hn::IfThenElseZero(hn::RebindMask(UintTag(), m.v), a.v));
}

/// a b + c, a b - c and c - a b, rounded once where the instruction set can.
KINOME_WIDE Float mul_add(Float a, Float b, Float c) {
  return Float(hn::MulAdd(a.v, b.v, c.v));
}
KINOME_WIDE Float mul_sub(Float a, Float b, Float c) {
  return Float(hn::MulSub(a.v, b.v, c.v));
}
KINOME_WIDE Float neg_mul_add(Float a, Float b, Float c) {
  return Float(hn::NegMulAdd(a.v, b.v, c.v));
}

/// As std::min and std::max, to the sign of 0: a if the two are equal or one is NaN.
KINOME_WIDE Float min(Float a, Float b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return Float(hn::Min(b.v, a.v));  // the instruction's answer to NaN is its second operand
#else
  return select(b < a, b, a);
#endif
}
KINOME_WIDE Float max(Float a, Float b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return Float(hn::Max(b.v, a.v));
#else
  return select(a < b, b, a);
#endif
}
KINOME_WIDE Int min(Int a, Int b) {
  return Int(hn::Min(a.v, b.v));
}
KINOME_WIDE Int max(Int a, Int b) {
  return Int(hn::Max(a.v, b.v));
}
KINOME_WIDE Uint min(Uint a, Uint b) {
  return Uint(hn::Min(a.v, b.v));
}
KINOME_WIDE Uint max(Uint a, Uint b) {
  return Uint(hn::Max(a.v, b.v));
}
/// lo <= hi; NaN stays.
KINOME_WIDE Float clamp(Float a, Float lo, Float hi) {
  return min(max(a, lo), hi);
}
KINOME_WIDE Int clamp(Int a, Int lo, Int hi) {
  return min(max(a, lo), hi);
}
KINOME_WIDE Uint clamp(Uint a, Uint lo, Uint hi) {
  return min(max(a, lo), hi);
}

KINOME_WIDE Float abs(Float a) {
  return Float(hn::Abs(a.v));
}
KINOME_WIDE Int abs(Int a) {
  return Int(hn::Abs(a.v));
}
KINOME_WIDE Float copysign(Float a, Float sign) {
  return Float(hn::CopySign(a.v, sign.v));
}
KINOME_WIDE Float sqr(Float a) {
  return a * a;
}
/// Correctly rounded.
KINOME_WIDE Float sqrt(Float a) {
  return Float(hn::Sqrt(a.v));
}
/// What rounding brought below 0 counts as 0.
KINOME_WIDE Float safe_sqrt(Float a) {
  return sqrt(max(a, 0.f));
}
KINOME_WIDE Float lerp(Float a, Float b, Float t) {
  return a * (1.f - t) + b * t;
}
/// To an integer below, above, or the nearest (halves to the even one); the sign of 0 is kept.
#if HWY_TARGET == HWY_SCALAR  // whose functions don't keep it
KINOME_WIDE Float floor(Float a) {
  return std::floor(hn::GetLane(a.v));
}
KINOME_WIDE Float ceil(Float a) {
  return std::ceil(hn::GetLane(a.v));
}
KINOME_WIDE Float round(Float a) {
  return std::nearbyint(hn::GetLane(a.v));
}
#else
KINOME_WIDE Float floor(Float a) {
  return Float(hn::Floor(a.v));
}
KINOME_WIDE Float ceil(Float a) {
  return Float(hn::Ceil(a.v));
}
KINOME_WIDE Float round(Float a) {
  return Float(hn::Round(a.v));
}
#endif
KINOME_WIDE Mask is_nan(Float a) {
  return a != a;
}
KINOME_WIDE Mask is_finite(Float a) {
  return abs(a) < HUGE_VALF;
}

/// Of what int32_t can't hold, some integer or other.
KINOME_WIDE Int to_int(Float a) {
#if HWY_TARGET == HWY_SCALAR
  a = select(a == a, a, 0.f);  // Highway's plain conversion is not defined for NaN
#endif
  return Int(hn::ConvertTo(IntTag(), a.v));
}  ///< toward 0
KINOME_WIDE Int round_to_int(Float a) {
  return Int(hn::NearestInt(a.v));
}  ///< as round()
KINOME_WIDE Float to_float(Int a) {
  return Float(hn::ConvertTo(FloatTag(), a.v));
}
KINOME_WIDE Int as_int(Float a) {
  return Int(hn::BitCast(IntTag(), a.v));
}
KINOME_WIDE Int as_int(Uint a) {
  return Int(hn::BitCast(IntTag(), a.v));
}
KINOME_WIDE Uint as_uint(Float a) {
  return Uint(hn::BitCast(UintTag(), a.v));
}
KINOME_WIDE Uint as_uint(Int a) {
  return Uint(hn::BitCast(UintTag(), a.v));
}
KINOME_WIDE Float as_float(Int a) {
  return Float(hn::BitCast(FloatTag(), a.v));
}
KINOME_WIDE Float as_float(Uint a) {
  return Float(hn::BitCast(FloatTag(), a.v));
}
/// Rounded once, like a plain number's conversion.
KINOME_WIDE Float to_float(Uint a) {
  const Float high = to_float(as_int(shift_right<16>(a)));
  const Float low = to_float(as_int(a & 0xffff));
  return high * 65536.f + low;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide

#include "kinome/wide/lanes.h"
#include "kinome/wide/plain_numbers.h"
