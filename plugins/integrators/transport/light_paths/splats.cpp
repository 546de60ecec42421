#include "transport/light_paths/splats.h"

#include <algorithm>

namespace kinome::transport {

Splats::Splats(const Sensor& sensor, size_t points)
    : sensor_(sensor),
      arena_(points),
      aperture_(arena_.two()),
      connection_{arena_.two(), arena_.three(), arena_.floats(), arena_.floats()},
      value_(arena_.three()),
      rays_(arena_.rays()),
      occlusion_(points) {
  std::fill_n(aperture_.x, arena_.capacity(), 0.5f);
  std::fill_n(aperture_.y, arena_.capacity(), 0.5f);
}

void Splats::choose_lens(const PixelSamples& samples, const uint32_t* owner, size_t count,
                         uint32_t dimension, Numbers& numbers) {
  if (!sensor_.needs_aperture_sample()) return;
  numbers.fill_2d(sensor_.sampler(), samples, dimension, owner, count, aperture_);
}

void Splats::connect(const Columns3& p, size_t first, size_t count) {
  sensor_.connect_block(p.from(first), aperture_.from(first), count, connection_.from(first));
}

void Splats::trace(const Scene& scene, size_t count, Tile& tile) {
  const StageTimer timer(tile.counters.stage_seconds["shadow"]);
  occlusion_.trace(scene, rays_, count, tile.counters);
  for (size_t i = 0; i < count; ++i) {
    // Neither inactive nor occluded.
    const float tmax = rays_[i / kBlockLanes].tmax[i % kBlockLanes];
    if (tmax >= 0) tile.film.add_splat(connection_.film_position.at(i), value_.at(i));
  }
}

}  // namespace kinome::transport
