#pragma once

#include <memory>
#include <optional>

#include "kinome/stats.h"
#include "kinome/wide/vectors.h"
#include "transport/direct/emitter_samples.h"
#include "transport/shadows/occlusion.h"
#include "transport/shadows/straight_shadows.h"
#include "transport/surfaces/shading.h"
#include "transport/surfaces/vertices.h"

namespace kinome::transport {

/// Number of samples of each technique at each point.
struct LightSamples {
  int emitter = 1;  ///< 0: BSDF samples find all light that they can
  int bsdf = 1;     ///< 0: emitter samples find all light that they can
  Lobe lobes = Lobe::kAll;  ///< lobes that are evaluated and sampled
};

/// Destinations of the light of emitter samples, by the number of surfaces that it passes straight
/// through.
struct RadianceByPasses {
  Columns3 radiance;    ///< light that passes up to `max_direct_passes` surfaces
  Columns3 beyond;      ///< all other light
  float max_direct_passes;  ///< may be negative
  uint32_t max_passes;  ///< more surfaces stop the light
};

/// Direct light at points of paths: emitter samples and BSDF samples, combined by the power
/// heuristic (Veach 1997, 9.2.4). No ray is traced for a contribution of zero. Reuses its memory
/// from block to block. Not thread-safe: use one per thread.
///
/// Call sample(), then add_emitter_samples(). For the BSDF samples, call add_environment() if the
/// environment is the only light that they can find; otherwise call trace(), which finds the
/// nearest surfaces. Light is added to the radiance of the samples that the points belong to, in
/// the column of its emitter's light group (SceneTable::group_offsets()).
class DirectLight {
 public:
  /// Number of sampler dimensions of an emitter sample or a BSDF sample.
  static constexpr uint32_t kDimensions = EmitterSamples::kDimensions;

  /// Allocates memory for the points of at most `rays` rays. `count` determines the samples'
  /// weights: sample() must be called that many times.
  DirectLight(const SceneTable& scene, const Sampler& sampler, const LightSamples& count,
              size_t rays);

  /// Draws one emitter sample and one BSDF sample. The arguments are the first dimension of each;
  /// nullopt skips the sample.
  void sample(const PixelSamples& samples, const Vertices& vertices,
              std::optional<uint32_t> emitter_dimension, std::optional<uint32_t> bsdf_dimension);
  /// Ends paths along BSDF samples by Russian roulette, and raises the weight of the survivors.
  void play_roulette(const PixelSamples& samples, const Vertices& vertices, uint32_t dimension);

  void add_emitter_samples(const Vertices& vertices, const Columns3& radiance,
                           RenderCounters& counters);
  /// The same for emitter samples that pass straight through surfaces (Lobe::kNull); the vertices
  /// must have origins. Samples of delta emitters stop at all surfaces, as in Mitsuba's `path`.
  void add_passing_emitter_samples(const Vertices& vertices, const RadianceByPasses& light,
                                   RenderCounters& counters);
  void add_environment(const Vertices& vertices, const Columns3& radiance,
                       RenderCounters& counters);
  void trace(const Vertices& vertices, Surfaces::Which which, const Columns3& radiance,
             RenderCounters& counters);

  /// met() returns the surfaces that trace() has hit; it stays valid during the next trace().
  /// from() returns, for each traced ray, the index of its starting point; it is valid until the
  /// next trace().
  const Surfaces& met() const { return traced_->met[current_]; }
  const uint32_t* from() const { return traced_->sort.order(); }
  /// Throughput along the BSDF sample of each point.
  const Columns3& carried() const { return carried_; }
  /// Vertices::origins of the point that each BSDF sample finds. Valid only if the vertices have
  /// origins.
  const Origins& next_origins() const { return passing_->next; }

 private:
  /// Sets the light and the rays of emitter samples, and returns the number of active rays.
  /// `weight_of(i, pdf)` returns the weights of samples i …, whose densities are `pdf`.
  template <class Fn>
  size_t make_emitter_rays(const Vertices& vertices, RenderCounters& counters, const Fn& weight_of);
  wide::Float emitter_pdf(size_t i) const;
  wide::Float emitter_weight(size_t i, const wide::Float& pdf, const wide::Float& passed) const;
  void find_next_origins(const Vertices& vertices);
  void make_bsdf_rays(const Vertices& vertices, RenderCounters& counters);
  void add_hit_emitters(const Vertices& vertices, const Columns3& radiance);
  void add_missed_environment(const Vertices& vertices, const Columns3& radiance);
  void find_directions(const Vertices& vertices);
  const uint32_t* emitter_destinations(const Vertices& vertices);
  void add_arriving(const uint32_t* destination, size_t count, bool are_neighbours,
                    const Columns3& radiance, RenderCounters& counters);
  float bsdf_weight(const Vertices& vertices, uint32_t point, float emitter_pdf) const;
  bool is_shown(const Vertices& vertices, size_t point) const;
  float shown_share(const Vertices& vertices, size_t point) const;
  void update_shown_shares(const Vertices& vertices) const;
  void update_straight(const Vertices& vertices) const;

  /// BSDF rays sorted by direction, and the surfaces that they hit.
  struct Traced {
    Traced(const SceneTable& scene, size_t max_points, size_t max_rays);
    DirectionSort sort;
    Arena per_ray;
    RayHit16* rays;
    /// Hits of the last call and of the one before, whose points may be the vertices of this one.
    Surfaces met[2];
  };

  /// State for emitter samples that pass straight through surfaces.
  struct Passing {
    Passing(const SceneTable& scene, size_t max_points, size_t max_rays);
    StraightShadows shadows;
    Arena per_point;
    Origins next;
    float* max_passes;
    NullTransmissionBlock through;  ///< null transmission at the vertices
  };

  const SceneTable& scene_;
  const Sampler& sampler_;
  LightSamples count_;
  size_t max_rays_;
  size_t max_points_;
  Numbers numbers_;
  Arena arena_;
  EmitterSamples emitters_;
  Occlusion occlusion_;
  Columns3 wo_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  Columns3 carried_;
  Columns3 light_;  ///< light that arrives if its ray is unoccluded
  uint32_t* destination_;  ///< see emitter_destinations()
  Ray16* rays_;
  Columns3 d_;                        ///< directions of BSDF samples, world space
  std::unique_ptr<Traced> traced_;    ///< nullptr until trace() is called
  std::unique_ptr<Passing> passing_;  ///< nullptr until vertices have origins
  int current_ = 0;
  Arena per_met_;
  Columns3 from_p_;
  Columns3 hit_radiance_;
  float* hit_pdf_;
};

}  // namespace kinome::transport
