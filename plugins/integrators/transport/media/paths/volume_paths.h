#pragma once

#include "transport/direct/emitter_samples.h"
#include "transport/media/paths/walks.h"
#include "transport/media/tracking/medium_shadows.h"
#include "transport/media/tracking/segments.h"
#include "transport/path_parameters.h"
#include "transport/surfaces/shading.h"

namespace kinome::transport {

/// Draws an emitter sample for each point of a block, in place of EmitterSamples. Not thread-safe:
/// use one per thread.
class LightChoice {
 public:
  /// Factor of the densities of emitter samples in media, in the weights against samples of phase
  /// functions. It favours emitter samples, because a choice that includes the phase function is
  /// the better technique of the two.
  static constexpr float kMediumShare = 8;

  /// Paths that reach the points of sample(): columns.
  struct Paths {
    /// Points where the paths were scattered before.
    Columns3 from;
    /// Density of the paths' directions, per solid angle, relative to the factor of the densities
    /// of emitter samples in weights and to the number of emitters. Infinite if emitter samples at
    /// `from` don't find the same light as the paths behind it.
    const float* pdf;
    const float* scatterings;  ///< number of points before
    /// False if the caller of VolumePaths::trace_from() finds the light of emitters.
    bool needs_emitters;
  };

  virtual ~LightChoice() = default;
  /// True if samples also find light that is scattered once more before it reaches the points.
  virtual bool has_scattered_light() const { return false; }
  /// Samples an emitter for each point. Sampler dimensions and arguments are those of
  /// EmitterSamples::sample(). All points are on surfaces (MediaTable::kVacuum) or in the same
  /// medium. Densities of `out` include the probability of the emitter. Sets `emitter_pdf` to the
  /// densities with which the emitter alone samples the same directions, per solid angle, for
  /// weights.
  virtual void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                      const SurfaceBlock& points, uint32_t medium, const uint32_t* owner,
                      size_t count, const Paths& paths, Numbers& numbers, const DirectBlock& out,
                      float* emitter_pdf) = 0;
  /// Replaces sampled directions (`wo` and `weight` of the answer) at points in a medium, and sets
  /// `sample_pdf` to the phase function. Called for points whose emitter samples the caller of
  /// VolumePaths::trace_from() draws. `dimension` is one unused dimension of the sampler. `u1` is
  /// scratch memory; `u2` contains the random numbers of the sampled directions.
  virtual void redirect(const Sampler& /*sampler*/, const PixelSamples& /*samples*/,
                        uint32_t /*dimension*/, const SurfaceBlock& /*points*/, uint32_t /*medium*/,
                        const uint32_t* /*owner*/, size_t /*count*/, Numbers& /*numbers*/,
                        float* /*u1*/, const Columns2& /*u2*/, const BsdfAnswer& /*answer*/) {}
};

/// Paths from the camera through media. Each point where light is scattered, in a medium or on a
/// surface, gets direct light from an emitter sample and a sample of its phase function or BSDF,
/// combined by the power heuristic (Veach 1997, 9.2.4). The weights don't include transmittances,
/// so that they add up to 1 even if transmittances are estimated. The second sample is also the
/// next edge. The paths of a block advance together; after each step, the remaining paths are
/// compacted. Not thread-safe: use one per thread.
///
/// As in Mitsuba's `volpath`, surfaces that light passes straight through don't count as points of
/// the path, and they don't stop emitter samples of any emitter.
class VolumePaths {
 public:
  /// Allocates memory for blocks of at most `rays` paths. Draws emitter samples by `choice`, or by
  /// EmitterSamples if it is nullptr; light groups require nullptr.
  VolumePaths(const SceneTable& scene, const MediaTable& media, const Sampler& sampler,
              const PathSettings& settings, size_t rays, LightChoice* choice = nullptr);

  /// Traces a path along each camera ray. Adds its light to `radiance`. Sets `alpha` to 1 if the
  /// ray sees an environment that isn't hidden, or is scattered or absorbed; else to 0.
  void trace(const PixelSamples& samples, const RayHit16* camera_rays, const Columns3& radiance,
             float* alpha, RenderCounters& counters);

