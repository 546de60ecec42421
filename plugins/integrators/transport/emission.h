#pragma once

#include <span>
#include <vector>

#include "bucket_counts.h"
#include "numbers.h"
#include "scene_table.h"

namespace kinome::transport {

/// Light that leaves the scene's emitters, one ray for each sample of a block, of emitters picked
/// uniformly: rays sorted by emitter, so that each is asked once. The rays of an emitter are a
/// range that begins at a multiple of 16; the rest of its last vector repeats its last sample. One
/// per thread.
class Emission {
 public:
  /// Dimensions of the sampler: which emitter, where on it, whereto.
  static constexpr uint32_t kDimensions = 5;

  /// Rays first … first + count - 1, of one emitter.
  struct Range {
    const Emitter* emitter;
    size_t first;
    size_t count;
  };
  /// Rays that `samples` samples may make, padding included.
  static size_t most_rays(const SceneTable& scene, size_t samples);

  /// For blocks of at most `samples` samples. The scene must have emitters.
  Emission(const SceneTable& scene, size_t samples);

  /// An emitter for each of the samples, and where on it.
  void pick(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers);
  /// The rays, from the places that were picked.
  void sample(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers);

  /// Rays, count including the padding between ranges.
  size_t count() const { return count_; }
  std::span<const Range> ranges() const { return ranges_; }
  /// Of each ray: its sample, 1 (0 where it is padding), and the number that picks where on the
  /// emitter it starts.
  const uint32_t* owner() const { return owner_; }
  const float* live() const { return live_; }
  const Columns2& place() const { return place_; }
  /// The power doesn't count the pick, see emitters().
  const EmissionBlock& rays() const { return rays_; }
  /// How many emitters there are to be picked from.
  float emitters() const { return static_cast<float>(emitters_.size()); }

 private:
  void sort(size_t samples);
  const std::vector<const Emitter*>& emitters_;
  Arena per_sample_;
  uint32_t *all_, *pick_;
  float* which_;
  Arena per_ray_;
  uint32_t* owner_;
  float* live_;
  Columns2 place_, direction_;
  EmissionBlock rays_;
  size_t count_ = 0;
  BucketCounts next_;  ///< of each emitter: samples, then the place of the next
  std::vector<Range> ranges_;
};

}  // namespace kinome::transport
