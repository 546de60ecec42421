#pragma once

// Elementary functions. Comments give the maximum error against the exact result in units in the
// last place of the result (ulp), including denormal results unless denormals are flushed. Tests
// check the bounds for each instruction set. NaN arguments return NaN. The float overloads call the
// standard library.

#include <numbers>

#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

inline namespace formulas {

/// Evaluates first x^n + ... + last by Horner's rule.
template <class... C>
KINOME_WIDE float polynomial(Real auto x, float first, C... rest) {
  float p = first;
  ((p = p * x + static_cast<float>(rest)), ...);
  return p;
}

KINOME_WIDE_FUNCTION(float, exp, Real auto, std::exp(a))
KINOME_WIDE_FUNCTION(float, log, Real auto, std::log(a))
KINOME_WIDE float pow(Real auto x, Real auto y) {
  return std::pow(x, y);
}
KINOME_WIDE_FUNCTION(float, erf, Real auto, std::erf(a))
KINOME_WIDE_FUNCTION(float, sin, Real auto, std::sin(a))
KINOME_WIDE_FUNCTION(float, cos, Real auto, std::cos(a))
KINOME_WIDE void sincos(Real auto x, float& s, float& c) {
  s = std::sin(x), c = std::cos(x);
}
KINOME_WIDE float atan2(Real auto y, Real auto x) {
  return std::atan2(y, x);
}
KINOME_WIDE_FUNCTION(float, asin, Real auto, std::asin(a))
KINOME_WIDE_FUNCTION(float, acos, Real auto, std::acos(a))

}  // namespace formulas

template <class... C>
KINOME_WIDE Float polynomial(Float x, float first, C... rest) {
  Float p = first;
  ((p = mul_add(p, x, static_cast<float>(rest))), ...);
  return p;
}

namespace detail {

/// Decomposition x = n ln 2 + r with |r| <= ln 2 / 2, for |x| < 2^20.
struct Exponential {
  Float power;  ///< e^r
  Int n;
};
/// e^r for |r| <= ln 2 / 2.
inline Float exponential_of_small(Float r) {
  const Float p = polynomial(r, 0.00139265461f, 0.00836317334f, 0.0416665487f, 0.166665778f, 0.5f);
  return mul_add(p, r * r, r) + 1.f;
}
inline Exponential exponential(Float x) {
  // Adding this number rounds x / ln 2 to an integer in the last bits.
  const Float rounder = 0x1.8p23f;
  const Float shifted = mul_add(x, std::numbers::log2e_v<float>, rounder);
  const Float n = shifted - rounder;
  // ln 2 is split into two parts. The first has 9 bits, so that its product with n is exact.
  const Float r = neg_mul_add(n, -2.12194440e-4f, neg_mul_add(n, 0.693359375f, x));
  return {exponential_of_small(r), as_int(shifted) - as_int(rounder)};
}
/// 2^n for -126 <= n <= 127.
KINOME_WIDE Float power_of_two(Int n) {
  return as_float(shift_left<23>(n + 127));
}

/// Decomposition x = 2^e (1 + m) with m in [sqrt(1/2) - 1, sqrt(2) - 1], for finite x > 0.
struct Logarithm {
  Float m, e;
};
inline Logarithm split(Float x) {
  const Mask tiny = x < 0x1p-126f;
  const Int bits = as_int(select(tiny, x * 0x1p23f, x));
  const Int e = shift_right<23>(bits - 0x3f3504f3);
  const Float m = as_float(bits - shift_left<23>(e)) - 1.f;
  return {m, to_float(e) - select(tiny, 23.f)};
}

}  // namespace detail

/// Maximum error 1.1 ulp.
inline Float exp(Float x) {
  // Outside this range, the result is 0 or infinity.
  const auto [power, n] = detail::exponential(clamp(x, -104.f, 89.f));
  // Scales in two steps, for results below 2^-126 and above 2^127.
  const Int half = shift_right<1>(n);
  return power * detail::power_of_two(half) * detail::power_of_two(n - half);
}

/// Maximum error 1 ulp; -infinity for 0, NaN for negative x.
inline Float log(Float x) {
  const auto [m, e] = detail::split(x);
  const Float p = polynomial(m, 0.0697161183f, -0.114797339f, 0.116854198f, -0.124256872f,
                             0.142490581f, -0.166678026f, 0.200007156f, -0.24999997f, 0.333333313f);
  const Float m2 = m * m;
  Float low = mul_add(m * m2, p, -0.5f * m2);
  low = mul_add(e, -2.12194440e-4f, low);
  const Float result = mul_add(e, 0.693359375f, m + low);
  const Float special = select(x == 0.f, -HUGE_VALF, select(x > 0.f, x, NAN));
  return select((x > 0.f) & (x < HUGE_VALF), result, special);
}