  /// Paths along camera rays, up to the first points where they are scattered.
  struct FirstEdges {
    RayHit16* rays;  ///< traced rays, which hit a surface, a collision (SceneTable), or nothing
    uint32_t* owner;
    uint32_t* medium;  ///< medium before the ray's end
    Columns3 throughput;
    float* scatterings;
  };
  /// Traces edges of paths: sets the rays' hits, media and throughputs, and adds the light that is
  /// scattered once on the way. Not thread-safe: use one per thread.
  class EdgeTracer {
   public:
    virtual ~EdgeTracer() = default;
    virtual void trace(const PixelSamples& samples, const FirstEdges& edges, size_t count,
                       uint32_t dimension, const Columns3& radiance, RenderCounters& counters) = 0;
  };
  /// Sets a factor of survival probabilities in trace_from(): the ratio of a path's probability of
  /// surviving roulette to its share of the throughput of all paths of its sample.
  void set_survival_gain(float gain) { survival_gain_ = gain; }
  static constexpr float kSurvivalGain = 3;  ///< default
  /// Begins one path for each sample, along the camera rays, which are not traced yet. The result
  /// is valid until trace_from().
  FirstEdges begin(const PixelSamples& samples, const RayHit16* camera_rays);
  /// Continues `count` paths from the ends of their first edges. Paths with equal owners belong to
  /// the same sample. First points in media whose MediaTable::emitter_weight() is 1 get no emitter
  /// samples, because the caller finds that light, with a density of `share` times that of emitter
  /// samples. `dimension` is the first sampler dimension to use. `reference` has, for each sample
  /// of the block, the mean throughput after all points in media at which its camera ray is
  /// scattered; this function adds that of its surface. Roulette keeps paths in proportion to their
  /// throughput, relative to the reference; see survival(). If `later` isn't nullptr, it traces all
  /// later edges, and their collisions get no emitter samples, either.
  void trace_from(const PixelSamples& samples, size_t count, float share, uint32_t dimension,
                  float* reference, const Columns3& radiance, RenderCounters& counters,
                  EdgeTracer* later = nullptr);

 private:
  /// Numbers of sampler dimensions for a step: the distance and its channel, an emitter sample, a
  /// BSDF sample, the roulette.
  static constexpr uint32_t kEdgeDimensions = 2;
  static constexpr uint32_t kBsdfDimensions = 3;
  static constexpr uint32_t kStepDimensions =
      kEdgeDimensions + EmitterSamples::kDimensions + kBsdfDimensions + 1;

  /// State of paths, at the points that they reach or along the rays to the next points.
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
    /// sensor. Refraction divides the throughput of radiance by it; roulette must not depend on
    /// this factor.
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
  const uint32_t* emitter_destinations(size_t count);
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
  size_t count_ = 0;  ///< number of rays
  State along_;       ///< state along rays_
  float *u_, *optical_depth_;
  uint32_t* channel_;
  float* missed_pdf_;
  Columns3 missed_d_, missed_light_;

  Arena per_point_;
  State at_;  ///< state at the points of met_
  /// Weight of emitter samples at each point, as MediaTable::emitter_weight(); 1 for surfaces.
  float* emitter_weight_;
  /// Factor of the density of BSDF samples in weights; 0 if BSDF samples find all light.
  float* pdf_factor_;
  float* relative_index2_;  ///< squared relative index of each point's surface
  float* max_survival_;     ///< maximum probability of surviving Russian roulette at each point
  /// Argument `share` of trace_from() in its first step; 0 in later steps.
  float first_share_ = 0;
  EdgeTracer* later_ = nullptr;  ///< argument of trace_from()
  float* reference_ = nullptr;   ///< argument of trace_from()
  float survival_gain_ = kSurvivalGain;
  Columns3 wo_, d_, light_, carried_;
  float *u1_, *pdf_, *distance_;
  Columns2 u2_;
  uint32_t* medium_;
  uint32_t* destination_;  ///< see emitter_destinations()
  BsdfAnswer answer_;
  /// Emitter samples, whose densities include the probability of the emitter, and densities for
  /// weights.
  DirectBlock sampled_;
  float* weight_pdf_;
  Ray16* shadow_rays_;
};

}  // namespace kinome::transport
