/// A cylinder without caps, visible from outside and inside. u is the angle around the axis divided
/// by 2 pi; v goes from 0 at p0 to 1 at p1. As in Mitsuba 3, the angle starts at the first axis of
/// the frame of Duff et al. 2017 around p1 - p0. A to_world that scales unevenly across the axis or
/// shears makes the cylinder elliptic or oblique, as in Mitsuba 3, with a warning.
///
///     <shape type="cylinder">
///       <point name="p0" value="0, 0, -1"/>
///       <point name="p1" value="0, 0, 1"/>
///       <float name="radius" value="0.3"/>
///     </shape>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "analytic_shape.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"p0", ParameterType::kVector, "0 0 0", "First end of the axis, before to_world."},
    {"p1", ParameterType::kVector, "0 0 1", "Second end of the axis, before to_world."},
    {"radius", ParameterType::kFloat, "1", "Radius, before to_world."},
    kToWorld,
    kFlipNormals,
    KINOME_NESTED_IN_SHAPES,
};

class Cylinder final : public AnalyticShape<Cylinder> {
 public:
  explicit Cylinder(const Properties& props)
      : AnalyticShape(props), space_(unit_cylinder_to_world(props)) {
    const glm::dmat3& m = space_.linear();
    if (!is_similarity(m, 2)) {
      props.warn("to_world",
                 "scales this cylinder unevenly across its axis or shears it, which makes it "
                 "elliptic or oblique, as in Mitsuba 3");
      find_area_shares();
    }
    sign_ = props.boolean("flip_normals") ? -1 : 1;
    // Extent of the end circles along each axis, as for a disk.
    const DVec3 reach = glm::sqrt(m[0] * m[0] + m[1] * m[1]);
    for (const DVec3& end : {space_.offset(), space_.offset() + m[2]}) {
      bounds_.expand(Vec3(end - reach));
      bounds_.expand(Vec3(end + reach));
    }
    extent_ = max_component(glm::max(glm::abs(bounds_.lo), glm::abs(bounds_.hi)));
  }

  Aabb bounds() const override { return bounds_; }

  float area() const override {
    if (!area_shares_.empty()) return static_cast<float>(area_shares_.back());
    const glm::dmat3& m = space_.linear();
    return static_cast<float>(2 * std::numbers::pi * glm::length(m[0]) * glm::length(m[2]));
  }

 private:
  friend class AnalyticShape<Cylinder>;

  Vec3 direction_of_normal(const Ray& ray, float t) const {
    const auto local = space_.to_local(ray.o, ray.d);
    const DVec3 p = local.o + local.d * static_cast<double>(t);
    return Vec3(space_.normal_to_world(DVec3(p.x, p.y, 0)) * sign_);
  }

  template <class V2>
  ShapePoint<NumberOf<V2>> point_at(const V2& u) const {
    using D = DoubleOf<NumberOf<V2>>;
    D sine, cosine;
    sincos(2 * std::numbers::pi * to_double(turn_of_area(u.x)), sine, cosine);
    return surface_at(normalize(DVecOf<D>(cosine, sine, D(0.0))), to_double(u.y));
  }

  template <class V, class F>
  F first_hit(const V& o, const V& d, F tmin, F tmax) const {
    const auto line = space_.to_local(o, d);
    return first_root(unit_ball_roots<2>(line), tmin, tmax, [&](const auto& at) {
      const auto z = line.o.z + at * line.d.z;
      return z >= 0.0 && z <= 1.0;
    });
  }

  template <class V, class F>
  ShapePoint<F> hit_at(const V& o, const V& d, F t) const {
    using D = DoubleOf<F>;
    const auto line = space_.to_local(o, d);
    const auto hit = line.o + line.d * to_double(t);
    const D r = sqrt(hit.x * hit.x + hit.y * hit.y);
    return surface_at(DVecOf<D>(hit.x / r, hit.y / r, D(0.0)), hit.z);
  }

