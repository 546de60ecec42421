/// A sphere. u is the angle around the local z axis from +x, divided by 2 pi; v is the angle from
/// +z, divided by pi. As in Mitsuba 3, a to_world that mirrors flips the normals inward, and one
/// that scales unevenly or shears doesn't make an ellipsoid: the radius is scaled like the x axis.
/// For an ellipsoid, use an instance of a sphere, or a mesh.
///
///     <shape type="sphere">
///       <point name="center" x="1" y="-2" z="3"/>
///       <float name="radius" value="2"/>
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

constexpr Parameter kTable[] = {
    {"center", ParameterType::kVector, "0 0 0", "Centre, before to_world."},
    {"radius", ParameterType::kFloat, "1", "Radius, before to_world."},
    kToWorld,
    kFlipNormals,
    KINOME_NESTED_IN_SHAPES,
};

class Sphere final : public AnalyticShape<Sphere> {
 public:
  explicit Sphere(const Properties& props) : AnalyticShape(props) {
    const glm::dmat4 to_world = unit_sphere_to_world(props);
    const glm::dmat3 linear(to_world);
    if (!is_similarity(linear)) {
      props.warn("to_world",
                 "scales this sphere unevenly or shears it: as in Mitsuba 3, it stays a sphere, "
                 "whose radius is scaled like the x axis (for an ellipsoid, use an instance of a "
                 "sphere)");
    }
    centre_ = to_world[3];
    radius_ = glm::length(linear[0]);
    per_radius_ = 1 / radius_;
    // A transform that mirrors flips the sphere inside out.
    const bool is_mirrored = glm::determinant(linear) < 0;
    flip_ = props.boolean("flip_normals") != is_mirrored;
    // Orthonormalised, because to_world may have few digits.
    axes_[0] = linear[0] * per_radius_;
    axes_[1] = glm::normalize(linear[1] - axes_[0] * glm::dot(axes_[0], linear[1]));
    axes_[2] = glm::cross(axes_[0], axes_[1]) * (is_mirrored ? -1. : 1.);
    extent_ = glm::length(centre_) + radius_;
  }

  Aabb bounds() const override { return {Vec3(centre_ - radius_), Vec3(centre_ + radius_)}; }

  float area() const override {
    return static_cast<float>(4 * std::numbers::pi * radius_ * radius_);
  }

