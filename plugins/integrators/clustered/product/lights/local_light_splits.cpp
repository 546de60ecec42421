// The part of LocalLight that splits light walks whose remaining light matters much.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/render_context.h"

namespace kinome {
namespace {

/// Number of cells for which the later use of walks is learned: the contribution to the image of
/// the points that a walk leaves after the current one.
constexpr uint32_t kSplitCells = 256;
/// Weight of power in the partition into these cells; the rest is later use.
constexpr double kPowerWeight = 0.01;
constexpr float kMaxParts = 32;
/// Walks are not split if their later use is below this quantile of all later use.
constexpr double kMinSplitQuantile = 0.5;
/// Maximum number of additional parts, relative to the number of light points.
constexpr double kMaxExtraParts = 0.25;
/// Walks are split only if at least kMinShare of the later use belongs to walks with at least
/// kMinParts parts. Otherwise, the use of walks is even enough.
constexpr double kMinShare = 0.1;
constexpr float kMinParts = 4;
constexpr int kUnitRounds = 40;
constexpr float kUnitStep = 1.25f;

float power_of(const LightPoint& point) {
  return mean_of(glm::abs(point.power));
}

float parts_of(float value) {
  return std::floor(std::clamp(value, 1.f, kMaxParts));
}

/// Returns the later use that one part should have, or infinity if walks should not be split.
/// `expected` has the expected later use at each point, sorted.
float use_of_part(std::span<const float> expected, double max_extra) {
  double all = 0, below = 0;
  for (const float value : expected) all += value;
  float unit = expected.back();
  for (const float value : expected) {
    below += value;
    if (below < kMinSplitQuantile * all) continue;
    unit = value;
    break;
  }
  for (int round = 0; round < kUnitRounds; ++round, unit *= kUnitStep) {
    double extra = 0;
    for (const float value : expected) extra += parts_of(value / unit) - 1;
    if (extra <= max_extra) break;
  }
  double of_many = 0;
  for (const float value : expected) {
    if (value >= kMinParts * unit) of_many += value;
  }
  return of_many >= kMinShare * all ? unit : kInfinity;
}

}  // namespace

uint32_t LocalLight::parts_at(const LightPoint& point) const {
  if (splits_.empty()) return 1;
  const uint32_t cell = split_partition_.cell_of({point.position, point.normal});
  return static_cast<uint32_t>(parts_of(power_of(point) * splits_[cell]));
}

bool LocalLight::learn_splits(const std::vector<Drawn>& drawn,
                              std::span<const SurfaceInteraction> seen, uint64_t seed,
                              RenderContext& context) {
  if (max_depth() <= kBounceDepth || seen.empty()) return false;
  const std::vector<LightGuide::Use> uses = find_uses(drawn, seen, seed, context);
  std::vector<size_t> first;  // index of each chunk's first point
  size_t count = 0;
  for (const Drawn& chunk : drawn) {
    first.push_back(count);
    count += chunk.points.size();
  }
  std::vector<OrientedPoint> places(count);
  // `later`: use of the points that the walk leaves afterwards.
  std::vector<float> powers(count), later(count);
  context.scheduler.parallel_for(drawn.size(), [&](size_t c) {
    const Drawn& chunk = drawn[c];
    std::unordered_map<uint64_t, float> of_walk;
    // A walk's later points come after its earlier ones.
    for (size_t i = chunk.points.size(); i-- > 0;) {
      const size_t k = first[c] + i;
      float& sum = of_walk[chunk.walk_of[i]];
      later[k] = sum;
      sum += uses[k].use;
      places[k] = {chunk.points[i].position, chunk.points[i].normal};
      powers[k] = power_of(chunk.points[i]);
    }
  });
  double all_power = 0, all_later = 0;
  for (size_t i = 0; i < count; ++i) {
    all_power += powers[i];
    all_later += later[i];
  }
  if (!(all_later > 0) || !(all_power > 0)) return false;
  std::vector<float> weights(count);
  for (size_t i = 0; i < count; ++i) {
    weights[i] = static_cast<float>(later[i] / all_later + kPowerWeight * powers[i] / all_power);
  }
  std::vector<uint32_t> cells;
  split_partition_ = PointPartition(places, weights, kSplitCells, &context.scheduler, &cells);
  std::vector<double> power(split_partition_.size()), use(split_partition_.size());
  for (size_t i = 0; i < count; ++i) {
    power[cells[i]] += powers[i];
    use[cells[i]] += later[i];
  }
  std::vector<float> expected;
  for (size_t i = 0; i < places.size(); ++i) {
    const uint32_t c = cells[i];
    if (use[c] > 0) expected.push_back(static_cast<float>(powers[i] * (use[c] / power[c])));
  }
  std::sort(expected.begin(), expected.end());
  const float unit = use_of_part(expected, kMaxExtraParts * static_cast<double>(places.size()));
  if (!std::isfinite(unit)) return false;
  for (size_t c = 0; c < power.size(); ++c) {
    splits_.push_back(power[c] > 0 ? static_cast<float>(use[c] / power[c] / unit) : 0.f);
  }
  return true;
}

}  // namespace kinome
