/// A sphere. u is the angle around the local z axis from +x, over 2 pi; v the angle from +z, over
/// pi. A mirroring to_world turns the normals inward, as in Mitsuba 3.
///
///     <shape type="sphere">
///       <point name="center" x="1" y="-2" z="3"/>
///       <float name="radius" value="2"/>
///     </shape>

#include <cmath>
#include <numbers>

#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "local_space.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"center", ParameterType::kVector, "0 0 0", "Centre, before to_world."},
    {"radius", ParameterType::kFloat, "1", "Radius, before to_world."},
    kToWorld,
    kFlipNormals,
    kNestedBsdf,
    kNestedEmitter,
};

class Sphere final : public Shape {
 public:
  explicit Sphere(const Properties& props) : Shape(props), space_(unit_sphere_to_world(props)) {
    if (!is_similarity(space_.linear())) {
      throw props.error("to_world",
                        "must scale a sphere alike in all directions, and not shear it");
    }
    radius_ = glm::length(space_.linear()[0]);
    // A negative radius or a mirroring transform turns the sphere inside out.
    flip_ = props.boolean("flip_normals") != (glm::determinant(space_.linear()) < 0);
    extent_ = glm::length(space_.offset()) + radius_;
  }

  Aabb bounds() const override {
    return {Vec3(space_.offset() - radius_), Vec3(space_.offset() + radius_)};
  }

  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    const DoubleRay local = space_.to_local(ray);
    double t0 = 0;
    double t1 = 0;
    if (!unit_ball_roots<3>(local, t0, t1)) return false;
    if (!first_root(t0, t1, ray, t, [](double) { return true; })) return false;
    hit.ng = Vec3(space_.normal_to_world(local.o + local.d * static_cast<double>(t)));
    hit.u = 0;
    hit.v = 0;
    return true;
  }

  SurfaceInteraction interaction(const Ray& ray, const Hit& /*hit*/) const override {
    constexpr double pi = std::numbers::pi;
    const DoubleRay line = space_.to_local(ray);
    const DVec3 local = glm::normalize(line.o + line.d * static_cast<double>(ray.tmax));
    const double sin_theta = std::hypot(local.x, local.y);
    const double cos_phi = sin_theta > 0 ? local.x / sin_theta : 1;
    const double sin_phi = sin_theta > 0 ? local.y / sin_theta : 0;

    SurfaceInteraction si;
    si.t = ray.tmax;
    si.primitive = 0;
    si.p = Vec3(space_.point_to_world(local));
    si.p_error = surface_error(si.p, extent_);
    si.n = Vec3(space_.normal_to_world(local) * (flip_ ? -1. : 1.));
    si.uv = Vec2(turn(local.x, local.y), std::atan2(sin_theta, local.z) / pi);
    si.dp_du = Vec3(space_.vector_to_world(2 * pi * DVec3(-local.y, local.x, 0)));
    si.dp_dv =
        Vec3(space_.vector_to_world(pi * DVec3(local.z * cos_phi, local.z * sin_phi, -sin_theta)));
    si.frame = Frame::from_normal_and_tangent(si.n, si.dp_du);
    si.wi = si.frame.to_local(glm::normalize(-ray.d));
    return si;
  }

  float area() const override {
    return static_cast<float>(4 * std::numbers::pi * radius_ * radius_);
  }

  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const DVec3 local(square_to_uniform_sphere(u));
    return interaction_at(*this, space_.point_to_world(local), space_.vector_to_world(local));
  }

 private:
  static glm::dmat4 unit_sphere_to_world(const Properties& props) {
    const float radius = props.real("radius");
    if (!(radius > 0) || !std::isfinite(radius)) {
      throw props.error("radius", "must be positive and finite, got " + std::to_string(radius));
    }
    const Vec3 center = props.vector("center");
    if (!is_finite(center)) throw props.error("center", "must be finite");
    const glm::dmat4 local(glm::dvec4(radius, 0, 0, 0), glm::dvec4(0, radius, 0, 0),
                           glm::dvec4(0, 0, radius, 0), glm::dvec4(DVec3(center), 1));
    return glm::dmat4(to_world_of(props).matrix()) * local;
  }

  LocalSpace space_;  ///< of the unit sphere
  double radius_ = 1;
  bool flip_ = false;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Sphere, kinome::Category::kShape, "sphere",
              "A sphere with exact (not triangulated) geometry.", kinome::kTable);
