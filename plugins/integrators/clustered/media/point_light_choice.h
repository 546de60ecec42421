#pragma once

#include <span>
#include <vector>

#include "clustered/media/fog_sources.h"
#include "kinome/phase.h"
#include "transport/arena.h"
#include "transport/media/volume_paths.h"

namespace kinome {

/// Emitter samples for single points, on surfaces and in media. Sources are chosen by the
/// irradiance that they would cause without occlusion and attenuation; in media, by that on a plane
/// that faces them, times the phase function. One per thread.
class PointLightChoice final : public transport::LightChoice {
 public:
  /// `directions` may change between calls of sample().
  PointLightChoice(const FogSources& sources, const SkyDirections& directions,
                   const transport::MediaTable& media);

  /// Sets the estimated visibility of each group of distant sources; 1 if the argument is empty. It
  /// must be independent of the random numbers of samples.
  void set_visibility(std::span<const float> visibility);

  void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
              const SurfaceBlock& points, uint32_t medium, const uint32_t* owner, size_t count,
              transport::Numbers& numbers, const DirectBlock& out, float* emitter_pdf) override;

 private:
  struct Chosen {
    uint32_t source;
    float probability;
  };
  /// Columns of a lobe of a phase function, for all sources: the phase function for light that is
  /// deflected by an angle of cosine c is weight / (base - slope c)^1.5.
  struct LobeColumns {
    float *base, *slope, *weight;
  };
  LobeColumns lobe_columns(const HgLobe& lobe);
  /// `d`: direction of the path at a point in a medium, else the normal on the path's side.
  Chosen choose(const Vec3& p, const Vec3& d, uint32_t medium, float u) const;

  const FogSources& sources_;
  const SkyDirections& directions_;
  transport::Arena arena_;
  /// Columns of near sources, padded, then of distant ones.
  Columns3 place_;  ///< position, or direction
  float *intensity_, *radius2_;
  float* weight_;                                ///< of the sources for the current point
  std::vector<std::vector<LobeColumns>> lobes_;  ///< of each medium
};

}  // namespace kinome
