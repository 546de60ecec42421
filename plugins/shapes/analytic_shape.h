#pragma once

#include "kinome/shape.h"
#include "local_space.h"

namespace kinome {

/// Shapes that rays meet by a formula, one ray at a time and in packets, with interactions of
/// single points and of blocks. `Derived`, a final class, has (all may be private, with this class
/// for a friend):
///
///     F first_hit(const V& o, const V& d, F tmin, F tmax) const     infinite where there is none
///     ShapePoint<F> hit_at(const V& o, const V& d, F t) const       without wi
///     Vec3 direction_of_normal(const Ray& ray, float t) const       of any length
///
/// for F and V of one ray (float, Vec3) and of a vector of rays (wide::Float, wide::Vec3). The
/// first hit lies in [tmin, tmax].
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

 protected:
  /// The interaction at a point that lies on the shape: as a ray along -n would find it. n is about
  /// as long as the shape is wide, so that the ray's origin keeps the point's digits.
  SurfaceInteraction interaction_at(const DVec3& p, const DVec3& n) const {
    Ray ray;
    ray.o = Vec3(p + n);
    ray.d = Vec3(-n);
    ray.tmax = 1;
    SurfaceInteraction si = interaction(ray, Hit{});
    si.shape = this;
    return si;
  }

 private:
  const Derived& self() const { return static_cast<const Derived&>(*this); }
};

}  // namespace kinome
