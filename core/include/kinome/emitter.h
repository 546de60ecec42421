#pragma once

#include <optional>
#include <span>

#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/light_points.h"
#include "kinome/object.h"

namespace kinome {

/// Light that arrives at a point from a sampled direction.
struct DirectSample {
  Vec3 d{0, 0, 1};  ///< unit, from the point toward the light, world space
  float distance = kInfinity;
  float pdf = 0;      ///< per solid angle at the point; 1 where is_delta
  Rgb radiance{0.f};  ///< unshadowed; for a delta light, irradiance on a facing surface
  bool is_delta = false;
};

/// A light. Radiance is in scene units, linear Rec.709.
class KINOME_EXPORT Emitter : public Object {
 public:
  /// Light from infinitely far, seen by rays that leave the scene. A scene has at most one.
  virtual bool is_environment() const { return false; }

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

  /// An emitter that wants to be clustered offers its light as `count` points, uniform over
  /// directions (or surfaces), whose powers sum to the light's whole. nullopt: it can't; it is then
  /// sampled by sample_direct alone. `seed` may move the points.
  virtual std::optional<LightPoints> light_points(uint32_t /*count*/, uint64_t /*seed*/) const {
    return std::nullopt;
  }

  /// sample_direct for many points at once; pdf is 0 where nothing can be had. A light with large
  /// tables overlaps its accesses to memory here. All spans have one size.
  virtual void sample_direct_batch(std::span<const Vec3> p, std::span<const Vec2> u,
                                   std::span<DirectSample> out) const {
    for (size_t i = 0; i < out.size(); ++i) {
      const auto sample = sample_direct(p[i], u[i]);
      out[i] = sample ? *sample : DirectSample{};
    }
  }
  /// eval_environment of many directions, and pdf_environment unless `pdf` is empty.
  virtual void eval_environment_batch(std::span<const Vec3> d, std::span<Rgb> radiance,
                                      std::span<float> pdf) const {
    for (size_t i = 0; i < d.size(); ++i) radiance[i] = eval_environment(d[i]);
    for (size_t i = 0; i < pdf.size(); ++i) pdf[i] = pdf_environment(d[i]);
  }
};

}  // namespace kinome
