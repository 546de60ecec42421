#pragma once

#include <cmath>

#include "kinome/interaction.h"

namespace kinome {

/// How flux that arrives along `from` counts as radiance that leaves along `to`, for a BSDF that is
/// evaluated as paths from the camera do: by f |cos| of `from` (Veach 1997, 5.3, for shading
/// normals and all else that is not reciprocal). Both unit, world space, away from the surface.
/// Light that arrives edge-on brings no flux.
inline float adjoint_factor(const SurfaceInteraction& si, const Vec3& from, const Vec3& to) {
  const float cosine = glm::dot(si.n, from);
  return cosine == 0 ? 0.f : std::abs(glm::dot(si.n, to) / cosine);
}

}  // namespace kinome
