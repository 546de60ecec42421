#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "check/statistics.h"

/// How tests come to their verdicts.
namespace kinome::check {

inline Verdict fail(std::string text) {
  return {false, 0, std::move(text)};
}

/// The p-value of the more suspicious of two tests, so that both together alarm at rate alpha.
inline double bonferroni(double p, double q) {
  return std::min(1., 2 * std::min(p, q));
}

}  // namespace kinome::check
