#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "kit/statistics.h"

/// Helpers for the verdicts of tests.
namespace kinome::check {

inline Verdict fail(std::string text) {
  return {false, 0, std::move(text)};
}

/// Returns the p-value of two tests together, such that their joint false-alarm rate is alpha.
inline double bonferroni(double p, double q) {
  return std::min(1., 2 * std::min(p, q));
}

}  // namespace kinome::check
