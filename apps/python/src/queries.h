#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <memory>
#include <string>

#include "kinome/scene.h"
#include "kinome/scene_editor.h"

/// Ray queries, and evaluation of BSDFs and emitters, for arrays of points. They process blocks of
/// points on all cores, without the interpreter's lock. Arrays are of single precision, with one
/// row per ray or point. Results are flat arrays; kinome/_queries.py gives them their shapes.
namespace kinome::python {

namespace nb = nanobind;

using Floats = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const uint32_t, nb::c_contig, nb::device::cpu>;

/// Scene that keeps the shapes of surface points alive.
struct HeldScene {
  std::shared_ptr<const Scene> scene;
};

/// Finds the nearest hits of rays (N, 8): origin, minimum t, direction, maximum t. Returns the
/// scene (HeldScene), t (infinite without a hit), and the fields of the points in the order of
/// PointArrays in queries.cpp.
nb::tuple intersect_rays(const SceneEditor& editor, Floats rays, bool is_coherent);
/// Returns 1 for each occluded ray, otherwise 0.
nb::object occlude_rays(const SceneEditor& editor, Floats rays, bool is_coherent);
/// Samples rays through positions (N, 2) in the crop window, from 0 to 1, and lens points (N, 2).
/// Returns the rays in the form of intersect_rays().
nb::object sample_rays(const SceneEditor& editor, const std::string& sensor, Floats positions,
                       Floats aperture);

/// Evaluates and samples the BSDF at `path`, or each point's own if `path` is empty. `points` is
/// the tuple of intersect_rays() without t; its scene may be None. wo (N, 3), u1 (N) and u2 (N, 2)
/// may be None. Returns f, pdf, the sampled wo, weight, its pdf, its BsdfAnswer::is_delta, and its
/// relative index of refraction.
nb::tuple shade_points(const SceneEditor& editor, const std::string& path, nb::tuple points,
                       nb::object wo, nb::object u1, nb::object u2, uint32_t lobes);
/// Returns Bsdf::albedo() of the points; `path` as above.
nb::object albedo_of_points(const SceneEditor& editor, const std::string& path, nb::tuple points);
/// Returns the radiance that emitters send along each point's wi, and the density of sampling this
/// direction from the points `from` (N, 3). The emitter is that at `path`. If `path` is empty, it
/// is each point's own, or the environment if the point is on no shape.
nb::tuple emission_of_points(const SceneEditor& editor, const std::string& path, nb::tuple points,
                             Floats from);

/// Samples directions from the points p (N, 3) to the emitters with these indices into
/// Scene::emitters(). Returns the columns of DirectSample.
nb::tuple sample_emitters(const SceneEditor& editor, Indices emitters, Floats p, Floats u);

/// Returns the origins of rays that leave points toward d, as SurfaceInteraction::ray_origin().
nb::object spawn_origins(Floats p, Floats n, Floats p_error, Floats d);
/// Returns the rays from points to other points, as SurfaceInteraction::shadow_ray_to(), in the
/// form of intersect_rays().
nb::object shadow_rays(Floats p, Floats n, Floats p_error, Floats to);

}  // namespace kinome::python
