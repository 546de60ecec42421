#pragma once

#include <optional>
#include <vector>

#include "kinome/integrator.h"
#include "kinome/primary_rays.h"
#include "transport/blocks/blocks_of_tile.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"
#include "transport/paths/coverage.h"
#include "transport/surfaces/light_columns.h"

namespace kinome::transport {

/// Renders a block of camera rays, from tracing to the film. Call begin(), add reflected light to
/// radiance(), then call end(). Not thread-safe: use one per thread.
class CameraBlock {
 public:
  CameraBlock(const SceneTable& scene, const Sensor& sensor, const PathSettings& settings);

  /// Traces the rays, and sets radiance() to the light that they see directly
  /// (Camera::set_seen_light()).
  void begin(const PixelSamples& samples, RenderCounters& counters);
  /// Adds the radiance to the film, with its alpha (Coverage) if the film has one. `weight`: see
  /// FilmSamples::add.
  void end(const PixelSamples& samples, FilmTile& film, RenderCounters& counters,
           float weight = 1);

  const Surfaces& seen() const { return camera_.surfaces(); }
  /// Radiance of each sample, by light group; see SceneTable::group_offsets().
  const Columns3& radiance() const { return light_.radiance(); }

 private:
  Camera camera_;
  std::optional<Coverage> coverage_;
  FilmSamples film_;
  Arena arena_;
  LightColumns light_;
  float* alpha_;
  std::vector<float*> values_;
};

/// Renders layer 0 of the sensor's film. `shade(worker, block, samples, counters)` must add the
/// light that the surfaces reflect to a block's radiance. It is called on many threads at once,
/// each with its own worker from `make`. Stages: primary, film.
template <class Worker, class Make, class Shade>
void render_blocks(const SceneTable& scene, const Sensor& sensor, RenderContext& context,
                   const PathSettings& settings, const Make& make, const Shade& shade) {
  struct Both {
    CameraBlock block;
    std::unique_ptr<Worker> worker;
  };
  warn_without_emitters(scene.scene());
  render_tiles<Both>(
      sensor, context, 0,
      [&] { return std::unique_ptr<Both>(new Both{{scene, sensor, settings}, make()}); },
      [&](Both& both, const PixelSamples& samples, Tile& tile) {
        {
          const StageTimer timer(tile.counters.stage_seconds["primary"]);
          both.block.begin(samples, tile.counters);
        }
        shade(*both.worker, both.block, samples, tile.counters);
        const StageTimer timer(tile.counters.stage_seconds["film"]);
        both.block.end(samples, tile.film, tile.counters);
      });
}

}  // namespace kinome::transport
