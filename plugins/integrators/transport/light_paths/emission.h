#pragma once

#include <span>
#include <vector>

#include "transport/blocks/bucket_counts.h"
#include "transport/blocks/numbers.h"
#include "transport/surfaces/scene_table.h"

namespace kinome::transport {

/// Rays of light from the scene's emitters, one for each sample of a block. Emitters are chosen
/// uniformly. Rays are sorted by emitter, so that each emitter is called once. The rays of an
/// emitter are a range that begins at a multiple of 16; the rest of its last vector repeats its
/// last sample. Not thread-safe: use one per thread.
class Emission {
 public:
  /// Number of sampler dimensions: one for the emitter, two for the position on it, two for the
  /// direction.
  static constexpr uint32_t kDimensions = 5;

  /// Rays first … first + count - 1, of one emitter.
  struct Range {
    const Emitter* emitter;
    size_t first;
    size_t count;
  };
  /// Maximum number of rays of `samples` samples, padding included.
  static size_t max_rays(const SceneTable& scene, size_t samples);

  /// Allocates memory for blocks of at most `samples` samples. The scene must have emitters.
  Emission(const SceneTable& scene, size_t samples);

  /// Chooses an emitter for each sample, and draws the random numbers for the position on it.
  void pick(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers);
  /// Samples the rays that leave the chosen positions.
  void sample(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers);

  /// Number of rays, including the padding between ranges.
  size_t count() const { return count_; }
  std::span<const Range> ranges() const { return ranges_; }
  /// Columns with an entry for each ray: owner() is its sample; live() is 1, or 0 for padding;
  /// place() has the random numbers for the position on the emitter.
  const uint32_t* owner() const { return owner_; }
  const float* live() const { return live_; }
  const Columns2& place() const { return place_; }
  /// Rays with their powers. Powers don't include the probability of the emitter; multiply them by
  /// emitters().
  const EmissionBlock& rays() const { return rays_; }
  /// Number of emitters to choose from.
  float emitters() const { return static_cast<float>(emitters_.size()); }

 private:
  void sort(size_t samples);
  const std::vector<const Emitter*>& emitters_;
  Arena per_sample_;
  uint32_t *all_, *pick_;
  float* u_pick_;
  Arena per_ray_;
  uint32_t* owner_;
  float* live_;
  Columns2 place_, direction_;
  EmissionBlock rays_;
  size_t count_ = 0;
  BucketCounts next_;  ///< for each emitter: number of samples, then the position of the next
  std::vector<Range> ranges_;
};

}  // namespace kinome::transport
