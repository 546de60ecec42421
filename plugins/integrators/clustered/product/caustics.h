#pragma once

#include <vector>

#include "clustered/product/local_light.h"
#include "clustered/product/tile_grid.h"
#include "kinome/film.h"
#include "kinome/sensor.h"

namespace kinome {

/// Light that emitters send to mirrors, and these to what the camera sees, found by paths from the
/// emitters, which are connected to the sensor where they end (Veach 1997, 10.1; as `ptracer`):
/// - of lamps without extent, by one mirror or what nearly is one (LocalLight::kBounceDepth): no
///   ray from the camera meets the lamp, nor is a light point seen by the mirror's lobe;
/// - of surfaces that emit, and the sky's, by any number of delta lobes, smooth glass included.
/// Rays
///   from the camera's surface point find the same (EyeChains). Both have a share, by the balance
///   heuristic of about the densities that either has: what beams of delta lobes keep, but for the
///   factor of the media's indices, is area x cosine x solid angle, so that the densities at either
///   end of a chain can be compared as they are.
/// Paths are guided to where earlier ones, which count for nothing else, came to be seen.
/// Immutable; thread-safe.
class Caustics {
 public:
  /// Whether surface points can be connected to the sensor.
  static bool serves(const Sensor& sensor);
  Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light, uint64_t seed,
           RenderCounters& counters);

  /// False where all light is left to others.
  bool finds_any() const { return finds_extended_ || light_.has_lamp_caustics(); }
  /// Of all kinds, on average.
  double rays_per_path() const { return rays_per_path_; }

  /// Of light that comes to x, which a ray from the camera meets, along -d (unit, away from x): how
  /// densely EyeChains look for it, per area x cosine x solid angle, for each primary of a pixel.
  /// About that: a function of x and d alone. Infinite where nobody but they can find it.
  float eye_density(const SurfaceInteraction& x, const Vec3& d) const;
  /// The same of paths from the emitter; x: where the light leaves (nullptr:
  /// the sky), along d.
  float light_density(const Emitter& emitter, const SurfaceInteraction* x, const Vec3& d) const;
  /// Of light that has these densities, what EyeChains are to count.
  static float share_of_eye(float eye_density, float light_density);

  /// Squared deviation of each channel's mean that `count` paths leave, about, told by `tried`
  /// paths of its own: of the grid's pixels, whose filter is taken to be a box.
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
  void learn(uint64_t seed, RenderCounters& counters);
  bool is_worth_finding(uint64_t seed, RenderCounters& counters) const;
  void go_on(uint64_t seed, Paths& paths) const;
  void connect(uint64_t seed, Paths& paths) const;

  const Scene& scene_;
  const Sensor& sensor_;
  const LocalLight& light_;
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
