#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/color.h"
#include "kinome/environment_grid.h"
#include "kinome/interaction.h"
#include "kinome/light_points.h"
#include "kinome/object.h"

namespace kinome {

class RenderContext;
class Scene;
class Shape;
struct Shutter;

/// Light that arrives at a point from a sampled direction.
struct DirectSample {
  Vec3 d{0, 0, 1};  ///< unit, from the point toward the light, world space
  float distance = kInfinity;  ///< from the point to the light, world units
  float pdf = 0;      ///< per solid angle at the point; 1 where is_delta
  Rgb radiance{0.f};  ///< unshadowed; for a delta light, irradiance on a facing surface
  bool is_delta = false;
};

/// Light that leaves an emitter along a sampled ray.
struct EmissionSample {
  Vec3 o{0.f};        ///< where it starts: on the light, or outside the scene for an environment
  Vec3 d{0, 0, 1};    ///< unit
  Vec3 n{0.f};        ///< unit normal of the emitting surface at o; 0 for all other lights
  float o_error = 0;  ///< bound on the distance of o from the surface (SurfaceInteraction::p_error)
  /// Flux that the sample stands for [W]: radiance x |cos| / (density of o x density of d); for
  /// deltas the intensity / density of d, or the irradiance / density of o.
  Rgb power{0.f};
  /// Density of d per solid angle, o being given; 0 for parallel light (directional).
  float pdf_direction = 0;
  /// Light from infinitely far only (0 otherwise): density of o per area perpendicular to d, d
  /// being given, and so that of where rays of one direction land.
  float pdf_position = 0;

  /// Starts off the surface, on the side of d: interpolated normals let light leave below a face.
  Ray ray() const {
    Ray ray;
    ray.o = origin_off_surface(o, n, o_error, d);
    ray.d = d;
    return ray;
  }
};

/// Densities of a ray of light without a surface, as in EmissionSample.
struct EmissionDensity {
  float direction = 0;
  float position = 0;
};

/// A light. Radiance is in scene units, linear Rec.709.
///
/// Of all its functions sample_direct() alone must be there. What else it needs depends on what is to
/// see its light:
/// - `direct`, `path`, and `clustered` for direct light: of an environment is_environment(),
///   eval_environment() and pdf_environment(); of a surface is_surface(), eval_surface() and
///   pdf_surface(); of light that comes to a point from one direction alone is_delta().
/// - `clustered` by learned cells of an environment: cell_grid(). Without it, sample_direct() is asked.
/// - `clustered` for light after bounces: sample_emission(), and emission_density() where it has no
///   surface.
/// - `ptracer`: sample_emission().
/// - `groundtruth`, and `clustered` by other importances than `product`: light_points().
///
/// `kinome check` finds out whether those that are there fit together.
class KINOME_EXPORT Emitter : public Object {
 public:
  /// Light from infinitely far, seen by rays that leave the scene. A scene has at most one.
  virtual bool is_environment() const { return false; }
  /// Light of the surface of the shape that it is nested in.
  virtual bool is_surface() const { return false; }
  /// Light that arrives at a point from one direction alone: sample_direct gives that, whatever u
  /// is, which may hold anything then, NaN too. Not of surfaces and environments.
  virtual bool is_delta() const { return false; }
  /// Offers the light of other emitters after a bounce, as light points: of use to integrators over
  /// light points alone, since others find that light by themselves.
  virtual bool is_indirect() const { return false; }
  /// Emitters nested in this one, which are part of the scene like any other. An indirect emitter
  /// offers their bounce, or if there are none, that of all the scene's.
  virtual std::vector<std::shared_ptr<Emitter>> children() const { return {}; }

  /// Called once by the shape that a surface emitter is part of. Error where there is one already.
  void attach(const Shape& shape);
  const Shape* shape() const { return shape_; }

  /// Called before prepare() with the shutter of the scene's first sensor. An emitter that changes
  /// with time must then emit its mean over this interval; the same image follows, because nothing
  /// else moves. Not thread-safe.
  virtual void set_shutter(const Shutter& /*shutter*/) {}
  /// Called once, when the scene's geometry is known.
  virtual void prepare(const Aabb& /*scene_bounds*/) {}