/// Maximum error 1.5 ulp.
inline Float erf(Float x) {
  const Float a = abs(x);
  const Float x2 = x * x;
  const Float small = mul_add(x,
                              polynomial(x2, 7.87587487e-05f, -0.00080168643f, 0.00518908724f,
                                         -0.0268542115f, 0.112835944f, -0.37612626f, 0.128379166f),
                              x);
  const Float y = min(a, 4.f);
  const auto [power, n] = detail::exponential(
      polynomial(y, 1.6371514e-06f, -4.60580413e-05f, 0.00059680565f, -0.0047595962f, 0.0264211353f,
                 -0.110080086f, -0.631826043f, -1.13023341f, 0.00032013806f));
  const Float large = copysign(1.f - power * detail::power_of_two(n), x);
  return select(a > 1.f, large, small);
}

namespace detail {

/// Decomposition x = k pi/2 + r with r in [-pi/4, pi/4].
struct Quadrant {
  Float r;
  Int k;
};
inline Quadrant quadrant(Float x) {
  const Float n = round(x * (2 * std::numbers::inv_pi_v<float>));
  // pi/2 is split into three parts; the first two have few bits, for exact products.
  const Float r = neg_mul_add(n, 7.54978995489e-8f,
                              neg_mul_add(n, 4.83751296997e-4f, neg_mul_add(n, 1.5703125f, x)));
  return {r, to_int(n)};
}
inline Float sine(Float r) {
  const Float z = r * r;
  return mul_add(polynomial(z, -0.000195878907f, 0.00833274797f, -0.166666642f), z * r, r);
}
inline Float cosine(Float r) {
  const Float z = r * r;
  return mul_add(polynomial(z, 2.45479423e-05f, -0.00138883025f, 0.0416666642f), z * z,
                 mul_add(z, -0.5f, 1.f));
}

/// Sine and cosine of k pi/2 + r.
inline void sincos(const Quadrant& x, Float& s, Float& c) {
  const Float a = sine(x.r), b = cosine(x.r);
  const Mask swapped = (x.k & 1) == 1;
  s = as_float(as_int(select(swapped, b, a)) ^ shift_left<30>(x.k & 2));
  c = as_float(as_int(select(swapped, a, b)) ^ shift_left<30>((x.k + 1) & 2));
}

}  // namespace detail

/// Maximum absolute error 2^-23 for |x| <= 8000; sines of |x| < 0.5 to 1 ulp. Loses the sign of 0.
inline void sincos(Float x, Float& s, Float& c) {
  detail::sincos(detail::quadrant(x), s, c);
}
/// Same accuracy as sincos().
inline Float sin(Float x) {
  Float s, c;
  sincos(x, s, c);
  return s;
}
inline Float cos(Float x) {
  Float s, c;
  sincos(x, s, c);
  return c;
}

/// Maximum error 2.5 ulp. Zeros as in the C standard; NaN if both arguments are infinite.
inline Float atan2(Float y, Float x) {
  const Float ax = abs(x), ay = abs(y);
  const Float large = max(ay, ax), small = min(ax, ay);  // in this order, NaN stays
  const Float t = select(ax + ay == 0.f, 0.f, small / large);
  const Float z = t * t;
  const Float p =
      polynomial(z, -0.00238699722f, 0.0135077713f, -0.0358715393f, 0.0625016913f, -0.0865688026f,
                 0.110337645f, -0.142785683f, 0.199997395f, -0.333333313f);
  Float angle = mul_add(p, z * t, t);
  angle = select(ay > ax, std::numbers::pi_v<float> / 2 - angle, angle);
  angle = select(as_int(x) < 0, std::numbers::pi_v<float> - angle, angle);
  return copysign(angle, y);
}
/// Maximum error 3 ulp for |x| <= 1; NaN outside. Also holds for acos().
inline Float asin(Float x) {
  return atan2(x, sqrt((1.f - x) * (1.f + x)));
}
inline Float acos(Float x) {
  return atan2(sqrt((1.f - x) * (1.f + x)), x);
}

