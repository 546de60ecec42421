#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"
#include "kinome/render_context.h"
#include "transport/media/bodies/media_table.h"
#include "transport/surfaces/scene_table.h"

namespace kinome {

/// Estimated transmittance toward a distant emitter that lights all points from one direction, in
/// the cells of a grid over the scene. It only selects distances at which rays are lit. Immutable;
/// thread-safe.
class SunGrid {
 public:
  /// Traces kRays shadow rays in each of resolution³ cells. `d` is the unit direction toward the
  /// light.
  static constexpr uint32_t kRays = 4;
  SunGrid(const transport::SceneTable& scene, const transport::MediaTable& media, const Vec3& d,
          uint32_t resolution, RenderContext& context);

  /// Returns the estimate for a point; 1 outside of the grid.
  float at(const Vec3& p) const;
  /// Part of a ray in one cell.
  struct Part {
    float begin, end;  ///< distances
    float sum;         ///< sum of the weights up to and including this part
  };
  /// Sets the parts of the ray o + t d, 0 <= t <= length. Weights are the transmittance of the cell
  /// times an estimate of the share of the ray's light that is scattered there. They are positive.
  void divide(const Vec3& o, const Vec3& d, float length, float extinction,
              std::vector<Part>& parts) const;

 private:
  void trace_slab(const transport::SceneTable& scene, const transport::MediaTable& media,
                  const Vec3& d, uint32_t z);
  void spread();
  size_t index(uint32_t x, uint32_t y, uint32_t z) const {
    return (size_t{z} * resolution_ + y) * resolution_ + x;
  }

  uint32_t resolution_;
  Aabb box_;
  std::vector<float> transmittance_;
};

}  // namespace kinome
