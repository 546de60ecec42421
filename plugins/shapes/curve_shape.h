#pragma once

#include <cmath>

#include "curve_file.h"
#include "kinome/plugin.h"
#include "kinome/shape.h"
#include "kinome/wide/mesh.h"
#include "local_space.h"
#include "shape_parameters.h"

/// Curves that the ray tracer intersects natively. It returns the segment and the parameter along
/// it; interactions are computed from the control points.
namespace kinome {

inline constexpr Parameter kCurveParameters[] = {
    {"filename", ParameterType::kFile, nullptr,
     "Text file with x, y, z and radius of one control point per line; blank lines separate "
     "curves.",
     true},
    {"to_world", ParameterType::kTransform, "identity",
     "Transform from object to world space; doesn't affect radii."},
    kNestedBsdf,
    named_object("interior", Category::kMedium, "An error: rays hit curves only from outside."),
    kExterior,
};

/// Centre and radius at a position along a segment, and their derivatives by this position.
template <class F>
struct CurvePoint {
  VecOf<F> centre, d_centre, dd_centre;
  F radius, d_radius;
};

template <class F>
KINOME_WIDE CurvePoint<F> linear_point(const float* points, const IntOf<F>& first, const F& along) {
  using V = VecOf<F>;
  const V a = wide::gather3(points, first), b = wide::gather3(points, first + 4);
  const F ra = gather(points + 3, first), rb = gather(points + 7, first);
  return {a * (1.f - along) + b * along, b - a, V(F(0.f)), ra * (1.f - along) + rb * along,
          rb - ra};
}

/// Uniform cubic B-splines (de Boor 1978).
template <class F>
KINOME_WIDE CurvePoint<F> bspline_point(const float* points, const IntOf<F>& first,
                                        const F& along) {
  using V = VecOf<F>;
  const F u = along, v = 1.f - along;
  const F weights[4] = {v * v * v * (1.f / 6), (4.f - 3.f * u * u * (1.f + v)) * (1.f / 6),
                        (4.f - 3.f * v * v * (1.f + u)) * (1.f / 6), u * u * u * (1.f / 6)};
  const F slopes[4] = {v * v * -0.5f, u * (1.5f * u - 2.f), v * (2.f - 1.5f * v), u * u * 0.5f};
  const F bends[4] = {v, 3.f * u - 2.f, 3.f * v - 2.f, u};
  CurvePoint<F> at{V(F(0.f)), V(F(0.f)), V(F(0.f)), F(0.f), F(0.f)};
  for (int32_t k = 0; k < 4; ++k) {
    const V p = wide::gather3(points + 4 * k, first);
    const F r = gather(points + 4 * k + 3, first);
    at.centre = at.centre + p * weights[k];
    at.d_centre = at.d_centre + p * slopes[k];
    at.dd_centre = at.dd_centre + p * bends[k];
    at.radius = at.radius + r * weights[k];
    at.d_radius = at.d_radius + r * slopes[k];
  }
  return at;
}

/// u goes around a curve, from 0 to 1. v goes along all segments of the file, in equal steps. With
/// z up, u = 0 is the horizontal direction to the right of the curve's direction.
template <bool is_bspline>
class CurveShape : public Shape {
 public:
  explicit CurveShape(const Properties& props) : Shape(props) {
    if (interior()) {
      throw props.error("interior",
                        "isn't possible for curves, because rays hit them only from outside: "
                        "remove the medium (or the BSDF that defines it), or use a mesh");
    }
    const std::string file = props.file("filename");
    curves_ = CurveFileReader(file, file_contents(file), is_bspline).read(to_world_of(props));
    for (const glm::vec4& point : curves_.points) {
      bounds_.expand(Vec3(point) - point.w);
      bounds_.expand(Vec3(point) + point.w);
    }
    if (!is_finite(bounds_.lo) || !is_finite(bounds_.hi)) {
      throw props.error("to_world", "moves a control point beyond the range of float");
    }
    per_segment_ = 1 / static_cast<float>(curves_.segments.size());
  }

  const CurveSet* curves() const override { return &curves_; }
  Aabb bounds() const override { return bounds_; }

  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override {
    SurfaceInteraction si = wide::interaction_of(
        point_at<float>(static_cast<int32_t>(hit.primitive), hit.u, ray.o, ray.d, ray.tmax));
    si.t = ray.tmax;
    si.primitive = hit.primitive;
    return si;
  }
  void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const override {
    wide::for_lanes(out.count, [&](size_t i) {
      const wide::GatheredRays ray(rays, out.ray + i);
      const wide::Uint primitive = ray.primitive();
      store(point_at<wide::Float>(as_int(primitive), ray.u(), ray.o(), ray.d(), ray.tmax()), out,
            i);
      primitive.store(out.primitive + i);
    });
  }

