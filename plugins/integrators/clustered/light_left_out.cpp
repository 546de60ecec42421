#include "clustered/light_left_out.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "kinome/log.h"
#include "kinome/primary_rays.h"
#include "kinome/wide/owen.h"
#include "transport/camera/camera.h"
#include "transport/paths/paths.h"

namespace kinome {
namespace {

/// 4096 paths measure a share of 10 % with a relative error of some tenths at worst. The batches
/// give the standard error.
constexpr uint32_t kBatches = 32;
constexpr uint32_t kBatchPaths = 128;
/// No warning is given for smaller shares, or for less than kMinErrors standard errors.
constexpr double kMinShare = 1e-3;
constexpr double kMinErrors = 2;

/// Luminances, summed over the paths of a batch.
struct BatchSums {
  double all = 0;
  double beyond = 0;
};

/// Samples of pixels distributed over the image, or of all pixels if the image is small. In a small
/// image, samples of one pixel have distinct random numbers. In a large image, two samples rarely
/// have the same pixel; they then have the same random numbers.
struct RandomPixels {
  uint32_t x[kBatchPaths], y[kBatchPaths];
  PixelSamples samples;

  RandomPixels(const Rect& crop, uint32_t batch, uint64_t seed)
      : samples{x, y, kBatchPaths, 0, 1, hash_words(seed, 3, batch)} {
    const auto area = static_cast<uint32_t>(crop.area());
    if (area <= kBatchPaths) {
      samples.pixels = area;
      samples.samples = kBatchPaths / area;
    }
    const auto width = static_cast<uint32_t>(crop.width());
    const uint64_t key_x = hash_words(seed, 1), key_y = hash_words(seed, 2);
    for (uint32_t i = 0; i < samples.pixels; ++i) {
      const Vec2 at = owen_sobol_point(batch * kBatchPaths + i, key_x, key_y);
      const bool every = area <= kBatchPaths;
      const auto column = every ? i % width : static_cast<uint32_t>(at.x * float(width));
      const auto row = every ? i / width : static_cast<uint32_t>(at.y * float(crop.height()));
      x[i] = static_cast<uint32_t>(crop.x0) + column;
      y[i] = static_cast<uint32_t>(crop.y0) + row;
    }
  }
  RandomPixels(const RandomPixels&) = delete;
};

BatchSums trace_batch(const PathSettings& settings, uint32_t longest,
                      const transport::SceneTable& scene, const Sensor& sensor,
                      const PixelSamples& samples) {
  transport::Camera camera(scene, sensor, kBatchPaths, settings.hide_emitters);
  transport::Paths paths(scene, sensor.sampler(), settings, kBatchPaths);
  transport::Arena arena(kBatchPaths);
  const Columns3 radiance = arena.three(), beyond = arena.three();
  RenderCounters counters;  // ignored
  camera.trace(samples, counters);
  camera.set_seen_light(radiance);
  paths.add(samples, camera.surfaces(), {radiance, beyond, longest}, counters);
  BatchSums sums;
  for (size_t i = 0; i < samples.count(); ++i) {
    const double left_out = static_cast<double>(luminance(beyond.at(i)));
    sums.all += static_cast<double>(luminance(radiance.at(i))) + left_out;
    sums.beyond += left_out;
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
  const uint64_t seed = hash_words(key_seed(context.job, sensor.sampler()), 0x1ef7);
  std::array<BatchSums, kBatches> batches;
  const transport::SceneTable table(scene);
  context.scheduler.parallel_for(kBatches, [&](size_t i) {
    const RandomPixels pixels(sensor.film().crop(), static_cast<uint32_t>(i), seed);
    batches[i] = trace_batch(settings, longest, table, sensor, pixels.samples);
  });
  BatchSums sums;
  for (const BatchSums& batch : batches) {
    sums.all += batch.all;
    sums.beyond += batch.beyond;
  }
  LightLeftOut left_out;
  if (!(sums.all > 0) || !std::isfinite(sums.all)) return left_out;
  left_out.share = sums.beyond / sums.all;
  double squares = 0;  // of the ratio's residuals
  for (const BatchSums& batch : batches) {
    squares += std::pow(batch.beyond - left_out.share * batch.all, 2);
  }
  left_out.error = std::sqrt(squares * kBatches / (kBatches - 1.)) / sums.all;
  return left_out;
}

void warn_of_ignored_light(const Location& where, const PathSettings& requested, uint32_t longest,
                           const Scene& scene, const Sensor& sensor, RenderContext& context) {
  if (longest >= requested.length.max_depth || log_level() == LogLevel::kQuiet) return;
  const StageTimer timer(context.job.stats().counters.stage_seconds["light left out"]);
  const LightLeftOut found = measure_light_left_out(requested, longest, scene, sensor, context);
  if (found.share < kMinShare || found.share < kMinErrors * found.error) return;
  const std::string message = fmt::format(
      "light after {} or more bounces is left out: about {} of the image ('path' renders all of "
      "it)",
      longest == 3 ? "two" : "one", percent(found.share));
  log_warn(Error(where, message).what());
}

}  // namespace kinome