  /// Radiance that arrives along the unit direction d from an environment (d points toward it).
  virtual Rgb eval_environment(const Vec3& /*d*/) const { return Rgb(0.f); }
  /// Radiance that leaves a point of an emitting surface toward the viewer, si.wi.
  virtual Rgb eval_surface(const SurfaceInteraction& /*si*/) const { return Rgb(0.f); }

  /// A direction toward the light from p; nullopt where none can be had.
  virtual std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const = 0;
  /// Density of sample_direct(p) for the direction d of an environment, per solid angle. Zero only
  /// where the radiance is zero.
  virtual float pdf_environment(const Vec3& /*d*/) const { return 0; }
  /// Density of sample_direct(p) for a point of an emitting surface, per solid angle at p.
  virtual float pdf_surface(const Vec3& /*p*/, const SurfaceInteraction& /*si*/) const { return 0; }

  /// A ray of light that leaves the emitter (for light tracing); nullopt where none can be had.
  /// `position` picks where on the light or in its cross-section, `direction` whereto.
  virtual std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                        const Vec2& /*direction*/) const {
    return std::nullopt;
  }

  /// Densities of sample_emission for light that leaves along the unit direction d, of emitters
  /// without a surface. nullopt: not known; the light's bounce is then left to other methods than
  /// learned clusters.
  virtual std::optional<EmissionDensity> emission_density(const Vec3& /*d*/) const {
    return std::nullopt;
  }

  /// An emitter that wants to be clustered offers its light as about `count` points, uniform over
  /// directions (or surfaces), whose powers sum to the light's whole. nullopt: it can't; it is then
  /// sampled by sample_direct alone. context.seed() may move the points; rays that are traced and
  /// time that is spent go to its statistics.
  virtual std::optional<LightPoints> light_points(const Scene& /*scene*/,
                                                  RenderContext& /*context*/,
                                                  uint32_t /*count*/) const {
    return std::nullopt;
  }

  /// An environment that wants to be sampled by learned clusters says how its
  /// radiance is laid out: cells are made of that, and nothing else is asked for but
  /// eval_environment_batch. nullopt: it isn't.
  virtual std::optional<EnvironmentGrid> cell_grid() const { return std::nullopt; }
  /// Radiance at places of cell_grid(): x in [0, columns], y in [0, rows]. False: not offered;
  /// eval_environment_batch is asked then, for directions.
  virtual bool eval_grid_batch(std::span<const Vec2> /*places*/,
                               std::span<Rgb> /*radiance*/) const {
    return false;
  }

  /// Radiance at corners of the quads of cell_grid(): those of columns `first`, first + 1, …, at
  /// the upper edge of `row` (up to the number of rows). False: not offered; places are asked for.
  virtual bool eval_grid_corners(int /*row*/, int /*first*/, std::span<Rgb> /*radiance*/) const {
    return false;
  }

  /// eval_environment of many directions, and pdf_environment unless `pdf` is empty.
  virtual void eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                                      std::span<float> pdf) const {
    for (size_t i = 0; i < d.size(); ++i) radiance[i] = eval_environment(d[i]);
    for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = pdf_environment(d[i]);
  }

  /// The same over blocks (blocks.h). sample_direct toward the light from each p; pdf is 0 where
  /// nothing can be had. Default: all of these ask point by point.
  virtual void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                                   const DirectBlock& out) const;
  /// eval_environment of each d, and pdf_environment unless `pdf` is nullptr.
  virtual void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiance,
                                      float* pdf) const;
  /// eval_surface of each point, and pdf_surface as seen from the points `from` unless `pdf` is
  /// nullptr.
  virtual void eval_surface_block(const SurfaceBlock& points, const Columns3& from,
                                  const Columns3& radiance, float* pdf) const;
  /// sample_emission. Default: one by one.
  virtual void sample_emission_block(const Columns2& position, const Columns2& direction,
                                     size_t count, const EmissionBlock& out) const;

 private:
  const Shape* shape_ = nullptr;
};

}  // namespace kinome
