#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kinome/sampler.h"
#include "support/render.h"
#include "support/statistics.h"

namespace kinome::test {

inline std::shared_ptr<Sampler> make_sampler(const std::string& type, int count) {
  return make<Sampler>("<sampler type=\"" + type + "\"><integer name=\"sample_count\" value=\"" +
                       std::to_string(count) + "\"/></sampler>");
}

constexpr double kFalseAlarm = 1e-6;  ///< false-alarm rate of each statistical test of samplers

/// Tests pairs on a 16 x 16 grid against the uniform distribution by chi².
inline Verdict uniform_pairs(const std::function<Vec2(uint32_t)>& pair, uint32_t count) {
  constexpr int kSide = 16;
  std::vector<double> observed(kSide * kSide);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec2 p = pair(i);
    ++observed[static_cast<size_t>(p.y * kSide) * kSide + static_cast<size_t>(p.x * kSide)];
  }
  const std::vector<double> expected(kSide * kSide, static_cast<double>(count) / (kSide * kSide));
  return chi2_test(observed, expected, kFalseAlarm);
}

}  // namespace kinome::test
