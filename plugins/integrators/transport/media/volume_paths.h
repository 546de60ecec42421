#pragma once

#include "../emitter_samples.h"
#include "../path_parameters.h"
#include "../shading.h"
#include "medium_shadows.h"
#include "segments.h"
#include "walks.h"

namespace kinome::transport {

/// Chooses an emitter sample for each point of a block, in place of EmitterSamples. One per thread.
class LightChoice {
 public:
  /// Factor of the densities of emitter samples in media in weights against those of phase
  /// functions. A choice that knows the phase function is the better one of the two.
  static constexpr float kMediumShare = 8;

  virtual ~LightChoice() = default;
  /// Dimensions of the sampler, and arguments: as for EmitterSamples::sample(). All points are on
  /// surfaces (MediaTable::kVacuum) or in the same medium. Densities of `out` include the
  /// probability of the emitter. `emitter_pdf`: densities of the emitter's own samples of the same
  /// directions, per solid angle, for weights.
  virtual void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                      const SurfaceBlock& points, uint32_t medium, const uint32_t* owner,
                      size_t count, Numbers& numbers, const DirectBlock& out,
                      float* emitter_pdf) = 0;
};

/// Paths from the camera through media. Each point where light is scattered, in a medium or on a
/// surface, gets direct light from an emitter sample and a sample of its phase function or BSDF,
/// combined by the power heuristic (Veach 1997, 9.2.4). The weights don't include transmittances,
/// so that they add up to 1 even if transmittances are estimated. The second sample is also the
/// next edge. The paths of a block advance together; after each step, the remaining paths are
/// compacted. One per thread.
///
/// As in Mitsuba's `volpath`, surfaces that light passes straight don't count as points of the
/// path, and emitter samples of all emitters see through them.
class VolumePaths {
 public:
  /// For blocks of at most `rays` paths. `choice`: nullptr for EmitterSamples.
  VolumePaths(const SceneTable& scene, const MediaTable& media, const Sampler& sampler,
              const PathSettings& settings, size_t rays, LightChoice* choice = nullptr);

  /// Traces a path along each camera ray. Adds its light to `radiance`. Sets `alpha` to 1 if the
  /// ray sees an environment that isn't hidden, or is scattered or absorbed; else to 0.
  void trace(const PixelSamples& samples, const RayHit16* camera_rays, const Columns3& radiance,
             float* alpha, RenderCounters& counters);

  /// Paths along camera rays, up to the first points where they are scattered.
  struct FirstEdges {
    RayHit16* rays;  ///< traced: surfaces, collisions (SceneTable), or nothing
    uint32_t* owner;
    uint32_t* medium;  ///< before the end
    Columns3 throughput;
    float* scatterings;
  };
  /// Traces edges of paths: sets the rays' hits, media and throughputs, and adds the light that is
  /// scattered once on the way. One per thread.
  class EdgeTracer {
   public:
    virtual ~EdgeTracer() = default;
    virtual void trace(const PixelSamples& samples, const FirstEdges& edges, size_t count,
                       uint32_t dimension, const Columns3& radiance, RenderCounters& counters) = 0;
  };
  /// Sets the rays to the camera rays, which are not traced yet, one path for each sample. The
  /// result is valid until trace_from().
  FirstEdges begin(const PixelSamples& samples, const RayHit16* camera_rays);
  /// Continues `count` paths from the ends of their first edges, several paths for a sample where
  /// owners are equal. The first points in media whose MediaTable::emitter_weight() is 1 get no
  /// emitter samples, because the caller finds that light with a density of `share` times that of
  /// emitter samples. `dimension`: first dimension of the sampler that is used.
  /// `reference`: for each sample of the block, the mean throughput behind all points in media
  /// where its camera ray is scattered; that of its surface is added here. Roulette keeps paths in
  /// proportion to their throughput, relative to this one: see survival().
  /// `later`: traces all later edges; their collisions get no emitter samples, either. nullptr:
  /// only the first edges are the caller's.
  void trace_from(const PixelSamples& samples, size_t count, float share, uint32_t dimension,
                  float* reference, const Columns3& radiance, RenderCounters& counters,
                  EdgeTracer* later = nullptr);

