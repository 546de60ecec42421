#pragma once

#include <vector>

#include "clustered/product/local_light.h"
#include "clustered/product/tile_grid.h"
#include "kinome/film.h"
#include "kinome/sensor.h"

namespace kinome {

/// Light that emitters send to mirrors, and these to what the camera sees, found by paths from the
/// emitters, which are connected to the sensor where they end (Veach 1997, 10.1; as `ptracer`):
/// - of lamps without extent, by one mirror or what nearly is one (LocalLight::kBounceDepth). No
/// ray
///   from the camera meets the lamp, and the mirror's lobe shows no light point.
/// - of surfaces that emit, and of the sky, by any number of delta lobes, those of smooth glass
///   included. Rays from the camera's surface point find the same (EyeChains). Each has a share, by
///   the balance heuristic of their approximate densities. Along a chain of delta lobes a beam
///   keeps its area x cosine x solid angle (but for a factor of the media's indices), so that the
///   densities at both ends can be compared as they are.
/// Paths are guided to where earlier ones, which count for nothing else, came to be seen.
/// Immutable; thread-safe.
class Caustics {
 public:
  /// Chains of mirrors that lose nothing end by roulette from so many edges on, whatever is asked.
  static constexpr uint32_t kMostSureEdges = 64;
  /// Whether surface points can be connected to the sensor.
  static bool serves(const Sensor& sensor);
  /// `hides_environment`: see goes_on_as_path.
  Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light,
           bool hides_environment, uint64_t seed, RenderCounters& counters);

  /// False where all light is left to others.
  bool finds_any() const { return finds_extended_ || light_.has_lamp_caustics(); }
  /// Of all kinds, on average.
  double rays_per_path() const { return rays_per_path_; }

  /// How densely EyeChains look for light that comes to x, which a ray from the camera meets, along
  /// -d (unit, away from x): approximately, per area x cosine x solid angle, for one primary of
  /// each pixel. A function of x and d alone. Infinite where only EyeChains can find the light.
  float eye_density(const SurfaceInteraction& x, const Vec3& d) const;
  /// The same of paths from the emitter; x: where the light leaves along d (nullptr: the sky).
  float light_density(const Emitter& emitter, const SurfaceInteraction* x, const Vec3& d) const;
  /// Of light that has these densities, what EyeChains are to count.
  static float share_of_eye(float eye_density, float light_density);

  /// Estimate of each pixel's variance (mean of the channels) after `count` paths, from `tried`
  /// paths of its own. By the grid's pixels, whose filter is taken to be a box.
  std::vector<float> variance(uint64_t seed, uint32_t tried, double count, const TileGrid& grid,
                              RenderCounters& counters) const;
  /// So many paths, whose light, and number, `film` is told.
  void trace(uint64_t seed, uint32_t count, FilmTile& film, RenderCounters& counters) const;

 private:
  struct Paths;
  /// fn(paths) for so many paths, some at a time, when their splats and shadow rays are traced.
  template <class Function>
  void trace_paths(uint64_t seed, uint32_t count, RenderCounters& counters,
                   const Function& fn) const;
  template <class Function>
  void for_each_splat(uint64_t seed, uint32_t count, RenderCounters& counters,
                      const Function& fn) const;
  uint32_t paths_of_round() const;
  uint32_t paths_to_tell() const;
  void learn(uint64_t seed, RenderCounters& counters);
  bool is_worth_finding(uint64_t seed, RenderCounters& counters) const;
  void go_on(uint64_t seed, Paths& paths) const;
  void connect(uint64_t seed, Paths& paths) const;

  const Scene& scene_;
  const Sensor& sensor_;
  const LocalLight& light_;
  bool hides_environment_;
  bool finds_extended_;        ///< sources that rays can meet are among them
  std::vector<float> shares_;  ///< of sources
  std::vector<double> ends_;   ///< running sums of their probabilities
  LightGuide guide_;
  double rays_per_path_ = 0;
  /// Of each source, while paths are guided: its paths of a picture for each primary of its pixels,
  /// times what guiding makes of them where they are of use. Empty until that is known.
  std::vector<float> rates_;
};

}  // namespace kinome
