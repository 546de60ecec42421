#include "kinome/primary_rays.h"

namespace kinome {

void PrimaryBatch::trace(const Scene& scene, const Sensor& sensor, const Rect& pixels,
                         uint32_t first_sample, uint32_t samples, uint64_t seed,
                         RenderCounters& counters) {
  const size_t count = static_cast<size_t>(pixels.area()) * samples;
  samples_ = samples;
  keys_.resize(count);
  positions_.resize(count);
  hits_.resize(count);
  far_.resize(count);
  if (interactions_.size() < count) interactions_.resize(count);

  const Sampler& sampler = sensor.sampler();
  const bool has_aperture = sensor.needs_aperture_sample();
  size_t i = 0;
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      for (uint32_t s = 0; s < samples; ++s, ++i) {
        // A film that samples its border has pixels left of 0: distinct keys all the same.
        const SampleKey key{static_cast<uint32_t>(x), static_cast<uint32_t>(y), first_sample + s,
                            seed};
        const Vec2 position = kinome::film_position(x, y, sampler.value_2d(key, 0));
        const Vec2 aperture = has_aperture ? sampler.value_2d(key, 2) : Vec2(0.5f);
        keys_[i] = key;
        positions_[i] = position;
        hits_[i].ray = sensor.sample_ray(position, aperture);
        hits_[i].hit = Hit{};
        far_[i] = hits_[i].ray.tmax;
      }
    }
  }
  scene.intersect(hits_, Coherence::kCoherent, counters);
  counters[RayKind::kCamera] += count;
  for (i = 0; i < count; ++i) {
    if (hits_[i].hit.valid()) interactions_[i] = scene.interaction(hits_[i]);
  }
}

void PrimaryBatch::pass_emitters(const Scene& scene, RenderCounters& counters) {
  if (!scene.has_surface_emitters()) return;
  const auto emits = [this](size_t i) { return hit(i) && interactions_[i].shape->emitter(); };
  passing_.clear();
  for (uint32_t i = 0; i < size(); ++i) {
    if (emits(i)) passing_.push_back(i);
  }
  while (!passing_.empty()) {
    beyond_.clear();
    for (const uint32_t i : passing_) {
      Ray ray = hits_[i].ray;
      ray.o = interactions_[i].ray_origin(ray.d);
      ray.tmin = 0;
      ray.tmax = far_[i] - hits_[i].ray.tmax;
      beyond_.push_back({ray, Hit{}});
    }
    scene.intersect(beyond_, Coherence::kCoherent, counters);
    counters[RayKind::kCamera] += beyond_.size();
    for (size_t k = 0; k < passing_.size(); ++k) {
      const uint32_t i = passing_[k];
      const float begin = hits_[i].ray.tmax;
      hits_[i].hit = beyond_[k].hit;
      hits_[i].ray.tmax = begin + beyond_[k].ray.tmax;
      if (!hit(i)) continue;
      interactions_[i] = scene.interaction(beyond_[k]);
      interactions_[i].t += begin;
    }
    std::erase_if(passing_, [&](uint32_t i) { return !emits(i); });
  }
}

}  // namespace kinome