namespace detail {

/// Number high + low; |low| is at most about half an ulp of high.
struct Double {
  Float high, low;
};
/// Computes a + b exactly, for |a| >= |b| or a = 0.
KINOME_WIDE Double fast_sum(Float a, Float b) {
  const Float s = a + b;
  return {s, b - (s - a)};
}
/// Computes a b exactly, unless an intermediate result over- or underflows.
KINOME_WIDE Double product(Float a, Float b) {
  const Float p = a * b;
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128 || HWY_TARGET == HWY_SSE4 || \
    HWY_TARGET == HWY_SSSE3
  // Without FMA, multiplies halves of 12 bits (Dekker 1971).
  const auto halves = [](Float x) {
    const Float shifted = 4097.f * x;
    const Float high = shifted - (shifted - x);
    return Double{high, x - high};
  };
  const Double x = halves(a), y = halves(b);
  return {p, x.low * y.low - (((p - x.high * y.high) - x.low * y.high) - x.high * y.low)};
#else
  return {p, mul_sub(a, b, p)};
#endif
}

/// log2 x to about 30 bits, for finite x > 0: 2 atanh(m / (2 + m)) / ln 2.
inline Double log2(Float x) {
  const auto [m, e] = split(x);
  const Double d = fast_sum(2.f, m);
  const Float s = m / d.high;
  const Double back = product(s, d.high);
  const Float rest = ((m - back.high) - back.low - s * d.low) / d.high;
  const Float z = s * s;
  const Float tail = s * z * polynomial(z, 0.2333083f, 0.285508066f, 0.400001228f, 0.666666687f);
  const Double log = fast_sum(2.f * s, mul_add(2.f, rest, tail));
  const Double binary = product(log.high, 0x1.715476p+0f);
  const Float low = mul_add(log.low, 0x1.715476p+0f, mul_add(log.high, 0x1.4ae0cp-26f, binary.low));
  const Double sum = fast_sum(e, binary.high);
  return fast_sum(sum.high, sum.low + low);
}

}  // namespace detail

/// x^y for x >= 0, to 3 ulp; NaN for negative x. Like std::pow(), 1 if x = 1 or y = 0, even for
/// NaN.
inline Float pow(Float x, Float y) {
  const Mask ordinary = (x > 0.f) & (x < HUGE_VALF);
  const detail::Double log = detail::log2(select(ordinary, x, 1.f));
  const Float special = select(x == 0.f, -HUGE_VALF, select(x > 0.f, x, NAN));
  const Float product = y * select(ordinary, log.high, special);
  // Outside this range, the result is 0 or infinity.
  const Mask moderate = abs(product) < 160.f;
  const detail::Double exact = detail::product(select(moderate, y), select(moderate, log.high));
  const Float exponent = clamp(product, -160.f, 160.f);
  const Float rounder = 0x1.8p23f;
  const Float shifted = exponent + rounder;
  const Float low = mul_add(select(moderate, y), log.low, exact.low);
  const Float r = ((exponent - (shifted - rounder)) + low) * std::numbers::ln2_v<float>;
  const Float power = detail::exponential_of_small(r);
  const Int n = as_int(shifted) - as_int(rounder);
  const Int half = shift_right<1>(n);
  const Float result = power * detail::power_of_two(half) * detail::power_of_two(n - half);
  return select((x == 1.f) | (y == 0.f), 1.f, result);
}

namespace detail {

template <class F>
inline F inverse_erf(F y) {
  const F w = -log((1.f - y) * (1.f + y));
  const F v = w - 2.5f;
  const F small = polynomial(v, -8.93192631e-09f, 2.33359678e-08f, 4.68131361e-07f,
                             -3.46398519e-06f, -4.9724199e-06f, 0.000218349393f, -0.00125272642f,
                             -0.00417739293f, 0.24664028f, 1.50140941f);
  const F s = sqrt(w) - 3.f;
  const F large = polynomial(s, 0.000111538582f, -0.000305525056f, -5.04588534e-05f, 0.00147970393f,
                             -0.00360090029f, 0.00568921631f, -0.00763648981f, 0.00944499206f,
                             1.00167489f, 2.83297682f);
  return y * select(w < 5.f, small, select(w < HUGE_VALF, large, w));
}

}  // namespace detail

/// Inverse of erf(), to 4 ulp; infinite at -1 and 1, NaN outside.
KINOME_WIDE Float inverse_erf(Float y) {
  return detail::inverse_erf(y);
}
inline namespace formulas {
KINOME_WIDE_FUNCTION(float, inverse_erf, Real auto, detail::inverse_erf(a))
}  // namespace formulas

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
