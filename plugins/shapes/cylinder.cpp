/// A cylinder's side, without caps, seen from outside and inside. u is the angle around the axis
/// over 2 pi, v goes from 0 at p0 to 1 at p1. The angle starts where Mitsuba 3 has it: at the first
/// axis of the frame of Duff et al. 2017 around p1 - p0.
///
///     <shape type="cylinder">
///       <point name="p0" value="0, 0, -1"/>
///       <point name="p1" value="0, 0, 1"/>
///       <float name="radius" value="0.3"/>
///     </shape>

#include <cmath>
#include <numbers>

#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "local_space.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"p0", ParameterType::kVector, "0 0 0", "One end of the axis, before to_world."},
    {"p1", ParameterType::kVector, "0 0 1", "The other end."},
    {"radius", ParameterType::kFloat, "1", "Radius, before to_world."},
    kToWorld,
    kFlipNormals,
    kNestedBsdf,
    kNestedEmitter,
};

class Cylinder final : public Shape {
 public:
  explicit Cylinder(const Properties& props) : Shape(props), space_(unit_cylinder_to_world(props)) {
    const glm::dmat3& m = space_.linear();
    if (!is_similarity(m, 2)) {
      throw props.error("to_world",
                        "must scale a cylinder alike across its axis, and not shear it");
    }
    sign_ = props.boolean("flip_normals") ? -1 : 1;
    // The end circles' reach along each axis, as of a disk.
    const DVec3 reach = glm::sqrt(m[0] * m[0] + m[1] * m[1]);
    for (const DVec3& end : {space_.offset(), space_.offset() + m[2]}) {
      bounds_.expand(Vec3(end - reach));
      bounds_.expand(Vec3(end + reach));
    }
    extent_ = max_component(glm::max(glm::abs(bounds_.lo), glm::abs(bounds_.hi)));
  }

  Aabb bounds() const override { return bounds_; }

  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    const DoubleRay local = space_.to_local(ray);
    double t0 = 0;
    double t1 = 0;
    if (!unit_ball_roots<2>(local, t0, t1)) return false;
    const auto between_ends = [&](double at) {
      const double z = local.o.z + at * local.d.z;
      return z >= 0 && z <= 1;
    };
    if (!first_root(t0, t1, ray, t, between_ends)) return false;
    const DVec3 p = local.o + local.d * static_cast<double>(t);
    hit.ng = Vec3(space_.normal_to_world({p.x, p.y, 0}) * sign_);
    hit.u = 0;
    hit.v = 0;
    return true;
  }

  SurfaceInteraction interaction(const Ray& ray, const Hit& /*hit*/) const override {
    const DoubleRay line = space_.to_local(ray);
    const DVec3 hit = line.o + line.d * static_cast<double>(ray.tmax);
    const double r = std::hypot(hit.x, hit.y);
    SurfaceInteraction si = surface_at({hit.x / r, hit.y / r, 0}, hit.z);
    si.t = ray.tmax;
    si.wi = si.frame.to_local(glm::normalize(-ray.d));
    return si;
  }

  float area() const override {
    const glm::dmat3& m = space_.linear();
    return static_cast<float>(2 * std::numbers::pi * glm::length(m[0]) * glm::length(m[2]));
  }

  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const double phi = 2 * std::numbers::pi * u.x;
    const DVec3 radial(std::cos(phi), std::sin(phi), 0);
    // From the point itself: a ray of floats would miss a cylinder that is thin beside its distance
    // from the origin.
    SurfaceInteraction si = surface_at(radial, u.y);
    si.shape = this;
    si.t = 1;
    si.wi = si.frame.to_local(Vec3(space_.normal_to_world(radial)));
    return si;
  }

 private:
  /// Of the point of the unit cylinder at `z` in the unit direction `radial` from its axis: all but
  /// t, shape and wi.
  SurfaceInteraction surface_at(const DVec3& radial, double z) const {
    constexpr double two_pi = 2 * std::numbers::pi;
    SurfaceInteraction si;
    si.primitive = 0;
    si.p = Vec3(space_.point_to_world({radial.x, radial.y, z}));
    si.p_error = surface_error(si.p, extent_);
    si.n = Vec3(space_.normal_to_world(radial) * sign_);
    si.uv = Vec2(turn(radial.x, radial.y), std::clamp(z, 0., 1.));
    si.dp_du = Vec3(space_.vector_to_world(two_pi * DVec3(-radial.y, radial.x, 0)));
    si.dp_dv = Vec3(space_.vector_to_world({0, 0, 1}));
    si.frame = Frame::from_normal_and_tangent(si.n, si.dp_du);
    return si;
  }
  static glm::dmat4 unit_cylinder_to_world(const Properties& props) {
    const Vec3 p0 = props.vector("p0");
    const Vec3 p1 = props.vector("p1");
    if (!is_finite(p0)) throw props.error("p0", "must be finite");
    if (!is_finite(p1)) throw props.error("p1", "must be finite");
    const DVec3 axis = DVec3(p1) - DVec3(p0);
    const double length = glm::length(axis);
    if (!(length > 0)) throw props.error("p1", "must differ from p0");
    const float radius = props.real("radius");
    if (!(radius > 0) || !std::isfinite(radius)) {
      throw props.error("radius", "must be positive and finite, got " + std::to_string(radius));
    }
    // Frame::from_normal in double.
    const DVec3 n = axis / length;
    const double sign = std::copysign(1., n.z);
    const double a = -1 / (sign + n.z);
    const double b = n.x * n.y * a;
    const DVec3 s(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const DVec3 t(b, sign + n.y * n.y * a, -n.y);
    const double r = radius;
    const glm::dmat4 local(glm::dvec4(s * r, 0), glm::dvec4(t * r, 0), glm::dvec4(axis, 0),
                           glm::dvec4(DVec3(p0), 1));
    return glm::dmat4(to_world_of(props).matrix()) * local;
  }

  LocalSpace space_;  ///< of the cylinder of radius 1 from z = 0 to z = 1
  double sign_ = 1;
  Aabb bounds_;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Cylinder, kinome::Category::kShape, "cylinder",
              "A cylinder's side, without caps.", kinome::kTable);
