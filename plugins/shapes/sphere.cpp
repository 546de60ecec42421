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
    const DoubleRay line = space_.to_local(ray);
    SurfaceInteraction si =
        surface_at(glm::normalize(line.o + line.d * static_cast<double>(ray.tmax)));
    si.t = ray.tmax;
    si.wi = si.frame.to_local(glm::normalize(-ray.d));
    return si;
  }

  float area() const override {
    return static_cast<float>(4 * std::numbers::pi * radius_ * radius_);
  }

  SurfaceInteraction sample_surface(const Vec2& u) const override {
    return sampled_at(glm::normalize(DVec3(square_to_uniform_sphere(u))));
  }

  /// Uniform over the solid angle that the sphere covers: its cone from outside, all directions
  /// from inside.
  std::optional<SurfaceSample> sample_solid_angle(const Vec3& p, const Vec2& u) const override {
    const DVec3 offset = DVec3(p) - space_.offset();
    const double distance = glm::length(offset);
    const bool is_inside = distance <= radius_;
    const double height = is_inside ? 2 : cone_height(distance);
    // Around the direction toward the centre; any will do at the centre itself.
    const DVec3 axis = distance > 0 ? -offset / distance : DVec3(0, 0, 1);
    const double depth = static_cast<double>(u.y) * height;  // 1 - cos(theta)
    const double cosine = 1 - depth;
    const double sine = std::sqrt(depth * (2 - depth));
    // Of the triangle of p, the centre and the sphere's point: the angle at the point, which is
    // obtuse for the near side seen from outside; then the angle at the centre, from p.
    const double sin_point = std::min(sine * distance / radius_, 1.);
    const double cos_point = std::sqrt(1 - sin_point * sin_point) * (is_inside ? 1 : -1);
    const double cos_centre = sine * sin_point - cosine * cos_point;
    const double sin_centre = sine * cos_point + cosine * sin_point;
    const Frame frame = Frame::from_normal(Vec3(axis));
    const double phi = 2 * std::numbers::pi * static_cast<double>(u.x);
    const DVec3 n = (DVec3(frame.s) * std::cos(phi) + DVec3(frame.t) * std::sin(phi)) * sin_centre -
                    axis * cos_centre;
    SurfaceSample sample;
    sample.si = sampled_at(glm::normalize(space_.vector_to_local(n)));
    sample.pdf = static_cast<float>(1 / (2 * std::numbers::pi * height));
    if (sample.si.p == p) return std::nullopt;
    return sample;
  }

  float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const override {
    const DVec3 offset = DVec3(p) - space_.offset();
    const double distance = glm::length(offset);
    if (distance <= radius_) return kUniformSpherePdf;
    // The far side is never sampled. Rounding may put a point of the rim behind it.
    const double beyond = glm::dot(DVec3(si.p) - space_.offset(), offset) - radius_ * radius_;
    if (beyond < -4 * static_cast<double>(si.p_error) * distance) return 0;
    return static_cast<float>(1 / (2 * std::numbers::pi * cone_height(distance)));
  }

 private:
  /// Of the point of the unit sphere in `local` (unit): all but t, shape and wi.
  SurfaceInteraction surface_at(const DVec3& local) const {
    constexpr double pi = std::numbers::pi;
    const double sin_theta = std::hypot(local.x, local.y);
    const double cos_phi = sin_theta > 0 ? local.x / sin_theta : 1;
    const double sin_phi = sin_theta > 0 ? local.y / sin_theta : 0;

    SurfaceInteraction si;
    si.primitive = 0;
    si.p = Vec3(space_.point_to_world(local));
    si.p_error = surface_error(si.p, extent_);
    si.n = Vec3(space_.normal_to_world(local) * (flip_ ? -1. : 1.));
    si.uv = Vec2(turn(local.x, local.y), std::atan2(sin_theta, local.z) / pi);
    si.dp_du = Vec3(space_.vector_to_world(2 * pi * DVec3(-local.y, local.x, 0)));
    si.dp_dv =
        Vec3(space_.vector_to_world(pi * DVec3(local.z * cos_phi, local.z * sin_phi, -sin_theta)));
    si.frame = Frame::from_normal_and_tangent(si.n, si.dp_du);
    return si;
  }
  /// The same as a ray from outside along the normal would find it. From the point itself: a ray of
  /// floats would miss a sphere that is small beside its distance from the origin.
  SurfaceInteraction sampled_at(const DVec3& local) const {
    SurfaceInteraction si = surface_at(local);
    si.shape = this;
    si.t = 1;
    si.wi = si.frame.to_local(Vec3(space_.normal_to_world(local)));
    return si;
  }

  /// 1 - cos of the half-angle that the sphere covers from a distance to its centre beyond its
  /// radius; without cancellation, however far or near that is.
  double cone_height(double distance) const {
    const double ratio = radius_ / distance;
    const double cosine = std::sqrt((distance - radius_) * (distance + radius_)) / distance;
    return ratio * ratio / (1 + cosine);
  }

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
