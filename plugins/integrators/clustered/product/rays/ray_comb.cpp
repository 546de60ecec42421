#include "clustered/product/rays/ray_comb.h"

#include <algorithm>
#include <utility>

namespace kinome {
namespace {

/// Maximum number of rounds that search candidates to limit, and the relative error that rounding
/// may add up to.
constexpr int kCapRounds = 6;
constexpr double kNegligible = 1e-6;

/// Calls fn(weights, sum) for blocks that may contain a candidate heavier than `weight`.
template <class Function>
void for_heavy_blocks(Strata& strata, double weight, const Function& fn) {
  for (const Strata::Segment& segment : strata.segments()) {
    if (segment.kind == Strata::Kind::kDiffuse) continue;
    const Strata::Columns columns = strata.columns(segment);
    for (size_t block = 0; block < segment.size / simd::kCellLanes; ++block) {
      float& sum = columns.block_sums[block];
      if (sum > weight) fn(columns.weights + block * simd::kCellLanes, sum);
    }
  }
}

/// Returns the number of candidates heavier than `weight`, and the sum of their weights.
std::pair<size_t, double> heavier_candidates(Strata& strata, double weight) {
  const auto limit = static_cast<float>(weight);
  size_t count = 0;
  double total = 0;
  for_heavy_blocks(strata, weight, [&](const float* w, float) {
    float sum = 0;
    int heavier = 0;
    for (size_t i = 0; i < simd::kCellLanes; ++i) {
      sum += w[i] > limit ? w[i] : 0.f;
      heavier += w[i] > limit;
    }
    count += static_cast<size_t>(heavier);
    total += sum;
  });
  return {count, total};
}

}  // namespace

double cap_candidates(Strata& strata, size_t rays) {
  const double total = strata.total();
  if (!(total > 0)) return 0;
  double step = total / static_cast<double>(rays);
  size_t capped = 0;
  for (int i = 0; i < kCapRounds; ++i) {
    const auto [count, sum] = heavier_candidates(strata, step);
    if (count == capped) break;
    capped = count;
    const double left = total - sum;
    // Only candidates are left, and each of them gets a ray.
    if (capped >= rays || !(left > kNegligible * total)) break;
    step = left / static_cast<double>(rays - capped);
  }
  if (capped == 0) return step;
  const auto cap = static_cast<float>(step);
  for_heavy_blocks(strata, step, [&](float* w, float& block_sum) {
    float sum = 0;
    for (size_t i = 0; i < simd::kCellLanes; ++i) sum += w[i] = std::min(w[i], cap);
    block_sum = sum;
  });
  // Returns the rounded step, so that each limited candidate gets exactly one ray. The number of
  // the other rays may differ by one.
  return cap;
}

}  // namespace kinome
