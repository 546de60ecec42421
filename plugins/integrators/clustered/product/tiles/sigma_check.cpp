// Checks the pilot's predictions: see the header.
#include "clustered/product/tiles/sigma_check.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "kinome/process_group.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/lanes.h"

namespace kinome {
namespace {

/// v is hidden below this margin, and visible above 1 minus it.
constexpr float kMargin = 0.01f;
/// Scale of the integer sums.
constexpr double kFixedPointUnit = 4294967296;
/// Weight of the prior: this much squared error is assumed to agree with its expectation, so that
/// few rays change little.
constexpr double kPriorWeight = 2;
/// Number of neighbouring steps on each side that count, too. Their weights halve with each step.
constexpr int kStepWindow = 2;
constexpr double kMinFactor = 0.02;
/// Minimum of sigma² by which rays are distributed.
constexpr float kMinCheckVariance = 1e-6f;

/// Right shift of a float's bits that leaves the exponent and the first binary digit: half octaves.
/// The result is kShiftedOne for 1, and smaller for smaller values.
constexpr int kShift = 22;
constexpr int32_t kShiftedOne = 254;

}  // namespace

void SigmaCheck::forget() {
  for (Sums& sums : sums_) sums.expected = sums.found = 0;
  is_finished_ = false;
}

void SigmaCheck::add_record(float v, float sigma, float visible) {
  const float variance = sigma * sigma, off = visible - v;
  const int step =
      std::clamp(kShiftedOne - (std::bit_cast<int32_t>(variance) >> kShift), 0, kSteps - 1);
  const int side = v < kMargin ? kHidden : v > 1 - kMargin ? kVisible : kNeither;
  Sums& sums = sums_[side * kSteps + step];
  const auto add = [](std::atomic<uint64_t>& sum, double value) {
    sum.fetch_add(static_cast<uint64_t>(value * kFixedPointUnit), std::memory_order_relaxed);
  };
  add(sums.expected, variance);
  add(sums.found, double{off} * off);
}

void SigmaCheck::sum_over_processes(ProcessGroup* group) {
  std::vector<uint64_t> numbers;
  for (const Sums& sums : sums_) numbers.insert(numbers.end(), {sums.expected, sums.found});
  kinome::sum_over_processes(group, numbers);
  for (size_t i = 0; i < sums_.size(); ++i) {
    sums_[i].expected = numbers[2 * i];
    sums_[i].found = numbers[2 * i + 1];
  }
}

void SigmaCheck::finish() {
  for (int side = 0; side < kSides; ++side) {
    for (int step = 0; step < kSteps; ++step) {
      double expected = 0, found = 0;
      const int end = std::min(step + kStepWindow + 1, kSteps);
      for (int k = std::max(step - kStepWindow, 0); k < end; ++k) {
        const Sums& sums = sums_[side * kSteps + k];
        const double share = std::exp2(-std::abs(k - step)) / kFixedPointUnit;
        expected += share * static_cast<double>(sums.expected);
        found += share * static_cast<double>(sums.found);
      }
      const double factor =
          std::max((found + kPriorWeight) / (expected + kPriorWeight), kMinFactor);
      // Cells that seem visible are so in most of the image, but uncertain in a few regions, which
      // this must not hide. So only half of the correction is applied, in logarithms.
      factor_[side * kSteps + step] =
          static_cast<float>(side == kVisible ? std::sqrt(factor) : factor);
    }
  }
  is_finished_ = true;
}

void SigmaCheck::correct(Visibility& visibility) const {
  if (!is_finished_) return;
  using namespace wide;
  for_lanes(visibility.v.size(), [&](size_t c) {
    const Float v = Float::load(&visibility.v[c]);
    const Float variance = sqr(Float::load(&visibility.sigma[c]));
    const Int step =
        min(max(Int(kShiftedOne) - shift_right<kShift>(as_int(variance)), Int(0)), Int(kSteps - 1));
    const Int side =
        select(v < kMargin, Int(kHidden), select(v > 1 - kMargin, Int(kVisible), Int(kNeither)));
    const Float factor = gather(factor_.data(), side * Int(kSteps) + step);
    sqrt(max(variance * factor, Float(kMinCheckVariance))).store(&visibility.sigma[c]);
  });
}

}  // namespace kinome
