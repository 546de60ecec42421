#pragma once

#include "kinome/wide/reconstruction_filter.h"

namespace kinome {

/// Piecewise cubics of radius 2 (Mitchell and Netravali 1988, eq. 8). B controls blur, and C
/// ringing. Beyond 1 they are negative if C is positive.
class CubicFilter : public wide::FormulaFilter<CubicFilter> {
 public:
  CubicFilter(float b, float c)
      : inner_{(12 - 9 * b - 6 * c) / 6, (-18 + 12 * b + 6 * c) / 6, (6 - 2 * b) / 6},
        outer_{(-b - 6 * c) / 6, (6 * b + 30 * c) / 6, (-12 * b - 48 * c) / 6,
               (8 * b + 24 * c) / 6} {
    radius_ = 2;
  }

  template <class F>
  F weight(F position) const {
    using namespace wide::formulas;
    const F x = abs(position);
    const F inner = (inner_[0] * x + inner_[1]) * x * x + inner_[2];
    const F outer = ((outer_[0] * x + outer_[1]) * x + outer_[2]) * x + outer_[3];
    return select(x < 1.f, inner, select(x < 2.f, outer, F(0.f)));
  }

 private:
  float inner_[3];  ///< coefficients of x³, x² and 1
  float outer_[4];  ///< coefficients of x³, x², x and 1
};

}  // namespace kinome
