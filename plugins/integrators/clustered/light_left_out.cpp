#include "clustered/light_left_out.h"

#include <array>
#include <cmath>

#include "kinome/log.h"
#include "kinome/owen.h"

namespace kinome {
namespace {

/// 4096 paths tell a share of 10 % to some tenths of itself at worst. Batches tell how well.
constexpr uint32_t kBatches = 32;
constexpr uint32_t kBatchPaths = 128;
/// A share that is less than this, or than so many standard errors, is not told.
constexpr double kLeastShare = 1e-3;
constexpr double kLeastErrors = 2;

/// Luminances, summed over the paths of a batch.
struct BatchSums {
  double all = 0;
  double beyond = 0;
};

/// Distinct random numbers for each path, wherever in the picture it begins.
std::vector<SampleKey> keys_of(const Rect& crop, uint32_t batch, uint64_t seed) {
  std::vector<SampleKey> keys;
  const uint64_t key_x = hash_words(seed, 1), key_y = hash_words(seed, 2);
  for (uint32_t i = batch * kBatchPaths; i < (batch + 1) * kBatchPaths; ++i) {
    const Vec2 at = owen_sobol_point(i, key_x, key_y);
    const auto x = static_cast<int>(at.x * static_cast<float>(crop.width()));
    const auto y = static_cast<int>(at.y * static_cast<float>(crop.height()));
    keys.push_back({static_cast<uint32_t>(crop.x0 + x), static_cast<uint32_t>(crop.y0 + y), 0,
                    hash_words(seed, 3, i)});
  }
  return keys;
}

BatchSums trace_batch(const PathSettings& settings, uint32_t longest, const Scene& scene,
                      const Sensor& sensor, std::span<const SampleKey> keys) {
  PrimaryBatch primary;
  PathTracer tracer;
  RenderCounters counters;  // of no one's interest
  std::vector<Rgb> radiance(keys.size(), Rgb(0.f)), beyond(keys.size(), Rgb(0.f));
  primary.trace(scene, sensor, keys, counters);
  if (settings.hide_emitters) {
    primary.pass_emitters(scene, counters);
  } else {
    primary.add_emitters(scene, radiance);
  }
  tracer.trace(settings, scene, sensor.sampler(), primary, {radiance, beyond, longest}, counters);
  BatchSums sums;
  for (size_t i = 0; i < keys.size(); ++i) {
    sums.all += luminance(radiance[i]) + luminance(beyond[i]);
    sums.beyond += luminance(beyond[i]);
  }
  return sums;
}

std::string percent(double share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), share < 0.00995 ? "%.1f %%" : "%.0f %%", 100 * share);
  return text.data();
}

}  // namespace

LightLeftOut measure_light_left_out(const PathSettings& settings, uint32_t longest,
                                    const Scene& scene, const Sensor& sensor,
                                    RenderContext& context) {
  const uint64_t seed = hash_words(key_seed(context, sensor.sampler()), 0x1ef7);
  std::array<BatchSums, kBatches> batches;
  context.parallel_for(kBatches, [&](size_t i) {
    const auto keys = keys_of(sensor.film().crop(), static_cast<uint32_t>(i), seed);
    batches[i] = trace_batch(settings, longest, scene, sensor, keys);
  });
  BatchSums sums;
  for (const BatchSums& batch : batches) {
    sums.all += batch.all;
    sums.beyond += batch.beyond;
  }
  LightLeftOut left_out;
  if (!(sums.all > 0) || !std::isfinite(sums.all)) return left_out;
  left_out.share = sums.beyond / sums.all;
  double squares = 0;  // of a ratio's residuals
  for (const BatchSums& batch : batches) {
    squares += std::pow(batch.beyond - left_out.share * batch.all, 2);
  }
  left_out.error = std::sqrt(squares * kBatches / (kBatches - 1.)) / sums.all;
  return left_out;
}

void warn_of_light_left_out(const Location& where, const PathSettings& asked, uint32_t longest,
                            const Scene& scene, const Sensor& sensor, RenderContext& context) {
  if (longest >= asked.length.max_depth || log_level() == LogLevel::kQuiet) return;
  const StageTimer timer(context.stats().counters.stage_seconds["light left out"]);
  const LightLeftOut found = measure_light_left_out(asked, longest, scene, sensor, context);
  if (found.share < kLeastShare || found.share < kLeastErrors * found.error) return;
  log_warn(Error(where, std::string("light after ") + (longest == 3 ? "two bounces" : "a bounce") +
                            " and more is left out: about " + percent(found.share) +
                            " of the picture ('path' renders all of it)")
               .what());
}

}  // namespace kinome
