#pragma once

#include <vector>

#include "kinome/render_context.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"
#include "transport/media/paths/volume_paths.h"
#include "transport/surfaces/light_columns.h"

namespace kinome::transport {

/// Renders blocks of camera rays by VolumePaths, from the rays to the film. Not thread-safe: use
/// one per thread.
class VolumeBlock {
 public:
  VolumeBlock(const SceneTable& scene, const MediaTable& media, const Sensor& sensor,
              const PathSettings& settings);

  void render(const PixelSamples& samples, Tile& tile);
  /// Sets radiance() without changing a film.
  void trace(const PixelSamples& samples, RenderCounters& counters);
  /// Radiance of each sample, by light group; see SceneTable::group_offsets().
  const Columns3& radiance() const { return light_.radiance(); }

 private:
  const SceneTable& scene_;
  Camera camera_;
  VolumePaths paths_;
  FilmSamples film_;
  Arena arena_;
  LightColumns light_;
  float* alpha_;
  std::vector<float*> values_;
};

/// Renders the image of a sensor by VolumePaths.
void render_volumes(const SceneTable& scene, const MediaTable& media, const PathSettings& settings,
                    const Sensor& sensor, RenderContext& context);

}  // namespace kinome::transport
