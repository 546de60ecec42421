#pragma once

// Surface points of meshes as formulas over F, and the base class of meshes with block functions.
// Compiled in each plugin, for its instruction set.

#include <cstring>

#include "kinome/mesh_shape.h"
#include "kinome/shape.h"
#include "kinome/wide/distribution.h"
#include "kinome/wide/doubles.h"
#include "kinome/wide/surface_point.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Copies `n` consecutive values of each lane to memory.
template <size_t n>
KINOME_WIDE void copy_rows(const float* from, Int i, float* values) {
  alignas(kColumnAlignment) int32_t at[kLanes];
  i.store(at);
  for (size_t lane = 0; lane < kLanes; ++lane) {
    std::memcpy(values + n * lane, from + at[lane], n * sizeof(float));
  }
}
/// Loads three (or two) consecutive values in each lane. The version for three also reads a fourth
/// value. Loads and a transposition are faster than a gather per value.
KINOME_WIDE Vec3 gather3(const float* from, Int i) {
  if (kIsPlain) return {gather(from, i), gather(from + 1, i), gather(from + 2, i)};
  alignas(kColumnAlignment) float values[4 * kLanes];
  copy_rows<4>(from, i, values);
  Vec3 v;
  Float unused;
  load_rows(values, v.x, v.y, v.z, unused);
  return v;
}
KINOME_WIDE Vec2 gather2(const float* from, Int i) {
  if (kIsPlain) return {gather(from, i), gather(from + 1, i)};
  alignas(kColumnAlignment) float values[2 * kLanes];
  copy_rows<2>(from, i, values);
  return Vec2::load_interleaved(values);
}