  std::optional<SurfaceSample> sample_solid_angle(const Vec3& p, const Vec2& u) const override {
    const auto drawn = draw(p, u);
    const SurfaceInteraction si = sampled(surface_at(drawn.outward));
    if (si.p == p) return std::nullopt;
    return SurfaceSample{si, drawn.pdf};
  }
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    wide::for_lanes(count, [&](size_t i) {
      const auto from = wide::Vec3::load(p, i);
      const auto drawn = draw(from, wide::Vec2::load(u, i));
      const auto point = surface_at(drawn.outward);
      store(point.p, out.p, i);
      store(point.frame.n, out.sn, i);
      if (out.uv.x) store(point.uv, out.uv, i);
      const auto is_at_point = point.p.x == from.x && point.p.y == from.y && point.p.z == from.z;
      select(is_at_point, 0.f, drawn.pdf).store(out.pdf + i);
    });
  }

  float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const override {
    return density(p, si.p, si.p_error);
  }
  void pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                             float* pdf) const override {
    wide::for_lanes(points.count, [&](size_t i) {
      density(wide::Vec3::load(p, i), wide::Vec3::load(points.p, i),
              wide::Float::load(points.p_error + i))
          .store(pdf + i);
    });
  }

 private:
  friend class AnalyticShape<Sphere>;

  /// Returns the vector from the centre to p, which has single precision.
  template <class V>
  auto from_centre(const V& p) const {
    const auto exact = to_double(p);
    return exact - decltype(to_double(p))(centre_);
  }

  Vec3 direction_of_normal(const Ray& ray, float t) const {
    return Vec3(from_centre(ray.o) + DVec3(ray.d) * static_cast<double>(t));
  }

  /// A point of the sphere, sampled from p, and its density per solid angle at p.
  template <class D>
  struct Drawn {
    DVecOf<D> outward;
    FloatOf<D> pdf;
  };

  template <class V2>
  ShapePoint<NumberOf<V2>> point_at(const V2& u) const {
    const auto local = to_double(warp::square_to_uniform_sphere<VecOf<NumberOf<V2>>>(u));
    return surface_at(normalize(axes_ * local));
  }

  template <class V, class F>
  F first_hit(const V& o, const V& d, F tmin, F tmax) const {
    const LocalLine<DoubleOf<F>> line{from_centre(o) * DoubleOf<F>(per_radius_),
                                      to_double(d) * DoubleOf<F>(per_radius_)};
    return first_root(unit_ball_roots<3>(line), tmin, tmax, [](const auto&) { return true; });
  }

  template <class V, class F>
  ShapePoint<F> hit_at(const V& o, const V& d, F t) const {
    return surface_at(normalize(from_centre(o) + to_double(d) * to_double(t)));
  }

  /// Returns the point in the unit direction `outward` from the centre, without wi.
  template <class V>
  ShapePoint<FloatOf<NumberOf<V>>> surface_at(const V& outward) const {
    using D = NumberOf<V>;
    constexpr double pi = std::numbers::pi;
    const V local = outward * axes_;  // by the transpose
    const D sin_theta = sqrt(local.x * local.x + local.y * local.y);
    const MaskOf<D> has_angle = sin_theta > 0.0;
    const D cos_phi = select(has_angle, local.x / sin_theta, D(1.0));
    const D sin_phi = select(has_angle, local.y / sin_theta, D(0.0));

    ShapePoint<FloatOf<D>> point;
    point.p = to_float(V(centre_) + outward * D(radius_));
    point.p_error = surface_error(point.p, extent_);
    point.n = to_float(flip_ ? -outward : outward);
    point.uv = {turn(local.x, local.y), to_float(atan2(sin_theta, local.z) / pi)};
    point.dp_du = to_float(axes_ * V(-local.y, local.x, D(0.0)) * D(2 * pi * radius_));
    point.dp_dv =
        to_float(axes_ * V(local.z * cos_phi, local.z * sin_phi, -sin_theta) * D(pi * radius_));
    point.frame = FrameOf<VecOf<FloatOf<D>>>::from_normal_and_tangent(point.n, point.dp_du);
    return point;
  }

  /// Samples uniformly over the solid angle that the sphere subtends: a cone from outside, all
  /// directions from inside.
  template <class V, class V2>
  Drawn<DoubleOf<NumberOf<V>>> draw(const V& p, const V2& u) const {
    using F = NumberOf<V>;
    using D = DoubleOf<F>;
    using DV = DVecOf<D>;
    const DV offset = from_centre(p);
    const D distance = length(offset);
    const MaskOf<D> is_inside = distance <= radius_;
    const D height = select(is_inside, D(2.0), cone_height(distance));
    // The axis points toward the centre; at the centre itself, it is arbitrary.
    const DV axis = select(distance > 0.0, -offset / distance, DV(D(0.0), D(0.0), D(1.0)));
    const D depth = to_double(u.y) * height;  // 1 - cos(theta)
    const D cosine = 1.0 - depth;
    const D sine = sqrt(depth * (2.0 - depth));
    // Angles of the triangle of p, the centre and the sphere's point: at the point, which is obtuse
    // for the near side seen from outside; then at the centre.
    const D sin_point = min(sine * distance / radius_, D(1.0));
    const D cos_point = sqrt(1.0 - sin_point * sin_point) * select(is_inside, D(1.0), D(-1.0));
    const D cos_centre = sine * sin_point - cosine * cos_point;
    const D sin_centre = sine * cos_point + cosine * sin_point;
    const auto frame = FrameOf<VecOf<F>>::from_normal(to_float(axis));
    D sin_phi, cos_phi;
    sincos(2 * std::numbers::pi * to_double(u.x), sin_phi, cos_phi);
    const DV n = (to_double(frame.s) * cos_phi + to_double(frame.t) * sin_phi) * sin_centre -
                 axis * cos_centre;
    return {normalize(n), to_float(1.0 / (2 * std::numbers::pi * height))};
  }

  /// Density of draw(p) at a point of the sphere.
  template <class V, class F>
  F density(const V& p, const V& point, F p_error) const {
    using D = DoubleOf<F>;
    const auto offset = from_centre(p);
    const D distance = length(offset);
    // The far side is never sampled. Rounding may move a point of the silhouette behind it.
    const D beyond = dot(from_centre(point), offset) - radius_ * radius_;
    const MaskOf<D> is_behind = beyond < -4.0 * to_double(p_error) * distance;
    const F outside = to_float(1.0 / (2 * std::numbers::pi * cone_height(distance)));
    return select(distance <= radius_, F(kUniformSpherePdf), select(is_behind, F(0.f), outside));
  }

  /// Returns 1 - cos of the half angle that the sphere subtends from a distance to its centre
  /// larger than its radius. Free of cancellation for any distance.
  template <class D>
  D cone_height(D distance) const {
    const D ratio = radius_ / distance;
    const D cosine = sqrt((distance - radius_) * (distance + radius_)) / distance;
    return ratio * ratio / (1.0 + cosine);
  }

  static glm::dmat4 unit_sphere_to_world(const Properties& props) {
    const float radius = props.real("radius", "must be positive and finite",
                                    [](float r) { return r > 0 && std::isfinite(r); });
    const Vec3 center = props.vector("center");
    if (!is_finite(center)) throw props.error("center", "must be finite");
    const glm::dmat4 local(glm::dvec4(radius, 0, 0, 0), glm::dvec4(0, radius, 0, 0),
                           glm::dvec4(0, 0, radius, 0), glm::dvec4(DVec3(center), 1));
    return glm::dmat4(to_world_of(props).matrix()) * local;
  }

  DVec3 centre_{0.};
  double radius_ = 1, per_radius_ = 1;
  glm::dmat3 axes_;  ///< unit axes of uv
  bool flip_ = false;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Sphere, kinome::Category::kShape, "sphere",
              "A sphere with exact (not triangulated) geometry.", kinome::kTable);
