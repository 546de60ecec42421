#pragma once

#include <cmath>
#include <optional>

#include "kinome/bsdf.h"
#include "kinome/interaction.h"
#include "kinome/sensor.h"

/// What light paths do at the surface points that they come to, whose si.wi is where they come from
/// (Veach 1997, 4.7 and 10.1). All of it thread-safe.
namespace kinome::transport {

/// How flux that arrives along `from` counts as radiance that leaves along `to`, for a BSDF that is
/// evaluated as paths from the camera do: by f |cos| of `from` (Veach 1997, 5.3, for shading
/// normals and all else that is not reciprocal). By the cosines of both with the surface's normal,
/// float or wide::Float. Light that arrives edge-on brings no flux.
template <class F>
F adjoint_factor(F cos_from, F cos_to) {
  using plain::select, std::abs;
  return select(cos_from == 0.f, F(0.f), abs(cos_to / cos_from));
}
/// The same by the directions: unit, world space, away from the surface.
inline float adjoint_factor(const SurfaceInteraction& si, const kinome::Vec3& from,
                            const kinome::Vec3& to) {
  return adjoint_factor(glm::dot(si.n, from), glm::dot(si.n, to));
}

/// What the weight of a delta sample, which is that of radiance seen from wi, is to be multiplied by
/// where power comes from there: a beam that is bent has another cross-section and another solid
/// angle (Veach 1997, 5.2.2). Cosines of the shading normal; eta: Bsdf::relative_index.
template <class F>
F power_over_radiance(const F& cos_wi, const F& cos_wo, float eta) {
  using plain::select, std::abs;
  const F index = select(cos_wi > 0.f, F(eta), F(1 / eta));
  return select(cos_wi * cos_wo < 0.f, index * index * abs(cos_wi / cos_wo), F(1.f));
}

/// A light path's next edge.
struct AdjointSample {
  kinome::Vec3 to;     ///< unit, world space
  kinome::Rgb weight;  ///< of the flux that goes on; may be black
  bool is_delta;
  bool is_straight = false;  ///< Lobe::kNull
};

/// By the BSDF's own sampling of `lobes`, which is that of paths from the camera, and half by the
/// cosine where it turns_to_viewer(); nullopt: the path ends. `u_lobe` in [0,1), `u` in [0,1)².
std::optional<AdjointSample> sample_adjoint(const SurfaceInteraction& si, Lobe lobes, float u_lobe,
                                            const kinome::Vec2& u);

/// How a surface point is seen by the camera.
struct SeenPoint {
  kinome::Vec2 film_position;
  kinome::Rgb factor;  ///< of the flux that arrives, if nothing is in the way; may be black
  Ray shadow_ray;      ///< to the lens
};

/// By all lobes but deltas. nullopt: there are no others, or the sensor doesn't see the point.
/// `aperture` in [0,1)².
std::optional<SeenPoint> connect_point(const Sensor& sensor, const SurfaceInteraction& si,
                                       const kinome::Vec2& aperture);

}  // namespace kinome::transport
