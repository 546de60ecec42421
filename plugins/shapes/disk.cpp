/// The unit disk in the plane z = 0, seen from +z. u is the distance from the centre, v the angle
/// from the local +x axis over 2 pi. to_world may turn it into an ellipse.
///
///     <shape type="disk">
///       <transform name="to_world"><scale value="3"/><translate z="2"/></transform>
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

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, kNestedBsdf, kNestedEmitter};

class Disk final : public Shape {
 public:
  explicit Disk(const Properties& props)
      : Shape(props), space_(glm::dmat4(to_world_of(props).matrix())) {
    n_ = Vec3(space_.normal_to_world({0, 0, 1}) * (props.boolean("flip_normals") ? -1. : 1.));
    // A point cos(a) x + sin(a) y reaches furthest along an axis at hypot of its components.
    const glm::dmat3& m = space_.linear();
    const DVec3 reach = glm::sqrt(m[0] * m[0] + m[1] * m[1]);
    bounds_ = {Vec3(space_.offset() - reach), Vec3(space_.offset() + reach)};
    extent_ = max_component(glm::max(glm::abs(bounds_.lo), glm::abs(bounds_.hi)));
  }

  Aabb bounds() const override { return bounds_; }

  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    const DoubleRay local = space_.to_local(ray);
    const double root = -local.o.z / local.d.z;
    const auto inside = [&](double at) {
      const double x = local.o.x + at * local.d.x;
      const double y = local.o.y + at * local.d.y;
      return x * x + y * y <= 1;
    };
    // A parallel ray has a root that is infinite or not a number: no hit either way.
    if (!std::isfinite(root) || !first_root(root, root, ray, t, inside)) return false;
    hit.ng = n_;
    hit.u = 0;
    hit.v = 0;
    return true;
  }

  SurfaceInteraction interaction(const Ray& ray, const Hit& /*hit*/) const override {
    constexpr double pi = std::numbers::pi;
    const DoubleRay line = space_.to_local(ray);
    DVec3 local = line.o + line.d * static_cast<double>(ray.tmax);
    local.z = 0;
    const double r = std::hypot(local.x, local.y);
    const DVec3 radial = r > 0 ? local / r : DVec3(1, 0, 0);

    SurfaceInteraction si;
    si.t = ray.tmax;
    si.primitive = 0;
    si.p = Vec3(space_.point_to_world(local));
    si.p_error = surface_error(si.p, extent_);
    si.n = n_;
    si.uv = Vec2(std::min(r, 1.), turn(local.x, local.y));
    si.dp_du = Vec3(space_.vector_to_world(radial));
    si.dp_dv = Vec3(space_.vector_to_world(2 * pi * DVec3(-local.y, local.x, 0)));
    si.frame = Frame::from_normal_and_tangent(si.n, si.dp_du);
    si.wi = si.frame.to_local(glm::normalize(-ray.d));
    return si;
  }

  float area() const override {
    const glm::dmat3& m = space_.linear();
    return static_cast<float>(std::numbers::pi * glm::length(glm::cross(m[0], m[1])));
  }

  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const Vec2 local = square_to_disk_concentric(u);
    return interaction_at(*this, space_.point_to_world({local.x, local.y, 0}),
                          DVec3(n_) * glm::length(space_.linear()[0]));
  }

 private:
  LocalSpace space_;
  Vec3 n_{0, 0, 1};
  Aabb bounds_;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Disk, kinome::Category::kShape, "disk",
              "The unit disk in the plane z = 0, facing +z.", kinome::kTable);
