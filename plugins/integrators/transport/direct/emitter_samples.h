#pragma once

#include <vector>

#include "transport/blocks/numbers.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Sets the density to 0 for samples of a surface's emitter whose point is on the same surface and
/// too close to distinguish from rounding errors; see SurfaceInteraction::resolves(). Sample
/// which[i] belongs to point which[i].
void drop_self_occlusion(const Emitter& emitter, const SurfaceBlock& points, const uint32_t* which,
                         size_t count, const DirectBlock& samples);

/// Samples of the scene's emitters, one for each point of a block. Emitters are chosen uniformly.
/// Not thread-safe: use one per thread.
class EmitterSamples {
 public:
  /// Number of sampler dimensions: one for the emitter, two for the position on it.
  static constexpr uint32_t kDimensions = 3;

  EmitterSamples(const SceneTable& scene, size_t points);

  /// Samples an emitter for each of points[0 … count - 1], which belong to the samples `owner`.
  /// `count` must be a multiple of 16. The scene must have emitters.
  void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
              const SurfaceBlock& points, const uint32_t* owner, size_t count, Numbers& numbers);
  /// Samples, one for each point. Densities don't include the probability of the emitter,
  /// pick_pdf(). is_delta is set for all emitters that rays can't hit, even if they aren't delta
  /// emitters.
  const DirectBlock& light() const { return light_; }
  float pick_pdf() const { return pick_pdf_; }
  /// Index of each point's emitter in Scene::emitters().
  const uint32_t* picked() const { return pick_; }
  /// True if a single emitter lights all points, each from one direction.
  bool have_common_origin() const { return emitters_.size() == 1 && emitters_[0]->is_delta(); }

 private:
  void pick(const float* u, size_t count);
  void sample_picked(const SurfaceBlock& points);
  const std::vector<const Emitter*>& emitters_;
  float pick_pdf_;
  Arena arena_;
  DirectBlock light_;
  Columns2 u_;
  float* u_pick_;
  /// Emitter of each point, points sorted by emitter, and arguments and results of one emitter.
  uint32_t *pick_, *order_;
  BucketCounts next_;
  Columns3 part_p_;
  Columns2 part_u_;
  DirectBlock part_;
};

}  // namespace kinome::transport
