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
#include "transport/blocks/blocks_of_tile.h"
#include "transport/media/paths/volume_block.h"

namespace kinome {
namespace {

using transport::kBlockSamples;

/// Bounds on the samples per pixel of a block of the trial, powers of two. Blocks are about as
/// large as those of the render, because FogBlock learns in each block.
constexpr uint32_t kMinSamples = 16, kMaxSamples = 128;
constexpr size_t kMaxPixels = kBlockSamples / kMinSamples;
/// Bounds on the number of blocks, the share of the render's samples for the trial, and the maximum
/// share of the fewest blocks.
constexpr double kMinBlocks = 3, kMaxBlocks = 24, kTrialShare = 0.05, kMaxTrialShare = 0.2;
/// Maximum `max_depth` at which FogBlock renders without a trial.
constexpr uint32_t kMaxDepthUntried = 3;
/// Number of sources at finite distances from which on FogBlock renders without a trial, if there
/// are no others. `volpath` samples emitters with equal probabilities.
constexpr size_t kMinSourcesUntried = 16;
/// Time of FogBlock for each ray, with all other work, relative to that of `volpath`, in scenes
/// without and with sources at finite distances. Measured in four scenes.
constexpr double kCostOfRay = 2, kCostOfRayAmongNear = 4.2;
constexpr uint64_t kTrialSeed = 0x666f6774;

/// Minimum factor by which candidates must take less work than `volpath`, beyond a standard error.
/// Smaller gains measured in a few blocks may be chance.
constexpr double kClearGain = 1.1;

/// Results of one method in one block.
struct Measured {
  std::array<double, kMaxPixels> mean{}, variance{};
  double cost = 0;
};

/// Methods of the trial.
enum : size_t { kTriedCandidates, kTriedFewPaths, kTriedPaths, kTriedMethods };
constexpr std::array<const char*, kTriedMethods> kTriedNames{
    "candidates", "candidates with few paths", "volpath"};
using TrialResults = std::array<Measured, kTriedMethods>;

/// Pixels of a block of the trial, and the samples of each.
struct TrialBlock {
  std::array<uint32_t, kMaxPixels> x{}, y{};
  PixelSamples samples;

