/// The unit disk in the plane z = 0, facing +z. u is the distance from the centre, v the angle from
/// the local +x axis divided by 2 pi. to_world may make it an ellipse.
///
///     <shape type="disk">
///       <transform name="to_world"><scale value="3"/><translate z="2"/></transform>
///     </shape>

#include <cmath>
#include <numbers>

#include "analytic_shape.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {kToWorld, kFlipNormals, KINOME_NESTED_IN_SHAPES};

class Disk final : public AnalyticShape<Disk> {
 public:
  explicit Disk(const Properties& props)
      : AnalyticShape(props), space_(glm::dmat4(to_world_of(props).matrix())) {
    n_ = Vec3(space_.normal_to_world(DVec3(0, 0, 1)) * (props.boolean("flip_normals") ? -1. : 1.));
    // The maximum of a component of cos(a) x + sin(a) y is the hypotenuse of those of x and y.
    const glm::dmat3& m = space_.linear();
    const DVec3 reach = glm::sqrt(m[0] * m[0] + m[1] * m[1]);
    bounds_ = {Vec3(space_.offset() - reach), Vec3(space_.offset() + reach)};
    extent_ = max_component(glm::max(glm::abs(bounds_.lo), glm::abs(bounds_.hi)));
  }

  Aabb bounds() const override { return bounds_; }

  float area() const override {
    const glm::dmat3& m = space_.linear();
    return static_cast<float>(std::numbers::pi * glm::length(glm::cross(m[0], m[1])));
  }

 private:
  friend class AnalyticShape<Disk>;

  Vec3 direction_of_normal(const Ray& /*ray*/, float /*t*/) const { return n_; }

  template <class V, class F>
  F first_hit(const V& o, const V& d, F tmin, F tmax) const {
    using D = DoubleOf<F>;
    const auto line = space_.to_local(o, d);
    const D root = -line.o.z / line.d.z;
    // The root of a parallel ray is infinite or NaN, so it is no hit.
    return first_root(Roots<D>{root, root, is_finite(root)}, tmin, tmax, [&](const auto& at) {
      const D x = line.o.x + at * line.d.x;
      const D y = line.o.y + at * line.d.y;
      return x * x + y * y <= 1.0;
    });
  }

  template <class V, class F>
  ShapePoint<F> hit_at(const V& o, const V& d, F t) const {
    const auto line = space_.to_local(o, d);
    auto local = line.o + line.d * to_double(t);
    local.z = 0.0;
    return surface_at(local);
  }

  template <class V2>
  ShapePoint<NumberOf<V2>> point_at(const V2& u) const {
    using D = DoubleOf<NumberOf<V2>>;
    const V2 local = warp::square_to_disk_concentric(u);
    return surface_at(DVecOf<D>(to_double(local.x), to_double(local.y), D(0.0)));
  }

  /// Returns the point for one of the unit disk, without wi.
  template <class DV>
  ShapePoint<FloatOf<NumberOf<DV>>> surface_at(const DV& local) const {
    using D = NumberOf<DV>;
    using F = FloatOf<D>;
    using V = VecOf<F>;
    constexpr double pi = std::numbers::pi;
    const D r = sqrt(local.x * local.x + local.y * local.y);
    const DV radial = select(r > 0.0, local / r, DV(D(1.0), D(0.0), D(0.0)));

    ShapePoint<F> point;
    point.p = to_float(space_.point_to_world(local));
    point.p_error = surface_error(point.p, extent_);
    point.n = V(n_);
    point.uv = {to_float(min(r, D(1.0))), turn(local.x, local.y)};
    point.dp_du = to_float(space_.vector_to_world(radial));
    point.dp_dv = to_float(space_.vector_to_world(DV(-local.y, local.x, D(0.0)) * (2 * pi)));
    point.frame = FrameOf<V>::from_normal_and_tangent(point.n, point.dp_du);
    return point;
  }

  LocalSpace space_;
  Vec3 n_{0, 0, 1};
  Aabb bounds_;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Disk, kinome::Category::kShape, "disk",
              "The unit disk in the plane z = 0, facing +z.", kinome::kTable);