 private:
  /// Dimensions of the sampler for a step: the distance and its channel, an emitter sample, a BSDF
  /// sample, the roulette.
  static constexpr uint32_t kEdgeDimensions = 2;
  static constexpr uint32_t kBsdfDimensions = 3;
  static constexpr uint32_t kStepDimensions =
      kEdgeDimensions + EmitterSamples::kDimensions + kBsdfDimensions + 1;

  /// Paths: at the points that they reach, or along the rays to the next points.
  struct State {
    uint32_t* owner;  ///< sample of the block
    uint32_t* medium;
    Columns3 throughput;
    float* scatterings;
    /// Last point where the path was scattered, and the density of its direction there, per solid
    /// angle. The density is infinite if emitter samples don't find the same light.
    Columns3 from;
    float* pdf;
    /// Square of the index of refraction of the medium at the point, relative to that at the
    /// sensor. The throughput is that of radiance, which refraction divides by it; roulette must
    /// not depend on this.
    float* index2;
  };
  static State make_state(Arena& arena);

  void trace_on(const PixelSamples& samples, uint32_t dimension, const Columns3& radiance,
                float* alpha, RenderCounters& counters);
  void trace_edges(const PixelSamples& samples, uint32_t dimension, RayKind kind,
                   RenderCounters& counters);
  void walk(const RandomSeeds& seeds, float* alpha, RenderCounters& counters);
  void sample_distances(const PixelSamples& samples, uint32_t dimension);
  void find_points();
  void add_emission(const Columns3& radiance);
  void add_environment(const Columns3& radiance);
  void sample(const PixelSamples& samples, uint32_t dimension);
  void add_emitter_samples(const RandomSeeds& seeds, const Columns3& radiance,
                           RenderCounters& counters);
  void sample_emitters(const PixelSamples& samples, uint32_t dimension, size_t count);
  const DirectBlock& light() const { return choice_ ? sampled_ : emitters_.light(); }
  bool is_found_elsewhere(const Surfaces::Range& range) const;
  uint32_t medium_of(const Surfaces::Range& range) const;
  void find_media(size_t count, const Columns3& d, uint32_t* medium) const;
  wide::Float index2_factor(size_t i) const;
  void add_to_reference();
  wide::Float survival(size_t i, const wide::Rgb& carried, wide::Float weight,
                       wide::Mask is_late) const;
  void scatter(const PixelSamples& samples, uint32_t dimension, uint32_t steps, float* alpha);
  void set_alpha(float* alpha) const;
  void sort_rays();

  const SceneTable& scene_;
  const MediaTable& media_;
  const Sampler& sampler_;
  const PathLength length_;
  const bool hides_emitters_;
  Numbers numbers_;
  Segments segments_;
  Walks walks_;
  MediumShadows shadows_;
  Surfaces met_;
  EmitterSamples emitters_;
  LightChoice* const choice_;
  DirectionSort sort_;

  Arena per_ray_;
  RayHit16* rays_;
  size_t count_ = 0;  ///< of rays
  State along_;       ///< paths of the rays
  float *u_, *optical_depth_;
  uint32_t* channel_;
  float* missed_pdf_;
  Columns3 missed_d_, missed_light_;

  Arena per_point_;
  State at_;  ///< paths of the points of met_
  /// Weight of emitter samples at each point, as MediaTable::emitter_weight(); 1 for surfaces.
  float* emitter_weight_;
  /// Factor of the density of BSDF samples in weights; 0 if they find all light.
  float* pdf_factor_;
  float* relative_index2_;  ///< squared relative index of each point's surface
  float* max_survival_;     ///< maximum probability of surviving Russian roulette at each point
  /// In the first step of trace_from(), its argument `share`; else 0.
  float first_share_ = 0;
  EdgeTracer* later_ = nullptr;  ///< argument of trace_from()
  float* reference_ = nullptr;   ///< argument of trace_from()
  Columns3 wo_, d_, light_, carried_;
  float *u1_, *pdf_, *distance_;
  Columns2 u2_;
  uint32_t* medium_;
  BsdfAnswer answer_;
  /// Emitter samples, with the probability of the emitter in their densities, and densities for
  /// weights.
  DirectBlock sampled_;
  float* weight_pdf_;
  Ray16* shadow_rays_;
};

}  // namespace kinome::transport
