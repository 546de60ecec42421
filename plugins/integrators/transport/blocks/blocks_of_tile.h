#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/primary_rays.h"

namespace kinome::transport {

/// Maximum number of samples in a block; such a block fits the caches. Other sizes (512, 8192)
/// change the time by up to 5 %. They also change the last bits of images if the filter spreads
/// samples over several pixels, because samples are summed in the order of the blocks.
inline constexpr size_t kBlockSamples = 2048;

/// Calls fn(const PixelSamples&) for blocks that together contain samples first … first + samples -
/// 1 of all pixels. A block is a rectangle of pixels, as square as possible, with all samples of
/// each pixel or as many as a block holds.
template <class Function>
void for_each_block(const Rect& pixels, uint32_t first, uint32_t samples, uint64_t seed,
                    const Function& fn) {
  const auto per_pixel = static_cast<uint32_t>(std::min<size_t>(samples, kBlockSamples));
  int width = 1, height = 1;
  while (static_cast<size_t>(2 * width * height) * per_pixel <= kBlockSamples) {
    (width <= height ? width : height) *= 2;
  }
  uint32_t x[kBlockSamples], y[kBlockSamples];
  for (int y0 = pixels.y0; y0 < pixels.y1; y0 += height) {
    for (int x0 = pixels.x0; x0 < pixels.x1; x0 += width) {
      size_t n = 0;
      for (int py = y0; py < std::min(y0 + height, pixels.y1); ++py) {
        for (int px = x0; px < std::min(x0 + width, pixels.x1); ++px, ++n) {
          x[n] = static_cast<uint32_t>(px);
          y[n] = static_cast<uint32_t>(py);
        }
      }
      for (uint32_t s = 0; s < samples; s += per_pixel) {
        fn(PixelSamples{x, y, n, first + s, std::min(per_pixel, samples - s), seed});
      }
    }
  }
}

/// Workers, one for each busy thread. They are created on demand and reused from tile to tile.
/// Thread-safe.
template <class Worker>
class Workers {
 public:
  /// Calls fn(worker) with an idle worker, or with a new one from `make` if none is idle.
  template <class Make, class Function>
  void with_one(const Make& make, const Function& fn) {
    std::unique_ptr<Worker> worker;
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        worker = std::move(idle_.back());
        idle_.pop_back();
      }
    }
    if (!worker) worker = make();
    fn(*worker);
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(worker));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Worker>> idle_;
};

/// Renders a layer of the sensor's film: calls fn(worker, samples, tile) for every block, on many
/// threads at once. Each thread has its own worker, from `make`.
template <class Worker, class Make, class Function>
void render_tiles(const Sensor& sensor, RenderContext& context, int layer, const Make& make,
                  const Function& fn) {
  const uint64_t seed = key_seed(context.job, sensor.sampler());
  Workers<Worker> workers;
  for_each_sample_range(
      context.job, sensor.sampler().sample_count(), [&](uint32_t first, uint32_t count) {
        const auto render = [&](Tile& tile) {
          workers.with_one(make, [&](Worker& worker) {
            for_each_block(tile.pixels, first, count, seed, [&](const PixelSamples& samples) {
              context.job.check_interrupt();
              fn(worker, samples, tile);
            });
          });
        };
        context.scheduler.for_each_tile(sensor.film(), render, layer);
      });
}

}  // namespace kinome::transport
