#pragma once

#include "kinome/shape.h"
#include "local_space.h"

namespace kinome {

/// Base of shapes that are intersected by a formula. Implements intersection, interactions and
/// sampling for single points and for blocks. `Derived`, a final class, must provide these
/// functions, which may be private if this class is a friend:
///
///     F first_hit(const V& o, const V& d, F tmin, F tmax) const     in [tmin, tmax], or infinity
///     ShapePoint<F> hit_at(const V& o, const V& d, F t) const       without wi
///     ShapePoint<F> point_at(const V2& u) const                     uniform by area, without wi
///     Vec3 direction_of_normal(const Ray& ray, float t) const       not normalised
///
/// F, V and V2 are float, Vec3 and Vec2 for one ray, or wide::Float and so on for a vector of rays.
/// Sampling by solid angle samples uniformly by area, unless a shape overrides those functions.
template <class Derived>
class AnalyticShape : public Shape {
 public:
  using Shape::Shape;

  bool intersect(const Ray& ray, float& t, Hit& hit) const final {
    t = self().first_hit(ray.o, ray.d, ray.tmin, ray.tmax);
    if (!(t < kInfinity)) return false;
    hit.ng = self().direction_of_normal(ray, t);
    hit.u = 0;
    hit.v = 0;
    return true;
  }

  void intersect_block(const Ray16& rays, const int* valid, ShapeHit16& out) const final {
    using wide::Float;
    for (size_t i = 0; i < 16; i += wide::kLanes) {
      const wide::Mask is_on = wide::Int::load(valid + i) != 0;
      Float t = kInfinity;
      if (any(is_on)) {
        const wide::Vec3 o(Float::load(rays.ox + i), Float::load(rays.oy + i),
                           Float::load(rays.oz + i));
        const wide::Vec3 d(Float::load(rays.dx + i), Float::load(rays.dy + i),
                           Float::load(rays.dz + i));
        t = select(is_on,
                   self().first_hit(o, d, Float::load(rays.tmin + i), Float::load(rays.tmax + i)),
                   t);
      }
      t.store(out.t + i);
      Float(0.f).store(out.u + i);
      Float(0.f).store(out.v + i);
      wide::Uint(0u).store(out.primitive + i);
    }
  }

  SurfaceInteraction interaction(const Ray& ray, const Hit& /*hit*/) const final {
    auto at = self().hit_at(ray.o, ray.d, ray.tmax);
    at.wi = at.frame.to_local(glm::normalize(-ray.d));
    SurfaceInteraction si = wide::interaction_of(at);
    si.t = ray.tmax;
    return si;
  }

  void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const final {
    wide::for_lanes(out.count, [&](size_t i) {
      const wide::GatheredRays ray(rays, out.ray + i);
      const wide::Vec3 d = ray.d();
      auto at = self().hit_at(ray.o(), d, ray.tmax());
      at.wi = at.frame.to_local(normalize(-d));
      store(at, out, i);
      wide::Uint(0u).store(out.primitive + i);
    });
  }

  SurfaceInteraction sample_surface(const Vec2& u) const final {
    return sampled(self().point_at(u));
  }
  void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const final {
    wide::for_lanes(out.count, [&](size_t i) {
      auto point = self().point_at(wide::Vec2::load(u, i));
      point.wi = wide::Vec3(0.f);
      store(point, out, i);
      wide::Uint(0u).store(out.primitive + i);
    });
  }
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    const float whole = area();
    wide::for_lanes(count, [&](size_t i) {
      const auto point = self().point_at(wide::Vec2::load(u, i));
      store(point.p, out.p, i);
      store(point.frame.n, out.sn, i);
      if (out.uv.x) store(point.uv, out.uv, i);
      solid_angle_density(point.p - wide::Vec3::load(p, i), point.n, whole).store(out.pdf + i);
    });
  }
  void pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                             float* pdf) const override {
    wide::store_solid_angle_densities(p, points, area(), pdf);
  }

 protected:
  SurfaceInteraction sampled(const ShapePoint<float>& point) const {
    SurfaceInteraction si = wide::interaction_of(point);
    si.wi = Vec3(0.f);
    si.shape = this;
    return si;
  }

 private:
  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

}  // namespace kinome
