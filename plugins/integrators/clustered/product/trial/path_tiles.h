#pragma once

#include <algorithm>
#include <vector>

#include "clustered/product/tiles/tile_grid.h"
#include "kinome/sensor.h"
#include "transport/path_parameters.h"
#include "transport/paths/camera_block.h"
#include "transport/paths/paths.h"

namespace kinome {

/// Traces paths of `path`, with the sensor's sampler, for the pixels of some tiles of a block. One
/// object per thread; not thread-safe. All arguments must outlive it.
class PathTiles {
 public:
  PathTiles(const transport::SceneTable& scene, const Sensor& sensor, const PathSettings& settings)
      : camera_(scene, sensor, settings),
        paths_(scene, sensor.sampler(), settings, transport::kBlockSamples) {}

  /// Traces `count` paths for each pixel of the wanted tiles, and calls fn(samples, camera) for
  /// each block of samples. Such a block has all paths of its pixels, or some of the paths of one
  /// pixel.
  template <class Wanted, class Function>
  void trace(const TileGrid& grid, int block, uint32_t count, uint64_t seed,
             RenderCounters& counters, const Wanted& is_wanted, const Function& fn) {
    x_.clear();
    y_.clear();
    grid.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      if (!is_wanted(tile)) return;
      tile.for_each_pixel([&](int x, int y) {
        x_.push_back(static_cast<uint32_t>(x));
        y_.push_back(static_cast<uint32_t>(y));
      });
    });
    const auto at_once = std::min<uint32_t>(count, transport::kBlockSamples);
    const size_t pixels_at_once = transport::kBlockSamples / at_once;
    for (size_t first = 0; first < x_.size(); first += pixels_at_once) {
      const size_t pixels = std::min(pixels_at_once, x_.size() - first);
      for (uint32_t s = 0; s < count; s += at_once) {
        const PixelSamples samples{&x_[first], &y_[first], pixels, s, std::min(at_once, count - s),
                                   seed};
        camera_.begin(samples, counters);
        const Columns3 radiance = camera_.radiance();
        paths_.add(samples, camera_.seen(), {radiance, radiance}, counters);
        fn(samples, camera_);
      }
    }
  }

 private:
  transport::CameraBlock camera_;
  transport::Paths paths_;
  std::vector<uint32_t> x_, y_;
};

}  // namespace kinome
