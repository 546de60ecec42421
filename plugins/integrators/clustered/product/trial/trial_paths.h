#pragma once

#include <vector>

#include "clustered/product/trial/method_trial.h"
#include "clustered/product/tiles/tile_grid.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "transport/path_parameters.h"
#include "transport/scene_table.h"

namespace kinome {

/// The method of a trial that renders by the paths of `path`, with the sensor's sampler. All
/// arguments must outlive it.
class TrialPaths {
 public:
  TrialPaths(const transport::SceneTable& scene, const Sensor& sensor, const TileGrid& grid,
             const PathSettings& settings, RenderContext& context)
      : scene_(scene), sensor_(sensor), grid_(grid), settings_(settings), context_(context) {}

  /// Number of paths per pixel.
  static constexpr uint32_t kPaths = 16;
  /// Sets each pixel of the trial's tiles to the mean of kPaths paths.
  void trace(const MethodTrial& trial, uint64_t seed, std::vector<Rgb>& image) const;

 private:
  const transport::SceneTable& scene_;
  const Sensor& sensor_;
  const TileGrid& grid_;
  const PathSettings settings_;
  RenderContext& context_;
};

}  // namespace kinome
