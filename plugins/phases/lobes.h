#pragma once

#include <array>
#include <cmath>

#include "kinome/phase.h"

/// Approximations of phase functions by lobes, for Phase::lobes().
namespace kinome {

/// Returns two lobes of equal weight whose means of P1(c) = c and P2(c) = (3 c² - 1) / 2 are those
/// given, c being the cosine of the deflection. They are matched as far as lobes allow: those of a
/// Henyey-Greenstein function are g and g².
inline std::array<HgLobe, 2> lobes_of_moments(float p1, float p2) {
  constexpr float kMaxG = 0.98f;
  const float apart = std::sqrt(std::max(p2 - p1 * p1, 0.f));
  return {HgLobe{std::clamp(p1 - apart, -kMaxG, kMaxG), 0.5f},
          HgLobe{std::clamp(p1 + apart, -kMaxG, kMaxG), 0.5f}};
}

}  // namespace kinome
