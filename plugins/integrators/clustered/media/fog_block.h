#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "clustered/media/fog_light.h"
#include "clustered/media/point_light_choice.h"
#include "clustered/media/segment_distances.h"
#include "kinome/render_context.h"
#include "transport/camera/camera.h"
#include "transport/camera/film_samples.h"
#include "transport/media/paths/volume_paths.h"

namespace kinome {

/// Renders blocks of camera rays through uniform media. A camera ray is split: one path continues
/// from the first surface, with its transmittance as weight, and another one from a random
/// collision before the surface. FogLight finds the light that is scattered once before the
/// surface, so that the second path gets no emitter samples at its collision. Not thread-safe: use
/// one per thread.
///
/// `paths` is the relative number of paths that continue after the first points, at most 1. Fewer
/// paths are useful if light that is scattered once dominates the noise.
class FogBlock : private transport::VolumePaths::EdgeTracer {
 public:
  FogBlock(const transport::SceneTable& scene, const transport::MediaTable& media,
           const FogSources& sources, const Sensor& sensor, const PathSettings& settings,
           float paths);

  void render(const PixelSamples& samples, Tile& tile);
  /// Sets radiance() without changing a film.
  void trace(const PixelSamples& samples, RenderCounters& counters);
  const Columns3& radiance() const { return radiance_; }

 private:
  void trace(const PixelSamples& samples, const transport::VolumePaths::FirstEdges& edges,
             size_t count, uint32_t dimension, const Columns3& radiance,
             RenderCounters& counters) override;
  void sum_scattered();
  void set_alpha(const transport::VolumePaths::FirstEdges& first, size_t count);
  size_t add_collisions(const PixelSamples& samples,
                        const transport::VolumePaths::FirstEdges& first);
  void add_collision(const transport::VolumePaths::FirstEdges& first, size_t path, size_t k,
                     float at, float u);
  std::pair<float, float> choose_distance(const transport::MediumLeg& leg,
                                          const AttenuatedDistances& distances, float u, float v);

  const transport::SceneTable& scene_;
  const transport::MediaTable& media_;
  const Sampler& sampler_;
  /// True if paths continue from collisions. Otherwise FogLight finds all light.
  const bool needs_collisions_;
  const bool sees_sky_;
  const float share_;  ///< see FogLight
  const float relative_paths_;
  /// True if FogLight finds the light of all collisions, not only on camera rays. For distant
  /// emitters, emitter samples at collisions are faster.
  const bool finds_later_;
  const float max_depth_;
  transport::Camera camera_;
  transport::Segments segments_;
  const FogSources& sources_;
  SkyDirections directions_;
  std::unique_ptr<SunPoints> sun_points_;  ///< nullptr: none
  PointLightChoice light_choice_;
  transport::VolumePaths paths_;
  FogLight fog_;
  transport::FilmSamples film_;
  transport::Numbers numbers_;
  transport::Arena arena_;
  transport::Arena per_path_;
  Columns3 radiance_;
  float *alpha_, *u_, *u_distance_;
  float* before_;         ///< sum of the channels of a path's throughput before its edge
  float *total_, *left_;  ///< leg weights of a sample; see add_collisions()
  float* reference_;      ///< argument of VolumePaths::trace_from(), for each sample
  std::vector<float*> values_;
  std::vector<transport::MediumLeg> legs_, lit_legs_;
  std::vector<Rgb> scattered_;  ///< scattered throughput of each leg; see add_collisions()
};

}  // namespace kinome
