#include "kinome/primary_rays.h"

namespace kinome {

void PrimaryBatch::trace(const Scene& scene, const Sensor& sensor, const Rect& pixels,
                         uint32_t first_sample, uint32_t samples, uint64_t seed,
                         RenderCounters& counters) {
  samples_ = samples;
  keys_.clear();
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      for (uint32_t s = first_sample; s < first_sample + samples; ++s) {
        // A film that samples its border has negative coordinates, which also give distinct keys.
        keys_.push_back({static_cast<uint32_t>(x), static_cast<uint32_t>(y), s, seed});
      }
    }
  }
  trace_keys(scene, sensor, counters);
}

void PrimaryBatch::trace(const Scene& scene, const Sensor& sensor, std::span<const SampleKey> keys,
                         RenderCounters& counters) {
  samples_ = 1;
  keys_.assign(keys.begin(), keys.end());
  trace_keys(scene, sensor, counters);
}

void PrimaryBatch::trace_keys(const Scene& scene, const Sensor& sensor, RenderCounters& counters) {
  const size_t count = keys_.size();
  positions_.resize(count);
  hits_.resize(count);
  if (interactions_.size() < count) interactions_.resize(count);
  const Sampler& sampler = sensor.sampler();
  const bool has_aperture = sensor.needs_aperture_sample();
  for (size_t i = 0; i < count; ++i) {
    const SampleKey& key = keys_[i];
    const Vec2 position = kinome::film_position(static_cast<int>(key.x), static_cast<int>(key.y),
                                                sampler.value_2d(key, 0));
    const Vec2 aperture = has_aperture ? sampler.value_2d(key, 2) : Vec2(0.5f);
    positions_[i] = position;
    hits_[i].ray = sensor.sample_ray(position, aperture);
    hits_[i].hit = Hit{};
  }
  scene.intersect(hits_, Coherence::kCoherent, counters);
  counters[RayKind::kCamera] += count;
  for (size_t i = 0; i < count; ++i) {
    if (hits_[i].hit.valid()) interactions_[i] = scene.interaction(hits_[i]);
  }
}

}  // namespace kinome
