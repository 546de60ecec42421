#pragma once

#include <optional>
#include <span>

#include "kinome/emitter.h"
#include "kinome/environment_grid.h"
#include "kinome/light_points.h"

namespace kinome {

class RenderContext;
class Scene;

/// Optional functions of an emitter, for integrators that cluster light (`clustered`,
/// `groundtruth`). An emitter with such functions derives from this class, too. Environments
/// without them are clustered by probing Emitter::eval_environment(): see light_points_of() and
/// cell_grid_of().
class KINOME_EXPORT ClusteredLight {
 public:
  virtual ~ClusteredLight();

  /// Represents the emitter by about `count` light points, distributed uniformly over directions
  /// (or surfaces). Their powers sum to the emitter's power. Positions may depend on
  /// context.job.seed(). Adds traced rays and elapsed time to context.job.stats(). Returns nullopt
  /// if unsupported.
  virtual std::optional<LightPoints> light_points(const Scene& /*scene*/,
                                                  RenderContext& /*context*/,
                                                  uint32_t /*count*/) const {
    return std::nullopt;
  }

  /// Layout of the environment's radiance for learned cells. Returns nullopt if unsupported.
  virtual std::optional<EnvironmentGrid> cell_grid() const { return std::nullopt; }
  /// Evaluates the radiance at positions in cell_grid(): x in [0, columns], y in [0, rows]. Returns
  /// false if unsupported; callers then evaluate directions.
  virtual bool eval_grid_batch(std::span<const Vec2> /*places*/,
                               std::span<Rgb> /*radiance*/) const {
    return false;
  }
  /// Evaluates the radiance at the upper corners of one row of quads of cell_grid(): columns
  /// `first`, `first` + 1, …; `row` may equal the number of rows. Returns false if unsupported;
  /// callers then use eval_grid_batch().
  virtual bool eval_grid_corners(int /*row*/, int /*first*/, std::span<Rgb> /*radiance*/) const {
    return false;
  }
  /// Evaluates Emitter::eval_environment() for many directions, and pdf_environment() unless `pdf`
  /// is empty. Returns false if unsupported; callers then use these functions.
  virtual bool eval_environment_batch(std::span<const Vec3> /*d*/, std::span<Rgb> /*radiance*/,
                                      std::span<float> /*pdf*/) const {
    return false;
  }
};

/// Returns the emitter's own functions, or nullptr if it has none.
KINOME_EXPORT const ClusteredLight* clustered_light(const Emitter& emitter);

/// Returns the emitter's own light points. Those of an environment that has none are the means of
/// its radiance over cells of equal solid angle, each estimated from 16 random directions. Returns
/// nullopt for other emitters.
KINOME_EXPORT std::optional<LightPoints> light_points_of(const Emitter& emitter, const Scene& scene,
                                                         RenderContext& context, uint32_t count);

/// Returns the emitter's own grid. An environment that has none gets quads of half a degree that
/// aren't smooth. Returns nullopt for other emitters. Throws Error if the grid has no quads, or too
/// many.
KINOME_EXPORT std::optional<EnvironmentGrid> cell_grid_of(const Emitter& emitter);

/// Evaluates many directions of an environment, as ClusteredLight::eval_environment_batch() does.
KINOME_EXPORT void eval_environment(const Emitter& emitter, std::span<const Vec3> d,
                                    std::span<Rgb> radiance, std::span<float> pdf = {});

}  // namespace kinome
