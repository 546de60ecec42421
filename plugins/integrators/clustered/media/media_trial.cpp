#include "clustered/media/media_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "clustered/media/fog_block.h"
#include "kinome/log.h"
#include "kinome/stats.h"
#include "transport/blocks_of_tile.h"
#include "transport/media/volume_block.h"

namespace kinome {
namespace {

using transport::kBlockSamples;

/// Bounds on the samples per pixel of a block of the trial, powers of two. Blocks are about as
/// large as those of the render, because FogBlock learns in each block.
constexpr uint32_t kMinSamples = 16, kMaxSamples = 128;
constexpr size_t kMaxPixels = kBlockSamples / kMinSamples;
/// Bounds on the number of blocks, the share of the render's samples for the trial, and the maximum
/// share of the fewest blocks.
constexpr double kMinBlocks = 3, kMaxBlocks = 24, kTrialShare = 0.05, kMaxTrialShare = 0.15;
/// Maximum `max_depth` at which FogBlock renders without a trial.
constexpr uint32_t kMaxDepthUntried = 3;
/// Time of FogBlock for each ray, with all other work, relative to that of `volpath`; and the part
/// of it for each source at a finite distance. Measured in eight scenes.
constexpr double kCostOfRay = 1.6, kCostOfSource = 1. / 80;
constexpr uint64_t kTrialSeed = 0x666f6774;

/// Minimum factor by which candidates must take less work than `volpath`, beyond a standard error.
/// Smaller gains measured in a few blocks may be chance.
constexpr double kClearGain = 1.1;

/// Results of one method in one block.
struct Measured {
  std::array<double, kMaxPixels> mean{}, variance{};
  double cost = 0;
};

/// Sums over the pixels of one block.
struct Work {
  double error = 0, cost = 0;
};
/// Logarithm of the work of `volpath` relative to that of candidates, and its standard error.
struct Gain {
  double log, error;
};

/// `work`: of candidates and of `volpath`, in each block. The standard error is the jackknife's.
Gain gain_of_candidates(const std::vector<std::array<Work, 2>>& work) {
  const auto log_without = [&work](size_t left_out) {
    constexpr double kTiny = 1e-300;  // of methods without error
    std::array<Work, 2> sum;
    for (size_t i = 0; i < work.size(); ++i) {
      if (i == left_out) continue;
      for (size_t k = 0; k < 2; ++k) {
        sum[k].error += work[i][k].error;
        sum[k].cost += work[i][k].cost;
      }
    }
    return std::log(std::max(kTiny, sum[1].error) * sum[1].cost) -
           std::log(std::max(kTiny, sum[0].error) * sum[0].cost);
  };
  double sum = 0, squares = 0;
  for (size_t i = 0; i < work.size(); ++i) {
    const double value = log_without(i);
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(work.size());
  return {log_without(work.size()),
          std::sqrt(std::max(0., (squares - sum * sum / n) * (n - 1) / n))};
}

template <class Block>
Measured measure(Block& block, const PixelSamples& samples, double cost_of_ray) {
  RenderCounters counters;
  block.trace(samples, counters);
  Measured result;
  for (size_t p = 0; p < samples.pixels; ++p) {
    double sum = 0, squares = 0;
    for (size_t k = 0; k < samples.samples; ++k) {
      const double value = mean_of(block.radiance().at(p * samples.samples + k));
      sum += value;
      squares += value * value;
    }
    result.mean[p] = sum / samples.samples;
    result.variance[p] = std::max(0., squares / samples.samples - result.mean[p] * result.mean[p]);
  }
  double rays = 0;
  for (const RayKind kind : {RayKind::kCamera, RayKind::kShadow, RayKind::kBsdf}) {
    rays += static_cast<double>(counters[kind]);
  }
  result.cost = rays * cost_of_ray;
  return result;
}

}  // namespace

size_t blocks_of_trial(const Sensor& sensor) {
  const double samples =
      static_cast<double>(sensor.film().crop().area()) * sensor.sampler().sample_count();
  const double blocks = samples / (2 * kBlockSamples);
  if (blocks * kMaxTrialShare < kMinBlocks) return 0;
  return static_cast<size_t>(std::clamp(blocks * kTrialShare, kMinBlocks, kMaxBlocks));
}

bool prefers_paths_untried(const PathSettings& settings) {
  return settings.length.max_depth > kMaxDepthUntried;
}

bool prefers_paths(const transport::SceneTable& scene, const transport::MediaTable& media,
                   const FogSources& sources, const Sensor& sensor, const PathSettings& settings,
                   size_t count, RenderContext& context) {
  const Rect crop = sensor.film().crop();
  const uint32_t per_pixel =
      std::clamp(std::bit_floor(sensor.sampler().sample_count()), kMinSamples, kMaxSamples);
  const uint32_t pixels = kBlockSamples / per_pixel;
  const uint32_t width = 1u << std::bit_width(pixels) / 2, height = pixels / width;
  const StageTimer timer(context.job.stats().counters.stage_seconds["trial"]);
  const uint64_t seed = hash_words(key_seed(context.job, sensor.sampler()), kTrialSeed);
  const double cost_of_fog =
      kCostOfRay + kCostOfSource * static_cast<double>(sources.near().size());
  std::vector<std::array<Measured, 2>> measured(count);
  transport::Workers<FogBlock> fog_blocks;
  transport::Workers<transport::VolumeBlock> path_blocks;
  context.scheduler.parallel_for(count, [&](size_t i) {
    const uint64_t bits = hash_words(seed, i);
    const auto place = [&](uint32_t random, int begin, int size, uint32_t part) {
      const auto room = static_cast<float>(std::max(1, size - static_cast<int>(part)));
      return static_cast<uint32_t>(begin) + static_cast<uint32_t>(to_unit_float(random) * room);
    };
    const uint32_t x0 = place(static_cast<uint32_t>(bits), crop.x0, crop.width(), width);
    const uint32_t y0 = place(static_cast<uint32_t>(bits >> 32), crop.y0, crop.height(), height);
    std::array<uint32_t, kMaxPixels> x, y;
    for (uint32_t p = 0; p < pixels; ++p) x[p] = x0 + p % width, y[p] = y0 + p / width;
    const PixelSamples block{x.data(), y.data(), pixels, 0, per_pixel, seed};
    fog_blocks.with_one(
        [&] { return std::make_unique<FogBlock>(scene, media, sources, sensor, settings); },
        [&](FogBlock& fog) { measured[i][0] = measure(fog, block, cost_of_fog); });
    path_blocks.with_one(
        [&] { return std::make_unique<transport::VolumeBlock>(scene, media, sensor, settings); },
        [&](transport::VolumeBlock& paths) { measured[i][1] = measure(paths, block, 1); });
  });
  double mean = 0;
  for (const auto& both : measured) {
    for (size_t p = 0; p < pixels; ++p) mean += both[0].mean[p] + both[1].mean[p];
  }
  mean /= 2. * static_cast<double>(count) * pixels;
  std::vector<std::array<Work, 2>> work(count);
  for (size_t i = 0; i < count; ++i) {
    const auto& both = measured[i];
    // Relative to the brightness of the block: single dark pixels would decide otherwise.
    double value = 0;
    for (size_t p = 0; p < pixels; ++p) value += 0.5 * (both[0].mean[p] + both[1].mean[p]) / pixels;
    const double scale = value * value + 0.01 * mean * mean;
    for (size_t k = 0; k < 2; ++k) {
      work[i][k].cost = both[k].cost;
      if (scale == 0) continue;
      for (size_t p = 0; p < pixels; ++p) work[i][k].error += both[k].variance[p] / scale;
    }
  }
  const Gain gain = gain_of_candidates(work);
  log_debug(
      fmt::format("trial: work to the same error by candidates in media 1, by volpath {:.3g}, "
                  "with a relative standard error of {:.2g}",
                  std::exp(gain.log), gain.error));
  return gain.log < std::log(kClearGain) + gain.error;
}

}  // namespace kinome
