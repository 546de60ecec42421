#pragma once

#include <span>
#include <vector>

#include "kinome/render_context.h"
#include "kinome/sampler.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"
#include "kinome/stats.h"

namespace kinome {

/// The first and the last stage of most integrators.
inline constexpr Stage kPrimaryStage{"primary", "traces rays from the camera"};
inline constexpr Stage kFilmStage{"film", "adds up the picture"};

/// What SampleKey::seed is throughout a render: of `--seed` and of the scene's sampler.
inline uint64_t key_seed(const RenderContext& context, const Sampler& sampler) {
  return hash_words(context.seed(), sampler.seed());
}

/// Primary rays of some pixels, traced together, with the surfaces that they meet: the G-buffer of
/// a (part of a) tile (Åkerlund 2008, 2.3.2 and 4.3.2). Keeps its memory from one trace to the
/// next: make one per thread (thread_local), not one per tile. Not thread-safe.
class KINOME_EXPORT PrimaryBatch {
 public:
  /// Samples [first_sample, first_sample + samples) of every pixel of `pixels`; a few thousand rays
  /// at a time are fastest. Counts camera rays and the time inside Embree.
  void trace(const Scene& scene, const Sensor& sensor, const Rect& pixels, uint32_t first_sample,
             uint32_t samples, uint64_t seed, RenderCounters& counters);
  /// One ray for each of these samples of pixels.
  void trace(const Scene& scene, const Sensor& sensor, std::span<const SampleKey> keys,
             RenderCounters& counters);

  /// Rays are in the order of pixels (row by row), a pixel's samples side by side: ray of the
  /// p-th pixel and its s-th sample in this batch is p * samples() + s.
  size_t size() const { return keys_.size(); }
  uint32_t samples() const { return samples_; }

  const SampleKey& key(size_t i) const { return keys_[i]; }
  const Vec2& film_position(size_t i) const { return positions_[i]; }
  /// ray.tmax is the distance of the hit, where there is one.
  const RayHit& ray_hit(size_t i) const { return hits_[i]; }
  bool hit(size_t i) const { return hits_[i].hit.valid(); }
  /// Only where hit(i).
  const SurfaceInteraction& interaction(size_t i) const { return interactions_[i]; }

 private:
  void trace_keys(const Scene& scene, const Sensor& sensor, RenderCounters& counters);

  uint32_t samples_ = 1;
  std::vector<SampleKey> keys_;
  std::vector<Vec2> positions_;
  std::vector<RayHit> hits_;
  std::vector<SurfaceInteraction> interactions_;  ///< never shrinks: only valid hits are written
};

/// Calls fn(first_sample, samples) for consecutive parts of a pixel's samples, such that a part of
/// a tile is about `rays` rays: the way to render tile by tile in batches of a bounded size.
template <class Function>
void for_each_part(const Rect& pixels, uint32_t samples_per_pixel, uint32_t rays, Function&& fn) {
  const auto area = static_cast<uint32_t>(std::max(1, pixels.area()));
  const uint32_t step = std::max(1u, rays / area);
  for (uint32_t first = 0; first < samples_per_pixel; first += step) {
    fn(first, std::min(step, samples_per_pixel - first));
  }
}

/// Calls fn(first_sample, samples) for consecutive parts of a pixel's samples, each of which is to
/// be rendered for all of the film: a render of very many samples shows progress, and is a picture
/// whenever it is interrupted.
template <class Function>
void for_each_sample_range(RenderContext& context, uint32_t samples_per_pixel, Function&& fn) {
  constexpr uint32_t kSamples = 1024;
  const auto share = [&](uint32_t n) { return static_cast<double>(n) / samples_per_pixel; };
  for (uint32_t first = 0; first < samples_per_pixel && !context.cancelled(); first += kSamples) {
    const uint32_t count = std::min(kSamples, samples_per_pixel - first);
    context.set_progress_range(share(first), share(first + count));
    fn(first, count);
  }
  context.set_progress_range(0, 1);
}

}  // namespace kinome
