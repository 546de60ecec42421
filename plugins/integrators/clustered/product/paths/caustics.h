#pragma once

#include <vector>

#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/tile_grid.h"
#include "kinome/film.h"
#include "kinome/sensor.h"

namespace kinome {

/// Caustics: light that mirrors and smooth glass send to surfaces that the camera sees. Paths from
/// the emitters find it. They are connected to the sensor at their ends (Veach 1997, 10.1), as in
/// `ptracer`.
/// - Light of lamps, after one mirror or nearly mirroring lobe (LocalLight::kBounceDepth). No ray
///   from the camera hits a lamp, and the mirror's lobe reflects no light point.
/// - Light of emitting surfaces and of the sky, after any number of delta lobes. EyeChains finds
///   the same light from the surface points that the camera sees. The balance heuristic of
///   approximate densities divides the light between the two. A beam keeps its area x cosine x
///   solid angle along a chain of delta lobes, except for a factor of the media's indices. So the
///   densities at both ends can be compared directly.
/// A guide, learned from earlier paths that don't contribute, leads paths to where they are seen.
/// Immutable; thread-safe.
class Caustics {
 public:
  /// From this number of edges on, chains of lossless mirrors end by roulette, even if rr_depth is
  /// larger.
  static constexpr uint32_t kMaxSureEdges = 64;
  /// True if surface points can be connected to the sensor.
  static bool serves(const Sensor& sensor);
  /// `hides_environment`: see goes_on_as_path.
  Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light,
           bool hides_environment, uint64_t seed, RenderCounters& counters);

  /// False if this class finds no light, so that no paths are needed.
  bool finds_any() const { return finds_extended_ || light_.has_lamp_caustics(); }
  /// Mean number of light rays and shadow rays per path.
  double rays_per_path() const { return rays_per_path_; }

  /// Returns the approximate density, per area x cosine x solid angle, at which EyeChains samples
  /// light that reaches x from direction d (unit, away from x), for one primary per pixel. x is
  /// visible to the camera. Depends on x and d alone. Infinity if only EyeChains finds the light.
  float eye_density(const SurfaceInteraction& x, const Vec3& d) const;
  /// Returns the same density for paths from the emitter. The light leaves x (nullptr: the sky)
  /// along d.
  float light_density(const Emitter& emitter, const SurfaceInteraction* x, const Vec3& d) const;
  /// Returns the balance weight of EyeChains for light that has these densities.
  static float share_of_eye(float eye_density, float light_density);

  /// Estimates the variance of each pixel of the grid (mean of the channels) after `count` paths.
  /// Traces `tried` paths for the estimate, and assumes a box filter.
  std::vector<float> variance(uint64_t seed, uint32_t tried, double count, const TileGrid& grid,
                              RenderCounters& counters) const;
  /// Traces `count` paths, splats their light onto `film` and adds their number to it.
  void trace(uint64_t seed, uint32_t count, FilmTile& film, RenderCounters& counters) const;

 private:
  struct Paths;
  /// Traces `count` paths in batches. Calls fn(paths) for each batch after its shadow rays.
  template <class Function>
  void trace_paths(uint64_t seed, uint32_t count, RenderCounters& counters,
                   const Function& fn) const;
  template <class Function>
  void for_each_splat(uint64_t seed, uint32_t count, RenderCounters& counters,
                      const Function& fn) const;
  void learn(uint64_t seed, RenderCounters& counters);
  bool is_worth_finding(uint64_t seed, RenderCounters& counters) const;
  void go_on(uint64_t seed, Paths& paths) const;
  void connect(uint64_t seed, Paths& paths) const;

  const Scene& scene_;
  const Sensor& sensor_;
  const LocalLight& light_;
  bool hides_environment_;
  const uint32_t paths_of_round_, paths_to_estimate_;
  bool finds_extended_;        ///< paths also start at sources that rays can hit
  std::vector<float> shares_;  ///< probability of each source without the guide
  std::vector<double> ends_;   ///< running sums of the guided probabilities of sources
  LightGuide guide_;
  double rays_per_path_ = 0;
  /// Expected number of paths of each source, over the whole image, for one primary per pixel. It
  /// is multiplied by the mean factor by which the guide raises the density of useful paths. Empty
  /// until learned.
  std::vector<float> rates_;
};

}  // namespace kinome