inline namespace formulas {

KINOME_WIDE glm::vec3 gather3(const float* from, std::same_as<int32_t> auto i) {
  return {from[i], from[i + 1], from[i + 2]};
}
KINOME_WIDE glm::vec2 gather2(const float* from, std::same_as<int32_t> auto i) {
  return {from[i], from[i + 1]};
}

/// Normal direction of a triangle with edges e1 and e2, not normalised; edges are scaled to a
/// length of about 1. Zero for a degenerate triangle.
template <class V>
KINOME_WIDE V face_direction(const V& e1, const V& e2) {
  const auto scale = max(max_component(abs(e1)), max_component(abs(e2)));
  return select(scale > 0.f, cross(e1 / scale, e2 / scale));
}

/// Unit normal of a triangle with edges e1 and e2; `fallback` if it is degenerate.
template <class V>
KINOME_WIDE V face_normal(const V& e1, const V& e2, const V& fallback) {
  const V normal = cross(e1, e2);
  const auto length2 = dot(normal, normal);
  const auto is_normal_number = length2 > 1e-20f && length2 < 1e20f;
  const V unit = normal / sqrt(length2);
  if (all(is_normal_number)) return unit;
  return select(is_normal_number, unit, safe_normalize(face_direction(e1, e2), fallback));
}

/// Bound on the distance of a computed point, and of the origins of rays that leave it, from the
/// triangle's plane.
///
/// Let u = 2^-24, and M the largest coordinate of the vertices. b0 = 1 - b1 - b2 has an error of at
/// most 2u, and the three products and two sums of at most gamma_3 M. The moved origin is rounded
/// once more (u). So each coordinate has an error below 7 u M, and the distance one of sqrt(3)
/// times that: < 13 u M.
///
/// Embree's intersection test subtracts the origin from the vertices and evaluates two dot products
/// of three terms. Its relative error is below 8u of the distance to the vertices, with the normal
/// taken as exact. That distance is at most sqrt(3) E and 2 sqrt(3) M, where E is the longest side
/// of the mesh's bounds.
///
/// Twice the sum covers the omitted third-order terms. At M = 1 it is at most 5e-6, twenty times
/// smaller than a fixed 1e-4. For a small mesh far away, it is three times smaller than for one
/// that extends from there to the origin. It is no bound for an adjacent triangle with much larger
/// coordinates.
template <class V>
KINOME_WIDE auto plane_error(const V& p0, const V& p1, const V& p2, float side) {
  const auto largest = max(max(max_component(abs(p0)), max_component(abs(p1))),
                           max_component(abs(p2)));
  return 0x1p-24f * (26.f * largest + min(56.f * largest, decltype(largest)(28.f * side)));
}

/// Uniform barycentric coordinates u and v in a triangle. Folds the square along its diagonal,
/// which preserves neighbourhoods (Heitz 2019, "A low-distortion map between triangle and square").
template <class V2>
KINOME_WIDE V2 square_to_triangle(const V2& u) {
  const auto half = min(u.x, u.y) / 2.f;
  const auto is_right = u.x > u.y;
  return {select(is_right, u.x - half, half), select(is_right, half, u.y - half)};
}

template <class V>
struct PartialDerivatives {
  V du, dv;
};

/// Partial derivatives of the position by uv: solves du duv_i.x + dv duv_i.y = e_i. Returns a frame
/// around n if uv is degenerate.
template <class V, class V2>
KINOME_WIDE PartialDerivatives<V> position_derivatives(const V& e1, const V& e2, const V2& duv1,
                                                       const V2& duv2, const V& n) {
  using F = NumberOf<V>;
  using D = DoubleOf<F>;
  // Double precision is needed because the texture coordinates of neighbours may differ only in the
  // last bits.
  const D u1 = to_double(duv1.x), v1 = to_double(duv1.y);
  const D u2 = to_double(duv2.x), v2 = to_double(duv2.y);
  const D det = u1 * v2 - v1 * u2;
  const D inverse = 1.0 / det;
  const auto solve = [&](F a, F b) {
    const D x = to_double(a), y = to_double(b);
    return PartialDerivatives<F>{to_float((x * v2 - y * v1) * inverse),
                                 to_float((y * u1 - x * u2) * inverse)};
  };
  const auto x = solve(e1.x, e2.x), y = solve(e1.y, e2.y), z = solve(e1.z, e2.z);
  const V du(x.du, y.du, z.du), dv(x.dv, y.dv, z.dv);
  const MaskOf<F> is_regular = det != 0.0 && is_finite(du) && is_finite(dv);
  if (all(is_regular)) return {du, dv};
  const auto frame = FrameOf<VecOf<F>>::from_normal(n);
  return {select(is_regular, du, frame.s), select(is_regular, dv, frame.t)};
}

/// Data shared by all points of a triangle.
template <class F>
struct Triangle {
  using V = VecOf<F>;
  V p0, p1, p2;
  F p_error;
  V n;
  PartialDerivatives<V> dp;
  Vec2Of<F> uv0, uv1, uv2;  ///< set if the mesh has uvs
  V n0, n1, n2;             ///< shading normals; set if the mesh has normals
  FrameOf<V> frame;         ///< shading frame; set otherwise
  MaskOf<F> is_degenerate;  ///< n of a degenerate triangle faces the ray
};

/// Loads a triangle. `first` is three times its index; `backward` is the unit vector toward the
/// ray's origin.
template <class F>
KINOME_WIDE Triangle<F> triangle_of(const MeshArrays& mesh, IntOf<F> first,
                                    const VecOf<F>& backward) {
  using V = VecOf<F>;
  const IntOf<F> i0 = as_int(gather(mesh.triangles, first));
  const IntOf<F> i1 = as_int(gather(mesh.triangles + 1, first));
  const IntOf<F> i2 = as_int(gather(mesh.triangles + 2, first));
  const IntOf<F> k0 = i0 * 3, k1 = i1 * 3, k2 = i2 * 3;
  Triangle<F> t;
  t.p0 = gather3(mesh.positions, k0);
  t.p1 = gather3(mesh.positions, k1);
  t.p2 = gather3(mesh.positions, k2);
  const V e1 = t.p1 - t.p0, e2 = t.p2 - t.p0;
  t.p_error = plane_error(t.p0, t.p1, t.p2, mesh.side);
  t.n = face_normal(e1, e2, V(F(0.f)));
  t.is_degenerate = is_black(t.n);
  if (any(t.is_degenerate)) t.n = select(t.is_degenerate, backward, t.n);
  if (mesh.flip) t.n = -t.n;
  if (mesh.uvs) {
    t.uv0 = gather2(mesh.uvs, i0 * 2);
    t.uv1 = gather2(mesh.uvs, i1 * 2);
    t.uv2 = gather2(mesh.uvs, i2 * 2);
    t.dp = position_derivatives(e1, e2, t.uv1 - t.uv0, t.uv2 - t.uv0, t.n);
  } else {
    t.dp = {e1, e2};
  }
  if (mesh.normals) {
    t.n0 = gather3(mesh.normals, k0);
    t.n1 = gather3(mesh.normals, k1);
    t.n2 = gather3(mesh.normals, k2);
  } else {
    t.frame = FrameOf<V>::from_normal_and_tangent(t.n, t.dp.du);
  }
  return t;
}

/// Returns the point with barycentric coordinates b1, b2.
template <class F>
KINOME_WIDE ShapePoint<F> point_of(const MeshArrays& mesh, const Triangle<F>& t, F b1, F b2,
                                   const VecOf<F>& backward) {
  const F b0 = 1.f - b1 - b2;
  ShapePoint<F> point;
  point.p = b0 * t.p0 + b1 * t.p1 + b2 * t.p2;
  point.p_error = t.p_error;
  point.n = t.n;
  point.uv = mesh.uvs ? b0 * t.uv0 + b1 * t.uv1 + b2 * t.uv2 : Vec2Of<F>(b1, b2);
  point.dp_du = t.dp.du;
  point.dp_dv = t.dp.dv;
  if (mesh.normals) {
    const VecOf<F> shading_normal = safe_normalize(b0 * t.n0 + b1 * t.n1 + b2 * t.n2, t.n);
    point.frame = FrameOf<VecOf<F>>::from_normal_and_tangent(shading_normal, t.dp.du);
  } else {
    point.frame = t.frame;
  }
  point.wi = point.frame.to_local(backward);
  return point;
}

template <class V>
KINOME_WIDE V opposite_of(const V& d) {
  using F = NumberOf<V>;
  return safe_normalize(-d, V(F(0.f), F(0.f), F(1.f)));
}

}  // namespace formulas