  /// As in Mitsuba, curves don't emit and aren't sampled.
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override {
    SurfaceInteraction si;
    si.p = Vec3(curves_.points[0]);
    return si;
  }

 private:
  template <class F>
  ShapePoint<F> point_at(const IntOf<F>& segment, const F& along, const VecOf<F>& o,
                         const VecOf<F>& d, const F& t) const {
    using V = VecOf<F>;
    const IntOf<F> first = as_int(gather(curves_.segments.data(), segment)) * 4;
    const CurvePoint<F> at = is_bspline ? bspline_point<F>(&curves_.points[0].x, first, along)
                                        : linear_point<F>(&curves_.points[0].x, first, along);
    const V up(F(0.f), F(0.f), F(1.f));
    const V axis = safe_normalize(at.d_centre, up);
    const V viewer = wide::formulas::opposite_of(d);
    const V out = facing_out(at, axis, safe_normalize(o + d * t - at.centre, up), viewer);

    ShapePoint<F> point;
    // Computed from the centre line, which removes the ray tracer's error.
    point.p = at.centre + out * at.radius;
    point.p_error = surface_error(point.p, 0) + 2e-5f * at.radius;
    const V level = cross(axis, up);
    const F length2 = dot(level, level);
    const MaskOf<F> is_upright = !(length2 > 0.f);
    const V right = select(is_upright, V(select(axis.z > 0.f, F(1.f), F(-1.f)), F(0.f), F(0.f)),
                           level * (-1.f / sqrt(length2)));
    const V rise = select(is_upright, V(F(0.f), F(1.f), F(0.f)), cross(axis, right));
    point.uv = {turn_of(dot(out, right), dot(out, rise)),
                (along + to_float(segment)) * per_segment_};
    if constexpr (is_bspline) {
      const F speed = sqrt(dot(at.d_centre, at.d_centre));
      const F bend = at.radius * dot(out, at.dd_centre);
      point.n = normal_of(at, axis, out);
      point.dp_du = cross(axis, out) * (2 * kPi * at.radius);
      // The reference direction of the angle rotates along the curve.
      const V d_axis = (at.dd_centre - axis * dot(axis, at.dd_centre)) / speed;
      const F twist = select(is_upright, F(0.f), dot(d_axis, right) * axis.z / sqrt(length2));
      point.dp_dv = (at.d_centre - axis * (bend / speed) + out * at.d_radius +
                     cross(axis, out) * (at.radius * twist)) /
                    F(per_segment_);
      point.frame = FrameOf<V>::from_normal_and_tangent(point.n, point.dp_du);
    } else {
      // `along` is the position of the sphere that touches the cone at the hit. As in Mitsuba,
      // there are no derivatives, and the tangents are arbitrary.
      point.n = out;
      point.frame = FrameOf<V>::from_normal(out);
      point.dp_du = point.dp_dv = V(F(0.f));
    }
    point.wi = point.frame.to_local(viewer);
    return point;
  }
  /// Normal of the surface in the direction `out` from the centre line.
  template <class F, class V>
  static V normal_of(const CurvePoint<F>& at, const V& axis, const V& out) {
    // Spheres touch cones at their normals.
    if constexpr (!is_bspline) return out;
    const F speed2 = dot(at.d_centre, at.d_centre);
    const F bend = at.radius * dot(out, at.dd_centre);
    return safe_normalize(out * (speed2 - bend) - axis * (sqrt(speed2) * at.d_radius), out);
  }
  /// Returns `out` if the surface there faces the viewer, otherwise a direction that barely does.
  /// Rays may hit thin curves beyond their silhouettes, because the ray tracer's error is
  /// proportional to the length of the segments, not to the radius.
  template <class F, class V>
  static V facing_out(const CurvePoint<F>& at, const V& axis, const V& out, const V& viewer) {
    constexpr float kMinCosine = 1e-3f;
    // Directions out of a spline are perpendicular to its axis.
    const V side =
        is_bspline ? safe_normalize(viewer - axis * dot(axis, viewer), viewer) : viewer;
    const F cosine = dot(out, side);
    const auto faces = dot(normal_of(at, axis, out), viewer) > kMinCosine || cosine > kMinCosine;
    return select(faces, out, normalize(out + side * (kMinCosine - cosine)));
  }
  template <class F>
  static F turn_of(const F& x, const F& y) {
    return turn(to_double(x), to_double(y));
  }

  CurveSet curves_;
  Aabb bounds_;
  float per_segment_ = 1;
};

}  // namespace kinome
