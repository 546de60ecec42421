#pragma once

#include <vector>

#include "clustered/product/local_light.h"
#include "kinome/film.h"
#include "kinome/sensor.h"

namespace kinome {

/// Light that lamps without extent send to a mirror, or to what nearly is one, and this to what the
/// camera sees: no ray from the camera meets the lamp, nor is a light point seen by the mirror's
/// lobe. Paths from the lamps find it; where they end, they are connected to the sensor (Veach
/// 1997, 10.1; as `ptracer`). Two segments and the connection: LocalLight::kBounceDepth. Paths are
/// guided to where earlier ones, which count for nothing else, came to be seen. Immutable;
/// thread-safe.
class Caustics {
 public:
  /// Whether surface points can be connected to the sensor.
  static bool serves(const Sensor& sensor);
  Caustics(const Scene& scene, const Sensor& sensor, const LocalLight& light, uint64_t seed,
           RenderCounters& counters);

  /// Of all kinds, on average.
  double rays_per_path() const { return rays_per_path_; }

  /// So many paths, whose light, and number, `film` is told.
  void trace(uint64_t seed, uint32_t count, FilmTile& film, RenderCounters& counters) const;

 private:
  struct Paths;
  /// fn(paths) for so many paths, some at a time, when their splats and shadow rays are traced.
  template <class Function>
  void trace_paths(uint64_t seed, uint32_t count, RenderCounters& counters,
                   const Function& fn) const;
  void reflect(uint64_t seed, Paths& paths) const;
  void connect(uint64_t seed, Paths& paths) const;

  const Scene& scene_;
  const Sensor& sensor_;
  const LocalLight& light_;
  const std::vector<float> shares_;  ///< of sources
  std::vector<double> ends_;         ///< running sums of their probabilities
  LightGuide guide_;
  double rays_per_path_ = 0;
};

}  // namespace kinome