/// Computes points of a mesh, vector by vector. Reuses the data of the triangles while all lanes
/// stay on the same ones, as on large triangles.
class MeshPoints {
 public:
  KINOME_WIDE explicit MeshPoints(const MeshArrays& mesh) : mesh_(mesh) {}

  /// Returns points at b1, b2 on triangles `which`, seen along d.
  KINOME_WIDE formulas::ShapePoint<Float> make(Int which, Float b1, Float b2, const Vec3& d) {
    const Vec3 backward = formulas::opposite_of(d);
    if (!all(which == known_)) {
      triangle_ = formulas::triangle_of<Float>(mesh_, which * 3, backward);
      known_ = any(triangle_.is_degenerate) ? Int(-1) : which;
    }
    return formulas::point_of(mesh_, triangle_, b1, b2, backward);
  }

 private:
  const MeshArrays& mesh_;
  formulas::Triangle<Float> triangle_;
  Int known_ = -1;
};

/// Base class of meshes in plugins that are compiled for several instruction sets.
class Mesh : public MeshShape {
 public:
  void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const override {
    const MeshArrays mesh = arrays();
    MeshPoints points(mesh);
    for_lanes(out.count, [&](size_t i) {
      const GatheredRays ray(rays, out.ray + i);
      const Uint primitive = ray.primitive();
      store(points.make(as_int(primitive), ray.u(), ray.v(), ray.d()), out, i);
      primitive.store(out.primitive + i);
    });
  }
  void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const override {
    const GridDistribution& triangles = area_distribution();
    const GridDistribution::Tables tables = triangles.tables();
    const bool has_area = triangles.total() > 0;
    const MeshArrays mesh = arrays();
    MeshPoints points(mesh);
    for_lanes(out.count, [&](size_t i) {
      Vec2 in_cell = Vec2::load(u, i);
      Int triangle = 0;
      if (has_area) {
        in_cell = {unit_number(in_cell.x), unit_number(in_cell.y)};
        triangle = find_cell(tables.column_cdf, 0, tables.column_guide, 0,
                             tables.column_guide_size, in_cell.x);
      }
      // As sampled_at().
      const Vec2 at = formulas::square_to_triangle(in_cell);
      store(points.make(triangle, at.x, at.y, Vec3(Ray{}.d)), out, i);
      triangle.store(out.primitive + i);
    });
  }
  void pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                             float* pdf) const override {
    store_solid_angle_densities(p, points, area(), pdf);
  }

 protected:
  using MeshShape::MeshShape;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
