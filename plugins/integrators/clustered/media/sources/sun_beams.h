#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kinome/distribution.h"
#include "kinome/emitter.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"
#include "transport/media/bodies/media_table.h"
#include "transport/surfaces/scene_table.h"

namespace kinome {

/// Rays of light of a distant delta emitter, with a density that is learned from the paths of the
/// camera: many rays go where paths see the points that they reach. Immutable; thread-safe.
class SunBeams {
 public:
  /// `d`: unit direction toward the light. `rounds`: number of blocks of rays to learn from.
  SunBeams(const transport::SceneTable& scene, const transport::MediaTable& media,
           const Sensor& sensor, const Emitter& emitter, const Vec3& d, uint32_t rounds,
           RenderContext& context);

  /// Point at which camera rays may be scattered for the first time.
  struct SeenPoint {
    Vec3 p;
    Vec3 n;  ///< 0 in media
  };

  /// True if SunPoints can follow the light: nothing but boundaries of media passes it straight,
  /// and empty space is outside of all shapes.
  static bool are_possible(const Scene& scene, const transport::MediaTable& media);

  const Emitter& emitter() const { return emitter_; }
  const Vec3& toward_light() const { return d_; }
  /// Returns the origin of a ray, outside of the scene's bounds. `u` is uniform; near points give
  /// near origins. `pdf`: density per area, perpendicular to the light.
  Vec3 sample(const Vec2& u, float& pdf, uint32_t& cell) const;
  /// Squared distance at which light points and isotropic samples have equal weights.
  float near2() const { return near2_; }

 private:
  /// Cells along each side of the square through which the light reaches the scene.
  static constexpr uint32_t kResolution = 32;

  struct Learned;
  void learn(const transport::SceneTable& scene, const transport::MediaTable& media,
             const std::vector<SeenPoint>& seen, std::pair<uint32_t, uint32_t> rounds, Learned& all,
             RenderContext& context);
  void set_probabilities(const std::vector<float>& light);

  const Emitter& emitter_;
  const Vec3 d_;
  Frame frame_;  ///< n is the direction toward the light
  Vec3 centre_{0.f};
  float radius_ = 1;  ///< of the scene
  float near2_ = 1;
  std::vector<float> probability_;  ///< of cells, row by row
  GridDistribution cells_;          ///< in proportion to probability_
};

}  // namespace kinome
