#pragma once

#include <vector>

#include "numbers.h"
#include "surfaces.h"

namespace kinome::transport {

/// Makes samples of `emitter`, of a surface, into none where they are for points of the same
/// surface and are but rounding: see SurfaceInteraction::resolves. Sample which[i] is for that
/// point.
void leave_out_own_rounding(const Emitter& emitter, const SurfaceBlock& points,
                            const uint32_t* which, size_t count, const DirectBlock& samples);

/// Samples of the scene's emitters, one for each point of a block, of emitters picked uniformly.
/// One per thread.
class EmitterSamples {
 public:
  /// Dimensions of the sampler: which emitter, and where on it.
  static constexpr uint32_t kDimensions = 3;

  EmitterSamples(const SceneTable& scene, size_t points);

  /// For points[0 … count - 1] of the samples `owner`, count being a multiple of 16. The scene must
  /// have emitters.
  void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
              const SurfaceBlock& points, const uint32_t* owner, size_t count, Numbers& numbers);
  /// The density doesn't count the pick, see pick_pdf(). is_delta is set of all emitters that no
  /// ray meets, whether or not they are deltas.
  const DirectBlock& light() const { return light_; }
  float pick_pdf() const { return pick_pdf_; }
  /// One emitter lights all points, each from one direction.
  bool come_from_one_place() const { return emitters_.size() == 1 && emitters_[0]->is_delta(); }

 private:
  void pick(const float* which, size_t count);
  void sample_picked(const SurfaceBlock& points);
  const std::vector<const Emitter*>& emitters_;
  float pick_pdf_;
  Arena arena_;
  DirectBlock light_;
  Columns2 u_;
  float* which_;
  /// Points by their emitter, and what that emitter is asked for them.
  uint32_t *pick_, *order_;
  BucketCounts next_;
  Columns3 part_p_;
  Columns2 part_u_;
  DirectBlock part_;
};

}  // namespace kinome::transport
