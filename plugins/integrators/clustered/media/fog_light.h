#pragma once

#include <span>
#include <vector>

#include "clustered/media/fog_table.h"
#include "transport/blocks/numbers.h"
#include "transport/media/tracking/medium_shadows.h"

namespace kinome {

/// Light that media scatter once, along camera rays: the integral over each ray's parts in media of
/// transmittance x scattering x phase function x radiance. Each part gets candidates, which are
/// pairs of a distance and a source, chosen by FogTable. A shadow ray finds the visibility of each.
/// Not thread-safe: use one per thread.
class FogLight {
 public:
  /// Number of sampler dimensions of each candidate.
  static constexpr uint32_t kDimensions = 4;
  /// Recommended `share`.
  static constexpr float kShare = 8;

  /// Allocates memory for blocks of at most `rays` camera rays. Samples of a phase function
  /// (density p) and of an emitter (density q) find the same light of emitters with area. Their
  /// weights are those of the power heuristic for the densities p and `share` q. If `share` is
  /// infinite, candidates find all light. `directions` may change between calls of add().
  FogLight(const transport::SceneTable& scene, const transport::MediaTable& media,
           const FogSources& sources, const SkyDirections& directions, const Sampler& sampler,
           float share, size_t rays);

  /// Adds the light of `legs` to the radiance of their samples. Some of the samples are used for
  /// learning. Their random numbers are independent of the sampler's, so that no estimate depends
  /// on the random numbers with which its importances were learned.
  void add(const PixelSamples& samples, std::span<const transport::MediumLeg> legs,
           uint32_t dimension, uint32_t candidates, const Columns3& radiance,
           RenderCounters& counters);
  /// Adds the light of legs of paths, without learning. Importances of near sources are those of
  /// point lights without attenuation. `owner` is the sample of each path.
  void add_later(const PixelSamples& samples, std::span<const transport::MediumLeg> legs,
                 const uint32_t* owner, uint32_t dimension, const Columns3& radiance,
                 RenderCounters& counters);
  /// FogTable::visibility() after the last add(); empty if nothing was learned.
  std::span<const float> visibility() const { return visibility_; }

 private:
  enum class Numbers { kSampler, kOwn };
  void list_lit(std::span<const transport::MediumLeg> legs, uint32_t step);
  void render(const PixelSamples& samples, std::span<const uint32_t> legs, uint32_t dimension,
              Numbers numbers, const Columns3& radiance, RenderCounters& counters);
  void make_numbers(const PixelSamples& samples, size_t count, uint32_t dimension, Numbers numbers);
  void make_candidate(size_t i, const transport::MediumLeg& leg);

  const transport::MediaTable& media_;
  const FogSources& sources_;
  const SkyDirections& directions_;
  const Sampler& sampler_;
  const float share_;
  FogTable table_, later_table_;
  FogTable* current_ = &table_;
  const uint32_t* owners_ = nullptr;  ///< samples of the paths; nullptr: paths are samples
  transport::Numbers numbers_;
  transport::MediumShadows shadows_;
  std::span<const transport::MediumLeg> legs_;
  std::span<const float> visibility_;
  float reference_ = 1;                 ///< mean expected light of camera rays
  float weight_ = 1;                    ///< weight of each candidate
  std::vector<uint32_t> pilot_, rest_;  ///< indices into legs_
  std::vector<FogTable::Choice> choices_;
  transport::Arena arena_;
  SurfaceBlock points_;  ///< only p, n and p_error are set
  Columns3 d_, light_;
  float *distance_, *on_, *u_source_, *u_distance_;
  Columns2 u_;
  uint32_t *owner_, *medium_;
  Ray16* rays_;
};

}  // namespace kinome
