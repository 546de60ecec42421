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
        // A film that samples its border has pixels left of 0: distinct keys all the same.
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
  far_.resize(count);
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
    far_[i] = hits_[i].ray.tmax;
  }
  scene.intersect(hits_, Coherence::kCoherent, counters);
  counters[RayKind::kCamera] += count;
  for (size_t i = 0; i < count; ++i) {
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

void PrimaryBatch::add_emitters(const Scene& scene, std::span<Rgb> radiance) {
  directions_.clear();
  missed_.clear();
  for (uint32_t i = 0; i < size(); ++i) {
    if (hit(i)) {
      const Emitter* const emitter = interactions_[i].shape->emitter();
      if (emitter) radiance[i] += emitter->eval_surface(interactions_[i]);
    } else if (scene.environment()) {
      directions_.push_back(hits_[i].ray.d);
      missed_.push_back(i);
    }
  }
  if (directions_.empty()) return;
  environment_.resize(directions_.size());
  scene.environment()->eval_environment_batch(directions_, environment_, {});
  for (size_t k = 0; k < missed_.size(); ++k) radiance[missed_[k]] += environment_[k];
}

void PrimaryBatch::add_to_film(std::span<const Rgb> radiance, bool has_alpha,
                               FilmTile& film) const {
  for (size_t i = 0; i < size(); ++i) {
    const Rgb& L = radiance[i];
    const float values[4] = {L.x, L.y, L.z, hit(i) ? 1.f : 0.f};
    film.add(positions_[i], {values, has_alpha ? 4u : 3u});
  }
}

void shade_primary_rays(const Scene& scene, const Sensor& sensor, RenderContext& context,
                        bool hide_emitters, const ShadePrimary& shade) {
  warn_without_emitters(scene);
  constexpr uint32_t kRays = 2048;  // what fits the caches
  Film& film = sensor.film();
  const uint64_t seed = key_seed(context, sensor.sampler());
  const auto render_part = [&](Tile& tile, uint32_t first, uint32_t samples) {
    thread_local PrimaryBatch primary;
    thread_local std::vector<Rgb> radiance;
    {
      const StageTimer timer(tile.counters.stage_seconds["primary"]);
      primary.trace(scene, sensor, tile.pixels, first, samples, seed, tile.counters);
      radiance.assign(primary.size(), Rgb(0.f));
      if (hide_emitters) {
        primary.pass_emitters(scene, tile.counters);
      } else {
        primary.add_emitters(scene, radiance);
      }
    }
    shade(primary, radiance, tile.counters);
    const StageTimer timer(tile.counters.stage_seconds["film"]);
    primary.add_to_film(radiance, film.has_alpha(), tile.film);
  };
  for_each_sample_range(
      context, sensor.sampler().sample_count(), [&](uint32_t begin, uint32_t count) {
        context.for_each_tile(film, [&](Tile& tile) {
          for_each_part(tile.pixels, count, kRays, [&](uint32_t first, uint32_t samples) {
            render_part(tile, begin + first, samples);
          });
        });
      });
}

}  // namespace kinome
