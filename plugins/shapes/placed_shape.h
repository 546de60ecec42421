#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <vector>

#include "kinome/sampler.h"
#include "kinome/shape.h"
#include "kinome/wide/doubles.h"
#include "kinome/wide/surface_point.h"
#include "kinome/wide/textures.h"

/// A shape of a group, transformed by an instance.
namespace kinome {

using namespace wide::formulas;

/// Affine map from a group's space to world space.
class AffineMap {
 public:
  explicit AffineMap(const Transform& to_world)
      : matrix_(to_world.matrix()),
        inverse_(to_world.inverse_matrix()),
        linear_(matrix_),
        inverse_linear_(inverse_),
        offset_(matrix_[3]),
        inverse_offset_(inverse_[3]) {
    glm::mat3 size, inverse_size;
    for (int column = 0; column < 3; ++column) {
      size[column] = glm::abs(linear_[column]);
      inverse_size[column] = glm::abs(inverse_linear_[column]);
    }
    round_trip_ = size * inverse_size;
    offset_size_ = size * glm::abs(inverse_offset_) + glm::abs(offset_);
    determinant_ = std::abs(glm::determinant(glm::dmat3(linear_)));
    // The Frobenius norm is at least the largest stretch, and at most sqrt(3) times as large.
    for (int column = 0; column < 3; ++column) {
      stretch_ += glm::dot(linear_[column], linear_[column]);
    }
    stretch_ = std::sqrt(stretch_);
  }

  const Mat4& to_world() const { return matrix_; }
  const Mat4& to_group() const { return inverse_; }

  template <class V>
  V ray_origin_in_group(const V& o) const {
    return inverse_linear_ * o + V(inverse_offset_);
  }
  template <class V>
  V ray_direction_in_group(const V& d) const {
    return inverse_linear_ * d;
  }

  /// Maps a point of the group to the scene, for a ray with world direction d. Normals are mapped
  /// by the inverse transpose, also if the map mirrors: the outside stays outside, as in Mitsuba.
  template <class F, class V>
  ShapePoint<F> point_to_world(const ShapePoint<F>& local, const V& d) const {
    ShapePoint<F> point;
    point.p = linear_ * local.p + V(offset_);
    point.p_error = world_error(local.p_error, point.p);
    point.n = safe_normalize(local.n * inverse_linear_, local.n);
    point.dp_du = linear_ * local.dp_du;
    point.dp_dv = linear_ * local.dp_dv;
    const V normal = safe_normalize(local.frame.n * inverse_linear_, point.n);
    point.frame = FrameOf<V>::from_normal_and_tangent(normal, point.dp_du);
    point.uv = local.uv;
    point.wi = point.frame.to_local(safe_normalize(-d, V(F(0.f), F(0.f), F(1.f))));
    return point;
  }

  /// Returns the factor by which the map scales an area with unit normal n (in the group's space).
  double area_ratio(const Vec3& n) const {
    return determinant_ * glm::length(glm::dvec3(n) * glm::dmat3(inverse_linear_));
  }
  /// Upper bound of area_ratio().
  double max_area_ratio() const {
    double sum = 0;
    for (int row = 0; row < 3; ++row) {
      const glm::dvec3 v(inverse_linear_[0][row], inverse_linear_[1][row], inverse_linear_[2][row]);
      sum += glm::dot(v, v);
    }
    return determinant_ * std::sqrt(sum);
  }

 private:
  /// Returns the stretched local bound plus the rounding errors of transforming a ray to the
  /// group's space, as the ray tracer does for each test, and a point back. Each coordinate is a
  /// sum of four products. The terms of both transforms are bounded by round_trip_ |p| +
  /// offset_size_. They are rounded 4 + 4 times, and the ray tracer's own inverse matrix a few
  /// times more: 16 u, doubled.
  template <class F, class V>
  F world_error(const F& local_error, const V& p) const {
    const V terms = round_trip_ * abs(p) + V(offset_size_);
    return stretch_ * local_error + (32 * 0x1p-24f) * length(terms);
  }

  Mat4 matrix_, inverse_;
  glm::mat3 linear_, inverse_linear_;
  Vec3 offset_, inverse_offset_;
  glm::mat3 round_trip_;
  Vec3 offset_size_;
  float stretch_ = 0;
  double determinant_ = 0;
};

/// Computes the interactions of an instance's shape; the ray tracer intersects instances natively.
/// It doesn't emit, so only algorithms that sample all surfaces sample it.
class PlacedShape final : public Shape {
 public:
  PlacedShape(std::shared_ptr<const Shape> shape, std::shared_ptr<const AffineMap> map)
      : shape_(std::move(shape)), map_(std::move(map)) {
    set_bsdf(shape_->bsdf_pointer());
    share_media(*shape_);
    set_id(shape_->id());
    const Aabb local = shape_->bounds();
    for (unsigned i = 0; i < 8; ++i) {
      const glm::dvec4 corner(glm::dvec3(local.corner(i)), 1.);
      bounds_.expand(Vec3(glm::dmat4(map_->to_world()) * corner));
    }
  }

  Aabb bounds() const override { return bounds_; }

  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override {
    Ray local = ray;
    local.o = map_->ray_origin_in_group(ray.o);
    local.d = map_->ray_direction_in_group(ray.d);
    return to_world(shape_->interaction(local, hit), ray.d);
  }

