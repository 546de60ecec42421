#pragma once

#include <cmath>
#include <optional>

#include "kinome/bsdf.h"
#include "kinome/interaction.h"
#include "kinome/sensor.h"

/// Scattering of light paths at surface points (Veach 1997, 4.7 and 10.1). si.wi is the direction
/// that the path comes from. All functions are thread-safe.
namespace kinome::transport {

/// Returns the factor of flux that arrives along `from` and leaves along `to`, relative to the BSDF
/// value for paths from the camera (f times |cos| of `from`). It corrects for shading normals and
/// all other scattering that isn't reciprocal (Veach 1997, 5.3). Arguments are cosines with the
/// surface's normal, float or wide::Float. Returns 0 for light that arrives edge-on.
template <class F>
F adjoint_factor(F cos_from, F cos_to) {
  using plain::select, std::abs;
  return select(cos_from == 0.f, F(0.f), abs(cos_to / cos_from));
}
/// The same for directions: unit, world space, away from the surface.
inline float adjoint_factor(const SurfaceInteraction& si, const kinome::Vec3& from,
                            const kinome::Vec3& to) {
  return adjoint_factor(glm::dot(si.n, from), glm::dot(si.n, to));
}

/// Returns the factor that converts the weight of a delta sample from radiance seen from wi to
/// power that arrives from wi. Refraction changes the cross-section and the solid angle of a beam
/// (Veach 1997, 5.2.2). Cosines are with the shading normal; eta: Bsdf::relative_index.
template <class F>
F power_over_radiance(const F& cos_wi, const F& cos_wo, float eta) {
  using plain::select, std::abs;
  const F index = select(cos_wi > 0.f, F(eta), F(1 / eta));
  return select(cos_wi * cos_wo < 0.f, index * index * abs(cos_wi / cos_wo), F(1.f));
}

/// Next edge of a light path.
struct AdjointSample {
  kinome::Vec3 to;     ///< unit, world space
  kinome::Rgb weight;  ///< factor of the flux along this edge; may be black
  bool is_delta;
  bool is_straight = false;  ///< Lobe::kNull
};

/// Samples the next edge by the BSDF's sampling of `lobes`, as for paths from the camera. If the
/// BSDF turns_to_viewer(), half of the samples are distributed by the cosine. Returns nullopt if
/// the path ends. `u_lobe` is in [0,1), `u` in [0,1)².
std::optional<AdjointSample> sample_adjoint(const SurfaceInteraction& si, Lobe lobes, float u_lobe,
                                            const kinome::Vec2& u);

/// Connection of a surface point to the camera.
struct SeenPoint {
  kinome::Vec2 film_position;
  kinome::Rgb factor;  ///< factor of the flux that arrives if unoccluded; may be black
  Ray shadow_ray;      ///< to the lens
};

/// Connects a surface point to the camera by all lobes except deltas. Returns nullopt if there are
/// no such lobes, or if the sensor doesn't see the point. `aperture` is in [0,1)².
std::optional<SeenPoint> connect_point(const Sensor& sensor, const SurfaceInteraction& si,
                                       const kinome::Vec2& aperture);

}  // namespace kinome::transport
