#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/light_samples.h"
#include "kinome/object.h"

namespace kinome {

class Shape;
struct Shutter;

/// Light source. Radiance is in scene units, linear Rec.709.
///
/// Only sample_direct() is mandatory. Other functions are needed by some integrators:
/// - `direct`, `path` and `clustered` (direct light): is_environment(), eval_environment() and
///   pdf_environment() for environments; is_surface(), eval_surface() and pdf_surface() for area
///   emitters; is_delta() for emitters that light a point from a single direction.
/// - `ptracer`, and `clustered` (indirect light): sample_emission(); `clustered` also
///   emission_density() for emitters without a surface.
///
/// Sky (kinome/sky.h) implements all of these for an environment whose radiance is known.
/// ClusteredLight (kinome/clustered_light.h) has optional functions for clustering.
/// `kinome check` tests that the implemented functions agree with each other.
class KINOME_EXPORT Emitter : public Object {
 public:
  /// True if the light comes from infinity, so that rays that leave the scene see it. A scene has
  /// at most one environment.
  virtual bool is_environment() const { return false; }
  /// True if the emitter is the surface of the shape that contains it.
  virtual bool is_surface() const { return false; }
  /// True if light reaches each point from a single direction. sample_direct() then ignores u,
  /// which may hold anything, NaN included. Always false for surfaces and environments.
  virtual bool is_delta() const { return false; }
  /// True if the emitter represents one bounce of other emitters' light as light points. Only
  /// integrators that render with light points use such emitters, because others find indirect
  /// light by themselves.
  virtual bool is_indirect() const { return false; }
  /// Returns the nested emitters, which are part of the scene like all others. An indirect emitter
  /// represents the bounce of its children, or of all emitters of the scene if it has none.
  virtual std::vector<std::shared_ptr<Emitter>> children() const { return {}; }

  /// Sets the shape of a surface emitter. The shape calls it once; throws Error if the emitter
  /// already has a shape.
  void attach(const Shape& shape);
  const Shape* shape() const { return shape_; }

  /// Sets the shutter interval of the scene's first sensor. Called before prepare(). An emitter
  /// that varies with time must emit its mean over the interval, which is exact because nothing
  /// else in a scene moves. Not thread-safe.
  virtual void set_shutter(const Shutter& /*shutter*/) {}
  /// Called once when the bounds of the scene's geometry are known, before rendering.
  virtual void prepare(const Aabb& /*scene_bounds*/) {}

  /// Radiance of an environment along the unit direction d, which points toward the environment.
  virtual Rgb eval_environment(const Vec3& /*d*/) const { return Rgb(0.f); }
  /// Radiance that leaves the point `si` of an emitting surface along si.wi.
  virtual Rgb eval_surface(const SurfaceInteraction& /*si*/) const { return Rgb(0.f); }

  /// Samples a direction from p toward the emitter. Returns nullopt if sampling fails.
  virtual std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const = 0;
  /// Density of sample_direct(p) for direction d toward an environment, per solid angle. It may be
  /// 0 only where the radiance is 0.
  virtual float pdf_environment(const Vec3& /*d*/) const { return 0; }
  /// Density of sample_direct(p) for the point `si` of an emitting surface, per solid angle at p.
  virtual float pdf_surface(const Vec3& /*p*/, const SurfaceInteraction& /*si*/) const { return 0; }

  /// Samples a ray that leaves the emitter, for light tracing. `position` chooses the origin (on
  /// the emitter, or in the cross-section of its beam), `direction` the direction. Returns nullopt
  /// if sampling fails.
  virtual std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                        const Vec2& /*direction*/) const {
    return std::nullopt;
  }

  /// Densities of sample_emission() for light that leaves along the unit direction d, for emitters
  /// without a surface. Returns nullopt if unknown; `clustered` then renders the light's bounces
  /// without learned clusters.
  virtual std::optional<EmissionDensity> emission_density(const Vec3& /*d*/) const {
    return std::nullopt;
  }

  /// Block versions (see blocks.h). The defaults call the scalar functions point by point.
  ///
  /// Calls sample_direct() for each p. Sets pdf to 0 where sampling fails.
  virtual void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                                   const DirectBlock& out) const;
  /// Calls eval_environment() for each d, and pdf_environment() unless `pdf` is nullptr.
  virtual void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                                      float* pdf) const;
  /// Calls eval_surface() for each point, and pdf_surface() as seen from `from` unless `pdf` is
  /// nullptr.
  virtual void eval_surface_block(const SurfaceBlock& points, const Columns3& from,
                                  const Columns3& radiance, float* pdf) const;
  /// Calls sample_emission() for each pair of random numbers.
  virtual void sample_emission_block(const Columns2& position, const Columns2& direction,
                                     size_t count, const EmissionBlock& out) const;

 private:
  const Shape* shape_ = nullptr;
};

}  // namespace kinome
