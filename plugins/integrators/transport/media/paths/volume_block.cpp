#include "transport/media/paths/volume_block.h"

#include <algorithm>
#include <memory>

#include "kinome/stats.h"
#include "transport/blocks/blocks_of_tile.h"

namespace kinome::transport {

VolumeBlock::VolumeBlock(const SceneTable& scene, const MediaTable& media, const Sensor& sensor,
                         const PathSettings& settings)
    : scene_(scene),
      camera_(scene, sensor, kBlockSamples, false),
      paths_(scene, media, sensor.sampler(), settings, kBlockSamples),
      film_(sensor.film().filter(), sensor.film().value_count(0), kBlockSamples,
            sensor.film().has_powers(0)),
      arena_(kBlockSamples + kBlockLanes),  // see FilmSamples::add
      light_(scene, sensor.film().response()),
      alpha_(arena_.floats()) {
  light_.add_color(values_);
  if (sensor.film().has_alpha()) values_.push_back(alpha_);
  light_.add_groups(values_);
}

void VolumeBlock::render(const PixelSamples& samples, Tile& tile) {
  trace(samples, tile.counters);
  const StageTimer timer(tile.counters.stage_seconds["film"]);
  light_.finish(samples.count());
  film_.add(samples, camera_.film_position(), values_, tile.film);
}

void VolumeBlock::trace(const PixelSamples& samples, RenderCounters& counters) {
  {
    const StageTimer timer(counters.stage_seconds["primary"]);
    camera_.make_rays(samples);
    clear_radiance(scene_, light_.radiance(), samples.count());
  }
  paths_.trace(samples, camera_.rays(), light_.radiance(), alpha_, counters);
}

void render_volumes(const SceneTable& scene, const MediaTable& media, const PathSettings& settings,
                    const Sensor& sensor, RenderContext& context) {
  render_tiles<VolumeBlock>(
      sensor, context, 0,
      [&] { return std::make_unique<VolumeBlock>(scene, media, sensor, settings); },
      [](VolumeBlock& block, const PixelSamples& samples, Tile& tile) {
        block.render(samples, tile);
      });
}

}  // namespace kinome::transport