  void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const override {
    using wide::Float;
    thread_local std::vector<RayHit16> local_rays;
    const size_t blocks = padded(out.count) / kBlockLanes;
    if (local_rays.size() < blocks) local_rays.resize(blocks);
    RayHit16* const local = local_rays.data();
    const wide::ScratchColumns scratch(7, out.count);
    auto* const numbers = reinterpret_cast<uint32_t*>(scratch[6]);
    wide::for_lanes(out.count, [&](size_t i) {
      const wide::GatheredRays ray(rays, out.ray + i);
      RayHit16& to = local[i / 16];
      const size_t lane = i % 16;
      map_->ray_origin_in_group(ray.o()).store({to.ray.ox, to.ray.oy, to.ray.oz}, lane);
      map_->ray_direction_in_group(ray.d()).store({to.ray.dx, to.ray.dy, to.ray.dz}, lane);
      ray.tmax().store(to.ray.tmax + lane);
      ray.u().store(to.u + lane);
      ray.v().store(to.v + lane);
      ray.primitive().store(to.primitive + lane);
      (as_uint(wide::iota()) + static_cast<uint32_t>(i)).store(numbers + i);
    });
    // Frames depend on dp_du, also if the caller doesn't request it.
    SurfaceBlock points = out;
    if (!points.dp_du.x) points.dp_du = scratch.three(0);
    if (!points.dp_dv.x) points.dp_dv = scratch.three(3);
    points.ray = numbers;
    shape_->interaction_block(local, points);
    wide::for_lanes(out.count, [&](size_t i) {
      ShapePoint<Float> point;
      point.p = wide::Vec3::load(points.p, i);
      point.p_error = Float::load(points.p_error + i);
      point.n = wide::Vec3::load(points.n, i);
      point.frame.n = wide::Vec3::load(points.sn, i);
      point.dp_du = wide::Vec3::load(points.dp_du, i);
      point.dp_dv = wide::Vec3::load(points.dp_dv, i);
      point.uv = wide::Vec2::load(points.uv, i);
      const wide::GatheredRays ray(rays, out.ray + i);
      store(map_->point_to_world(point, ray.d()), out, i);
    });
  }

  float area() const override { return static_cast<float>(area_data().area); }

  /// Samples uniformly by area: by the area in the group, with rejection in proportion to the map's
  /// area ratio. Further attempt use random numbers that are hashes of u.
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const double max_ratio = area_data().max_ratio;
    SurfaceInteraction si;
    Vec2 sample = u;
    const uint64_t seed = hash_words(std::bit_cast<uint32_t>(u.x), std::bit_cast<uint32_t>(u.y));
    for (uint32_t attempt = 0; attempt < kMaxAttempts; ++attempt) {
      si = shape_->sample_surface(sample);
      const float keep = random_number(seed, 3 * attempt);
      if (static_cast<double>(keep) * max_ratio <= map_->area_ratio(si.n)) break;
      sample = {random_number(seed, 3 * attempt + 1), random_number(seed, 3 * attempt + 2)};
    }
    si = to_world(si, Vec3(0, 0, -1));
    si.shape = this;
    return si;
  }

  std::optional<AttributeArrays> attribute(const std::string& name) const override {
    auto arrays = shape_->attribute(name);
    if (arrays) arrays->to_mesh = map_->to_group();
    return arrays;
  }

 private:
  /// An attempt is accepted with a probability of at least 1/3, unless the map flattens strongly.
  static constexpr uint32_t kMaxAttempts = 1000;
  struct AreaData {
    double area = 0, max_ratio = 0;
  };

  static float random_number(uint64_t seed, uint32_t k) {
    return to_unit_float(static_cast<uint32_t>(hash_words(seed, k)));
  }

  SurfaceInteraction to_world(const SurfaceInteraction& local, const Vec3& d) const {
    const ShapePoint<float> point{local.p,     local.p_error, local.n,  local.frame,
                                  local.dp_du, local.dp_dv,   local.uv, local.wi};
    SurfaceInteraction si = wide::interaction_of(map_->point_to_world(point, d));
    si.t = local.t;
    si.primitive = local.primitive;
    return si;
  }

  /// Exact for meshes. For other shapes, whose normals vary smoothly with the sample, an estimate
  /// from the midpoints of a grid. Computed on demand, because few integrators need it.
  const AreaData& area_data() const {
    std::call_once(area_made_, [&] {
      double sum = 0, weight = 0;
      const auto add = [&](const Vec3& n, double area) {
        const double ratio = map_->area_ratio(n);
        sum += area * ratio, weight += area;
        area_.max_ratio = std::max(area_.max_ratio, ratio);
      };
      if (const TriangleMesh* const mesh = shape_->mesh()) {
        for (const glm::uvec3& t : mesh->triangles) {
          const glm::dvec3 p(mesh->positions[t.x]);
          const glm::dvec3 cross = glm::cross(glm::dvec3(mesh->positions[t.y]) - p,
                                              glm::dvec3(mesh->positions[t.z]) - p);
          const double length = glm::length(cross);
          if (length > 0) add(Vec3(cross / length), length / 2);
        }
        area_.area = sum;
      } else {
        constexpr int kGrid = 64;
        for (int k = 0; k < kGrid * kGrid; ++k) {
          const Vec2 u((k % kGrid + 0.5f) / kGrid, (k / kGrid + 0.5f) / kGrid);
          add(shape_->sample_surface(u).n, 1);
        }
        area_.area = weight > 0 ? shape_->area() * (sum / weight) : 0;
        area_.max_ratio = std::min(area_.max_ratio * 1.01, map_->max_area_ratio());
      }
    });
    return area_;
  }

  std::shared_ptr<const Shape> shape_;
  std::shared_ptr<const AffineMap> map_;
  Aabb bounds_;
  mutable std::once_flag area_made_;
  mutable AreaData area_;
};

}  // namespace kinome
