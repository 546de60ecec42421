#include "transport/paths/camera_block.h"

namespace kinome::transport {

CameraBlock::CameraBlock(const SceneTable& scene, const Sensor& sensor,
                         const PathSettings& settings)
    : camera_(scene, sensor, kBlockSamples, settings.hide_emitters),
      film_(sensor.film().filter(), sensor.film().value_count(0), kBlockSamples,
            sensor.film().has_powers(0)),
      arena_(kBlockSamples + kBlockLanes),  // see FilmSamples::add
      light_(scene, sensor.film().response()),
      alpha_(arena_.floats()) {
  light_.add_color(values_);
  if (sensor.film().has_alpha()) {
    coverage_.emplace(scene, sensor.sampler(), settings, kBlockSamples);
    values_.push_back(alpha_);
  }
  light_.add_groups(values_);
}

void CameraBlock::begin(const PixelSamples& samples, RenderCounters& counters) {
  camera_.trace(samples, counters);
  camera_.set_seen_light(light_.radiance());
}

void CameraBlock::end(const PixelSamples& samples, FilmTile& film, RenderCounters& counters,
                      float weight) {
  if (coverage_) coverage_->find(samples, camera_, alpha_, counters);
  light_.finish(samples.count());
  film_.add(samples, camera_.film_position(), values_, film, weight);
}

}  // namespace kinome::transport
