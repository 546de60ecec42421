#pragma once

#include <span>
#include <vector>

#include "kinome/render_context.h"
#include "kinome/sampler.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome {

/// First and last stage of most integrators.
inline constexpr Stage kPrimaryStage{"primary", "traces rays from the camera"};
inline constexpr Stage kFilmStage{"film", "adds samples to the film"};

/// Value of SampleKey::seed throughout a render: combines `--seed` and the seed of the scene's
/// sampler.
inline uint64_t key_seed(const RenderJob& job, const Sampler& sampler) {
  return hash_words(job.seed(), sampler.seed());
}

/// Camera rays of some pixels, traced together, and the surfaces they hit: the G-buffer of a tile
/// or part of it (Åkerlund 2008, 2.3.2 and 4.3.2). Keeps its memory between traces: use one per
/// thread (thread_local), not one per tile. Not thread-safe.
class KINOME_EXPORT PrimaryBatch {
 public:
  /// Traces samples [first_sample, first_sample + samples) of every pixel of `pixels`; batches of a
  /// few thousand rays are fastest. Adds camera rays and the time inside Embree to `counters`.
  void trace(const Scene& scene, const Sensor& sensor, const Rect& pixels, uint32_t first_sample,
             uint32_t samples, uint64_t seed, RenderCounters& counters);
  /// Traces one ray per key.
  void trace(const Scene& scene, const Sensor& sensor, std::span<const SampleKey> keys,
             RenderCounters& counters);

  /// Number of rays. Rays are ordered by pixel (row by row), then by sample: sample s of the p-th
  /// pixel is ray p * samples() + s.
  size_t size() const { return keys_.size(); }
  uint32_t samples() const { return samples_; }

  const SampleKey& key(size_t i) const { return keys_[i]; }
  const Vec2& film_position(size_t i) const { return positions_[i]; }
  /// Ray and hit; ray.tmax is the distance of a valid hit.
  const RayHit& ray_hit(size_t i) const { return hits_[i]; }
  bool hit(size_t i) const { return hits_[i].hit.valid(); }
  /// Surface interaction; valid only if hit(i).
  const SurfaceInteraction& interaction(size_t i) const { return interactions_[i]; }

 private:
  void trace_keys(const Scene& scene, const Sensor& sensor, RenderCounters& counters);

  uint32_t samples_ = 1;
  std::vector<SampleKey> keys_;
  std::vector<Vec2> positions_;
  std::vector<RayHit> hits_;
  std::vector<SurfaceInteraction> interactions_;  ///< never shrinks; entries without a hit are
                                                  ///< stale
};

/// Splits a pixel's samples into consecutive ranges, so that one range over a tile has about `rays`
/// rays, and calls fn(first_sample, samples) for each. Renders a tile in batches of bounded size.
template <class Function>
void for_each_part(const Rect& pixels, uint32_t samples_per_pixel, uint32_t rays, Function&& fn) {
  const auto area = static_cast<uint32_t>(std::max(1, pixels.area()));
  const uint32_t step = std::max(1u, rays / area);
  for (uint32_t first = 0; first < samples_per_pixel; first += step) {
    fn(first, std::min(step, samples_per_pixel - first));
  }
}

/// Splits a pixel's samples into consecutive ranges, each rendered over the whole film, and calls
/// fn(first_sample, samples) for each. Renders with very many samples thus show progress and can be
/// interrupted with a usable image.
template <class Function>
void for_each_sample_range(RenderJob& job, uint32_t samples_per_pixel, Function&& fn) {
  constexpr uint32_t kSamples = 1024;
  const auto share = [&](uint32_t n) { return static_cast<double>(n) / samples_per_pixel; };
  for (uint32_t first = 0; first < samples_per_pixel && !job.cancelled(); first += kSamples) {
    const uint32_t count = std::min(kSamples, samples_per_pixel - first);
    job.set_progress_range(share(first), share(first + count));
    fn(first, count);
  }
  job.set_progress_range(0, 1);
}

}  // namespace kinome
