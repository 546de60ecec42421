#include "volume_integrator.h"

#include <algorithm>

#include "../blocks_of_tile.h"
#include "../camera.h"
#include "../film_samples.h"
#include "kinome/stats.h"
#include "media_warnings.h"
#include "volume_paths.h"

namespace kinome::transport {

namespace {

/// Returns the settings for `path` that give the same paths where no light passes surfaces
/// straight: its roulette begins one point earlier.
PathSettings for_surfaces(PathSettings settings) {
  ++settings.length.rr_depth;
  return settings;
}

/// Renders blocks of camera rays, from the rays to the film. One per thread.
class VolumeBlock {
 public:
  VolumeBlock(const SceneTable& scene, const MediaTable& media, const Sensor& sensor,
              const PathSettings& settings)
      : camera_(scene, sensor, kBlockSamples, false),
        paths_(scene, media, sensor.sampler(), settings, kBlockSamples),
        film_(sensor.film().filter(), sensor.film().value_count(0), kBlockSamples,
              sensor.film().has_powers(0)),
        arena_(kBlockSamples + kBlockLanes),  // see FilmSamples::add
        radiance_(arena_.three()),
        alpha_(arena_.floats()),
        values_{radiance_.x, radiance_.y, radiance_.z} {
    if (sensor.film().has_alpha()) values_.push_back(alpha_);
  }

  void render(const PixelSamples& samples, Tile& tile) {
    {
      const StageTimer timer(tile.counters.stage_seconds["primary"]);
      camera_.make_rays(samples);
      for (float* const column : {radiance_.x, radiance_.y, radiance_.z}) {
        std::fill_n(column, padded(samples.count()), 0.f);
      }
    }
    paths_.trace(samples, camera_.rays(), radiance_, alpha_, tile.counters);
    const StageTimer timer(tile.counters.stage_seconds["film"]);
    film_.add(samples, camera_.film_position(), values_, tile.film);
  }

 private:
  Camera camera_;
  VolumePaths paths_;
  FilmSamples film_;
  Arena arena_;
  Columns3 radiance_;
  float* alpha_;
  std::vector<float*> values_;
};

}  // namespace

VolumeIntegrator::VolumeIntegrator(const PathSettings& settings)
    : PathIntegrator(for_surfaces(settings)), settings_(settings) {}

void VolumeIntegrator::warn_of_light_left_out(const Scene& scene, const Sensor& sensor,
                                              RenderContext& /*context*/) const {
  warn_of_media(scene, sensor);
}

void VolumeIntegrator::render(const Scene& scene, const Sensor& sensor,
                              RenderContext& context) const {
  const MediaTable media(scene, sensor);
  const SceneTable table(scene, media.phases());
  const bool has_emitters = !scene.emitters().empty();
  if ((media.size() == 1 && !table.passes_straight()) || settings_.length.max_depth == 0 ||
      !has_emitters) {
    return PathIntegrator::render(scene, sensor, context);
  }
  render_tiles<VolumeBlock>(
      sensor, context, 0,
      [&] { return std::make_unique<VolumeBlock>(table, media, sensor, settings_); },
      [](VolumeBlock& block, const PixelSamples& samples, Tile& tile) {
        block.render(samples, tile);
      });
}

}  // namespace kinome::transport
