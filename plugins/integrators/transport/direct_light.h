#pragma once

#include <memory>
#include <optional>

#include "emitter_samples.h"
#include "kinome/stats.h"
#include "kinome/wide/vectors.h"
#include "occlusion.h"
#include "shading.h"
#include "straight_shadows.h"
#include "vertices.h"

namespace kinome::transport {

/// How often light is looked for at each point.
struct LightSamples {
  int emitter = 1;  ///< 0: BSDF samples find all light that they can
  int bsdf = 1;     ///< 0: emitter samples find all light that they can
};

/// Where the light of emitter samples goes, by the number of surfaces that it passes straight.
struct RadianceByPasses {
  Columns3 radiance;    ///< of light that passes up to `few_passes` surfaces
  Columns3 beyond;      ///< of all other light
  float few_passes;     ///< may be negative
  uint32_t max_passes;  ///< more surfaces stop the light
};

/// Light that comes straight from emitters to points of paths: emitter samples and BSDF samples,
/// combined by the power heuristic (Veach 1997, 9.2.4). No ray is traced for a contribution of
/// zero. Keeps its memory from block to block: make one per thread.
///
/// sample(), then add_emitter_samples(), and for the BSDF samples add_environment() where no other
/// light can be met, or trace(), which finds the nearest surfaces. Light is added to the radiance
/// of the samples that the points belong to.
class DirectLight {
 public:
  /// Dimensions of the sampler for an emitter sample or a BSDF sample.
  static constexpr uint32_t kDimensions = EmitterSamples::kDimensions;

  /// For points of at most `rays` rays. `count` sets the samples' weights: sample() is to be called
  /// that often.
  DirectLight(const SceneTable& scene, const Sampler& sampler, const LightSamples& count,
              size_t rays);

  /// One sample of emitters and one of BSDFs, or but one of the two: the first dimension of each.
  void sample(const PixelSamples& samples, const Vertices& vertices,
              std::optional<uint32_t> emitter_dimension, std::optional<uint32_t> bsdf_dimension);
  /// Ends paths along BSDF samples by Russian roulette, and raises the weight of the others.
  void play_roulette(const PixelSamples& samples, const Vertices& vertices, uint32_t dimension);

  void add_emitter_samples(const Vertices& vertices, const Columns3& radiance,
                           RenderCounters& counters);
  /// The same for emitter samples that pass surfaces straight (Lobe::kNull); the vertices must have
  /// origins. Samples of delta emitters stop at all surfaces, as in Mitsuba's `path`.
  void add_passing_emitter_samples(const Vertices& vertices, const RadianceByPasses& light,
                                   RenderCounters& counters);
  void add_environment(const Vertices& vertices, const Columns3& radiance,
                       RenderCounters& counters);
  void trace(const Vertices& vertices, Surfaces::Which which, const Columns3& radiance,
             RenderCounters& counters);

  /// What trace() has met, and of each of its rays the point that it comes from. met() stays valid
  /// through the next trace(), from() only until it.
  const Surfaces& met() const { return traced_->met[current_]; }
  const uint32_t* from() const { return traced_->sort.order(); }
  /// Of points: the throughput along the BSDF sample.
  const Columns3& carried() const { return carried_; }
  /// Of points: Vertices::origins of what the BSDF sample finds. Only if the vertices have origins.
  const Origins& next_origins() const { return passing_->next; }

 private:
  /// Throughput, density and rays of emitter samples; returns the number of rays that are on.
  /// `weight_of` returns the weight of samples i … that have the density pdf.
  template <class Fn>
  size_t make_emitter_rays(const Vertices& vertices, RenderCounters& counters, const Fn& weight_of);
  wide::Float emitter_pdf(size_t i) const;
  wide::Float emitter_weight(size_t i, const wide::Float& pdf, const wide::Float& passed) const;
  void find_next_origins(const Vertices& vertices);
  void make_bsdf_rays(const Vertices& vertices, RenderCounters& counters);
  void add_met_surfaces(const Vertices& vertices, const Columns3& radiance);
  void add_met_environment(const Vertices& vertices, const Columns3& radiance);
  void find_directions(const Vertices& vertices);
  void add_arriving(const Vertices& vertices, size_t count, bool are_neighbours,
                    const Columns3& radiance, RenderCounters& counters);
  float bsdf_weight(const Vertices& vertices, uint32_t point, float emitter_pdf) const;
  bool is_shown(const Vertices& vertices, size_t point) const;
  float shown_share(const Vertices& vertices, size_t point) const;
  void update_shown_shares(const Vertices& vertices) const;
  void update_straight(const Vertices& vertices) const;

  /// BSDF rays in the order of their directions, and what they meet.
  struct Traced {
    Traced(const SceneTable& scene, size_t most_points, size_t most_rays);
    DirectionSort sort;
    Arena per_ray;
    RayHit16* rays;
    /// Of the last call and of the one before, whose points may be the vertices of this one.
    Surfaces met[2];
  };

  /// State for emitter samples that pass surfaces straight.
  struct Passing {
    Passing(const SceneTable& scene, size_t most_points, size_t most_rays);
    StraightShadows shadows;
    Arena per_point;
    Origins next;
    float* max_passes;
    NullTransmissionBlock through;  ///< of the vertices
  };

  const SceneTable& scene_;
  const Sampler& sampler_;
  LightSamples count_;
  size_t most_rays_;
  size_t most_points_;
  Numbers numbers_;
  Arena arena_;
  EmitterSamples emitters_;
  Occlusion occlusion_;
  Columns3 wo_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  Columns3 carried_;
  Columns3 light_;  ///< that arrives if nothing is in its ray's way
  Ray16* rays_;
  Columns3 d_;                      ///< of BSDF samples, in world space
  std::unique_ptr<Traced> traced_;  ///< nullptr until trace() is called, which some never do
  std::unique_ptr<Passing> passing_;  ///< nullptr until vertices have origins
  int current_ = 0;
  Arena per_met_;
  Columns3 from_p_;
  Columns3 met_light_;
  float* met_pdf_;
};

}  // namespace kinome::transport
