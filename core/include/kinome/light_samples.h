#pragma once

#include "kinome/color.h"
#include "kinome/interaction.h"
#include "kinome/ray.h"

namespace kinome {

/// Direction sampled toward an emitter, with the unoccluded radiance that arrives along it.
struct DirectSample {
  Vec3 d{0, 0, 1};  ///< unit direction from the reference point toward the emitter, world space
  float distance = kInfinity;  ///< distance from the reference point to the emitter, world units
  float pdf = 0;               ///< per solid angle at the reference point; 1 if is_delta
  Rgb radiance{0.f};  ///< unoccluded; for a delta emitter, irradiance on a surface that faces it
  bool is_delta = false;
};

/// Ray sampled from an emitter, for light tracing.
struct EmissionSample {
  Vec3 o{0.f};        ///< origin: on the emitter, or outside the scene for an environment
  Vec3 d{0, 0, 1};    ///< unit direction
  Vec3 n{0.f};        ///< unit normal of the emitting surface at o; 0 if the emitter has no surface
  float o_error = 0;  ///< error bound of o, as SurfaceInteraction::p_error
  /// Flux that the sample represents [W]: radiance x |cos| / (density of o x density of d). For
  /// delta emitters, intensity / density of d, or irradiance / density of o.
  Rgb power{0.f};
  /// Density of d per solid angle, given o; 0 for parallel light (directional).
  float pdf_direction = 0;
  /// Density of o per area perpendicular to d, given d; 0 unless the light comes from infinity.
  float pdf_position = 0;

  /// Returns the ray, with its origin moved off the surface toward d. With interpolated normals, d
  /// may point below the face.
  Ray ray() const { return {origin_off_surface(o, n, o_error, d), d}; }
};

/// Densities of a ray that leaves an emitter without a surface, as in EmissionSample.
struct EmissionDensity {
  float direction = 0;  ///< per solid angle; EmissionSample::pdf_direction
  float position = 0;   ///< per area; EmissionSample::pdf_position
};

}  // namespace kinome
