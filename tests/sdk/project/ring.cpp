// A flat ring around `center`, which faces +z.
//
//     <shape type="ring"> <float name="inner" value="0.4"/> </shape>

#include <algorithm>
#include <cmath>

#include <kinome/plugin.h>
#include <kinome/shape.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"center", ParameterType::kVector, "0 0 0", "Its centre."},
    {"radius", ParameterType::kFloat, "1", "Radius of the outer edge."},
    {"inner", ParameterType::kFloat, "0.5", "Radius of the hole."},
    {"bsdf", ParameterType::kObject, nullptr, "Its material.", false, Category::kBsdf},
    {"emitter", ParameterType::kObject, nullptr, "Its light.", false, Category::kEmitter},
};

class Ring final : public Shape {
 public:
  explicit Ring(const Properties& props)
      : Shape(props),
        centre_(props.vector("center")),
        outer_(props.real("radius")),
        inner_(props.real("inner")) {
    if (!(inner_ >= 0 && inner_ < outer_)) throw props.error("inner", "must lie in [0, radius)");
  }

  Aabb bounds() const override {
    return {centre_ - Vec3(outer_, outer_, 0), centre_ + Vec3(outer_, outer_, 0)};
  }
  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    t = (centre_.z - ray.o.z) / ray.d.z;
    if (!(t >= ray.tmin && t <= ray.tmax)) return false;
    const float r = glm::length(Vec2(ray.at(t) - centre_));
    hit.ng = Vec3(0, 0, 1);
    return r >= inner_ && r <= outer_;
  }
  SurfaceInteraction interaction(const Ray& ray, const Hit& /*hit*/) const override {
    SurfaceInteraction si = point(Vec2(ray.at(ray.tmax) - centre_));
    si.t = ray.tmax;
    si.wi = si.frame.to_local(-glm::normalize(ray.d));
    return si;
  }

  float area() const override { return kPi * (outer_ * outer_ - inner_ * inner_); }
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    const float r = std::sqrt(inner_ * inner_ + u.x * (outer_ * outer_ - inner_ * inner_));
    return point(r * Vec2(std::cos(2 * kPi * u.y), std::sin(2 * kPi * u.y)));
  }

 private:
  /// Returns the surface at a position of its plane.
  SurfaceInteraction point(const Vec2& local) const {
    const float r = std::max(glm::length(local), 1e-30f), turn = std::atan2(local.y, local.x);
    SurfaceInteraction si;
    si.p = centre_ + Vec3(local, 0);
    si.p_error = 2 * 0x1p-24f * (std::abs(centre_.z) + outer_);  // z is exact: a small offset
    si.dp_du = (outer_ - inner_) / r * Vec3(local, 0);
    si.dp_dv = 2 * kPi * Vec3(-local.y, local.x, 0);
    si.frame = Frame::from_normal_and_tangent(si.n, si.dp_du);
    si.uv = {(r - inner_) / (outer_ - inner_), turn / (2 * kPi) + (turn < 0 ? 1.f : 0.f)};
    return si;
  }

  Vec3 centre_;
  float outer_, inner_;
};

}  // namespace

KINOME_PLUGIN(Ring, Category::kShape, "ring", "A flat ring that faces +z.", kParameters);
