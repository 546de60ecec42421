#pragma once

#include <vector>

#include "../camera.h"
#include "../film_samples.h"
#include "kinome/render_context.h"
#include "volume_paths.h"

namespace kinome::transport {

/// Renders blocks of camera rays by VolumePaths, from the rays to the film. One per thread.
class VolumeBlock {
 public:
  VolumeBlock(const SceneTable& scene, const MediaTable& media, const Sensor& sensor,
              const PathSettings& settings);

  void render(const PixelSamples& samples, Tile& tile);
  /// Sets radiance() without changing a film.
  void trace(const PixelSamples& samples, RenderCounters& counters);
  const Columns3& radiance() const { return radiance_; }

 private:
  Camera camera_;
  VolumePaths paths_;
  FilmSamples film_;
  Arena arena_;
  Columns3 radiance_;
  float* alpha_;
  std::vector<float*> values_;
};

/// Renders the image of a sensor by VolumePaths.
void render_volumes(const SceneTable& scene, const MediaTable& media, const PathSettings& settings,
                    const Sensor& sensor, RenderContext& context);

}  // namespace kinome::transport
