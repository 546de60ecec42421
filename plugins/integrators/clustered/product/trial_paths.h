#pragma once

#include <vector>

#include "clustered/product/method_trial.h"
#include "clustered/product/tile_grid.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "path_parameters.h"

namespace kinome {

/// A trial's other way to the picture: paths from the camera alone, as `path` traces them. Of the
/// arguments, all must outlive it.
class TrialPaths {
 public:
  TrialPaths(const Scene& scene, const Sensor& sensor, const TileGrid& grid,
             const PathLength& length, RenderContext& context)
      : scene_(scene),
        sensor_(sensor),
        grid_(grid),
        length_(length),
        context_(context) {}

  /// The mean of some paths, for each pixel of the tiles that the trial wants.
  void trace(const MethodTrial& trial, uint64_t seed, std::vector<Rgb>& picture) const;

 private:
  const Scene& scene_;
  const Sensor& sensor_;
  const TileGrid& grid_;
  const PathLength& length_;
  RenderContext& context_;
};

}  // namespace kinome