  /// Returns the point of the unit cylinder at `z` in the unit direction `radial` from its axis,
  /// without wi.
  template <class V, class D>
  ShapePoint<FloatOf<D>> surface_at(const V& radial, D z) const {
    constexpr double two_pi = 2 * std::numbers::pi;
    ShapePoint<FloatOf<D>> point;
    point.p = to_float(space_.point_to_world(V(radial.x, radial.y, z)));
    point.p_error = surface_error(point.p, extent_);
    point.n = to_float(space_.normal_to_world(radial) * sign_);
    point.uv = {turn(radial.x, radial.y), to_float(min(max(z, D(0.0)), D(1.0)))};
    point.dp_du = to_float(space_.vector_to_world(V(-radial.y, radial.x, D(0.0)) * two_pi));
    point.dp_dv = to_float(space_.vector_to_world(V(D(0.0), D(0.0), D(1.0))));
    point.frame = FrameOf<VecOf<FloatOf<D>>>::from_normal_and_tangent(point.n, point.dp_du);
    return point;
  }
  /// Returns the area per radian of a strip along the axis, at this fraction of a turn.
  double strip_area(double turn) const {
    const double phi = 2 * std::numbers::pi * turn;
    const glm::dmat3& m = space_.linear();
    return glm::length(glm::cross(m[1] * std::cos(phi) - m[0] * std::sin(phi), m[2]));
  }
  /// Computes the cumulative area at multiples of 1 / kStrips of a turn, by Simpson's rule.
  void find_area_shares() {
    constexpr double step = 2 * std::numbers::pi / kStrips;
    double sum = 0;
    area_shares_.assign(1, 0.);
    for (int k = 0; k < kStrips; ++k) {
      const auto at = [&](double offset) { return strip_area((k + offset) / kStrips); };
      sum += step * (at(0) + 4 * at(0.5) + at(1)) / 6;
      area_shares_.push_back(sum);
    }
  }
  /// Returns the fraction of a turn that covers a fraction u of the area. Between entries of the
  /// table, the strips' area is interpolated linearly. The error is about (2 k / 1000)² / 12 where
  /// the ellipse has the largest curvature; k is the ratio of its axes.
  float turn_of_area(float u) const {
    if (area_shares_.empty()) return u;
    const double area = static_cast<double>(u) * area_shares_.back();
    const auto next = std::upper_bound(area_shares_.begin() + 1, area_shares_.end() - 1, area);
    const auto k = static_cast<int>(next - area_shares_.begin()) - 1;
    const double rest = std::min((area - next[-1]) / (next[0] - next[-1]), 1.);
    const double a = strip_area(static_cast<double>(k) / kStrips);
    const double b = strip_area(static_cast<double>(k + 1) / kStrips);
    const double within = rest * (a + b) / (a + std::sqrt(a * a * (1 - rest) + b * b * rest));
    return static_cast<float>((k + within) / kStrips);
  }
  wide::Float turn_of_area(const wide::Float& u) const {
    if (area_shares_.empty()) return u;
    alignas(kColumnAlignment) float turns[wide::kLanes];
    u.store(turns);
    for (float& turn : turns) turn = turn_of_area(turn);
    return wide::Float::load(turns);
  }

  static glm::dmat4 unit_cylinder_to_world(const Properties& props) {
    const Vec3 p0 = props.vector("p0");
    const Vec3 p1 = props.vector("p1");
    if (!is_finite(p0)) throw props.error("p0", "must be finite");
    if (!is_finite(p1)) throw props.error("p1", "must be finite");
    const DVec3 axis = DVec3(p1) - DVec3(p0);
    const double length = glm::length(axis);
    if (!(length > 0)) throw props.error("p1", "must differ from p0");
    const float radius = props.real("radius", "must be positive and finite",
                                    [](float r) { return r > 0 && std::isfinite(r); });
    const auto frame = FrameOf<DVec3>::from_normal(axis / length);
    const double r = radius;
    const glm::dmat4 local(glm::dvec4(frame.s * r, 0), glm::dvec4(frame.t * r, 0),
                           glm::dvec4(axis, 0), glm::dvec4(DVec3(p0), 1));
    return glm::dmat4(to_world_of(props).matrix()) * local;
  }

  static constexpr int kStrips = 4096;

  std::vector<double> area_shares_;  ///< cumulative area; empty if it is proportional to the angle
  LocalSpace space_;                 ///< space of the cylinder of radius 1 from z = 0 to z = 1
  double sign_ = 1;
  Aabb bounds_;
  double extent_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Cylinder, kinome::Category::kShape, "cylinder", "A cylinder without caps.",
              kinome::kTable);
