#pragma once

// Functions that are accurate near zero.

#include "kinome/wide/functions.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

inline namespace formulas {

KINOME_WIDE_FUNCTION(float, log1p, Real auto, std::log1p(a))
KINOME_WIDE_FUNCTION(float, expm1, Real auto, std::expm1(a))

}  // namespace formulas

/// log(1 + x), maximum error 4 ulp; NaN below -1.
inline Float log1p(Float x) {
  // The rounding error of 1 + x also affects u - 1, and cancels in the quotient.
  const Float u = 1.f + x;
  const Mask is_finite = u < HUGE_VALF;
  return select(u == 1.f, x, log(u) * select(is_finite, x / (u - 1.f), Float(1.f)));
}
/// e^x - 1, maximum error 4 ulp for x below 80.
inline Float expm1(Float x) {
  const Float u = exp(x);
  const Float less = u - 1.f;
  return select(u == 1.f, x, select(less == -1.f, less, less * (x / log(u))));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