  /// Places block i anywhere in the image.
  TrialBlock(const Sensor& sensor, uint64_t seed, size_t i) {
    const Rect crop = sensor.film().crop();
    const uint32_t per_pixel =
        std::clamp(std::bit_floor(sensor.sampler().sample_count()), kMinSamples, kMaxSamples);
    const uint32_t pixels = kBlockSamples / per_pixel;
    const uint32_t width = 1u << std::bit_width(pixels) / 2, height = pixels / width;
    const uint64_t bits = hash_words(seed, i);
    const auto place = [&](uint32_t random, int begin, int size, uint32_t part) {
      const auto room = static_cast<float>(std::max(1, size - static_cast<int>(part)));
      return static_cast<uint32_t>(begin) + static_cast<uint32_t>(to_unit_float(random) * room);
    };
    const uint32_t x0 = place(static_cast<uint32_t>(bits), crop.x0, crop.width(), width);
    const uint32_t y0 = place(static_cast<uint32_t>(bits >> 32), crop.y0, crop.height(), height);
    for (uint32_t p = 0; p < pixels; ++p) x[p] = x0 + p % width, y[p] = y0 + p / width;
    samples = {x.data(), y.data(), pixels, 0, per_pixel, seed};
  }
};

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

Gain gain_of_first(std::span<const std::array<BlockWork, 2>> work) {
  const auto log_without = [work](size_t left_out) {
    constexpr double kTiny = 1e-100;  // of methods without error
    std::array<BlockWork, 2> sum;
    for (size_t i = 0; i < work.size(); ++i) {
      if (i == left_out) continue;
      for (size_t k = 0; k < 2; ++k) {
        sum[k].error += work[i][k].error;
        sum[k].cost += work[i][k].cost;
      }
    }
    const auto log_of = [kTiny](const BlockWork& w) {
      return std::log(std::max(kTiny, w.error)) + std::log(std::max(kTiny, w.cost));
    };
    return log_of(sum[1]) - log_of(sum[0]);
  };
  const auto n = static_cast<double>(work.size());
  double sum = 0, squares = 0;
  for (size_t i = 0; i < work.size(); ++i) sum += log_without(i);
  for (size_t i = 0; i < work.size(); ++i) squares += std::pow(log_without(i) - sum / n, 2);
  return {log_without(work.size()), std::sqrt(squares * (n - 1) / n)};
}

bool is_clear(const Gain& gain) {
  return gain.log >= std::log(kClearGain) + gain.error;
}

size_t blocks_of_trial(const Sensor& sensor) {
  const double samples =
      static_cast<double>(sensor.film().crop().area()) * sensor.sampler().sample_count();
  const double blocks = samples / (kTriedMethods * kBlockSamples);
  if (blocks * kMaxTrialShare < kMinBlocks) return 0;
  return static_cast<size_t>(std::clamp(blocks * kTrialShare, kMinBlocks, kMaxBlocks));
}

MediaChoice choose_untried(const PathSettings& settings, const FogSources& sources) {
  const bool are_many = sources.near().size() >= kMinSourcesUntried && sources.distant().empty();
  return {settings.length.max_depth > kMaxDepthUntried && !are_many, are_many ? kReducedPaths : 1};
}

namespace {

/// Returns errors and costs of all methods in each block. Errors are relative to the brightness of
/// the block: single dark pixels would decide otherwise.
std::vector<std::array<BlockWork, kTriedMethods>> work_of(const std::vector<TrialResults>& results,
                                                          size_t pixels) {
  const auto mean_of_block = [pixels](const TrialResults& of_block) {
    double sum = 0;
    for (const Measured& one : of_block) {
      for (size_t p = 0; p < pixels; ++p) sum += one.mean[p];
    }
    return sum / static_cast<double>(kTriedMethods * pixels);
  };
  double mean = 0;
  for (const TrialResults& of_block : results) mean += mean_of_block(of_block);
  mean /= static_cast<double>(results.size());
  std::vector<std::array<BlockWork, kTriedMethods>> work(results.size());
  for (size_t i = 0; i < results.size(); ++i) {
    const double value = mean_of_block(results[i]), scale = value * value + 0.01 * mean * mean;
    for (size_t k = 0; k < kTriedMethods; ++k) {
      work[i][k].cost = results[i][k].cost;
      if (scale == 0) continue;
      for (size_t p = 0; p < pixels; ++p) work[i][k].error += results[i][k].variance[p] / scale;
    }
  }
  return work;
}

}  // namespace

MediaChoice try_methods(const transport::SceneTable& scene, const transport::MediaTable& media,
                        const FogSources& sources, const Sensor& sensor,
                        const PathSettings& settings, size_t count, RenderContext& context) {
  const StageTimer timer(context.job.stats().counters.stage_seconds["trial"]);
  const uint64_t seed = hash_words(key_seed(context.job, sensor.sampler()), kTrialSeed);
  const double cost_of_fog = sources.near().empty() ? kCostOfRay : kCostOfRayAmongNear;
  std::vector<TrialResults> results(count);
  std::array<transport::Workers<FogBlock>, kTriedPaths> fog_blocks;
  transport::Workers<transport::VolumeBlock> path_blocks;
  context.scheduler.parallel_for(count, [&](size_t i) {
    const TrialBlock block(sensor, seed, i);
    for (const size_t k : {kTriedCandidates, kTriedFewPaths}) {
      const float paths = k == kTriedCandidates ? 1 : kReducedPaths;
      fog_blocks[k].with_one(
          [&] {
            return std::make_unique<FogBlock>(scene, media, sources, sensor, settings, paths);
          },
          [&](FogBlock& fog) { results[i][k] = measure(fog, block.samples, cost_of_fog); });
    }
    path_blocks.with_one(
        [&] { return std::make_unique<transport::VolumeBlock>(scene, media, sensor, settings); },
        [&](transport::VolumeBlock& paths) {
          results[i][kTriedPaths] = measure(paths, block.samples, 1);
        });
  });
  const auto work = work_of(results, TrialBlock(sensor, seed, 0).samples.pixels);
  const auto gain_over = [&work](size_t first, size_t second) {
    std::vector<std::array<BlockWork, 2>> both;
    for (const auto& of_block : work) both.push_back({of_block[first], of_block[second]});
    const Gain gain = gain_of_first(both);
    log_debug(
        fmt::format("trial in media: to the same error, {} takes {:.3g} times the work of {}, "
                    "with a relative standard error of {:.2g}",
                    kTriedNames[second], std::exp(gain.log), kTriedNames[first], gain.error));
    return gain;
  };
  const bool has_few = is_clear(gain_over(kTriedFewPaths, kTriedCandidates));
  const Gain gain = gain_over(has_few ? kTriedFewPaths : kTriedCandidates, kTriedPaths);
  return {!is_clear(gain), has_few ? kReducedPaths : 1};
}

}  // namespace kinome
