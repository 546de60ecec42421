#pragma once

#include <span>
#include <vector>

#include "clustered/media/lamp_guide.h"
#include "clustered/media/sources/fog_sources.h"
#include "clustered/media/sources/sun_points.h"
#include "kinome/phase.h"
#include "transport/blocks/arena.h"
#include "transport/media/paths/volume_paths.h"

namespace kinome {

/// Emitter samples for single points, on surfaces and in media. Sources are chosen in proportion to
/// the irradiance that they would cause without occlusion and attenuation. In media, that is the
/// irradiance on a plane that faces the source, times the phase function. Not thread-safe: use one
/// per thread.
class PointLightChoice final : public transport::LightChoice {
 public:
  /// `directions` may change between calls of sample(), and so may `points`, the light points;
  /// nullptr: none. `max_depth`: of paths.
  PointLightChoice(const FogSources& sources, const SkyDirections& directions,
                   const transport::MediaTable& media, const SunPoints* points, float max_depth,
                   size_t emitters);

  /// Sets the estimated visibility of each group of distant sources; 1 if the argument is empty. It
  /// must be independent of the random numbers of samples.
  void set_visibility(std::span<const float> visibility);

  bool has_scattered_light() const override { return sun_points_; }
  void sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
              const SurfaceBlock& points, uint32_t medium, const uint32_t* owner, size_t count,
              const Paths& paths, transport::Numbers& numbers, const DirectBlock& out,
              float* emitter_pdf) override;
  void redirect(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                const SurfaceBlock& points, uint32_t medium, const uint32_t* owner, size_t count,
                transport::Numbers& numbers, float* u1, const Columns2& u2,
                const BsdfAnswer& answer) override;
  LampGuide& guide() { return guide_; }

 private:
  struct Chosen {
    uint32_t source;  ///< from kFirstPoint on: light points
    float probability;
  };
  static constexpr uint32_t kFirstPoint = 1u << 31;
  static constexpr size_t kNoSet = SIZE_MAX;
  /// Columns of the HgTerms of a lobe of a phase function, for all sources.
  struct LobeColumns {
    float *base, *slope, *weight;
  };
  LobeColumns lobe_columns(const HgLobe& lobe);
  /// Chooses a source for the point p. `d` is the direction of the path at a point in a medium, and
  /// the normal on the path's side at a surface. `emitters`: choose among the sources; `set`: and
  /// among this set of light points, unless it is kNoSet.
  Chosen choose(const Vec3& p, const Vec3& d, uint32_t medium, float u, bool emitters, size_t set);
  size_t set_of(const PixelSamples& samples, uint32_t dimension, uint32_t medium,
                uint32_t owner) const;
  float share_of_paths(const Vec3& edge, float pdf) const;
  void add_emitters(const Vec3& p, const Vec3& d, uint32_t medium);
  void add_points(const Vec3& p, const Vec3& d, uint32_t medium, size_t set);

  const FogSources& sources_;
  const SkyDirections& directions_;
  const transport::MediaTable& media_;
  const SunPoints* const sun_points_;
  const float max_depth_, emitters_;
  LampGuide guide_;
  transport::Arena arena_;
  /// Columns of near sources, padded, then of distant ones.
  Columns3 place_;  ///< position, or direction
  float *intensity_, *radius2_;
  WeightedSources weight_;                       ///< weights at the current point
  std::vector<std::vector<LobeColumns>> lobes_;  ///< lobes of each medium
};

}  // namespace kinome
