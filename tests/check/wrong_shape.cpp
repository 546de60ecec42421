// The square [-1, 1]² in the plane z = 0, except for its fault.

#include "kinome/shape.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
    {"bsdf", ParameterType::kObject, nullptr, "Its material.", false, Category::kBsdf},
};

class WrongSquare final : public Shape {
 public:
  explicit WrongSquare(const Properties& props) : Shape(props), wrong_(props) {}

  Aabb bounds() const override { return {Vec3(-1, -1, 0), Vec3(1, 1, 0)}; }
  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    t = -ray.o.z / ray.d.z;
    if (wrong_.is("length")) t *= glm::length(ray.d);
    const bool is_within = t >= ray.tmin && t <= ray.tmax;
    const Vec3 p = ray.at(t);
    hit.ng = Vec3(0, 0, 1);
    hit.u = p.x, hit.v = p.y;
    return is_within && std::abs(p.x) <= 1 && std::abs(p.y) <= 1;
  }
  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override {
    SurfaceInteraction si = point({hit.u, hit.v});
    si.t = ray.tmax;
    si.wi = si.frame.to_local(glm::normalize(ray.d) * wrong_.or_wrong("wi", -1.f, 1.f));
    si.p.z += wrong_.or_wrong("elsewhere", 0.f, 0.01f);
    return si;
  }
  float area() const override { return wrong_.or_wrong("area", 4.f, 5.f); }
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    if (wrong_.is("quarter")) return point(u);
    if (wrong_.is("beyond")) return point(2.4f * u - 1.2f);
    return point(2.f * u - 1.f);
  }
  float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const override {
    return Shape::pdf_solid_angle(p, si) * wrong_.or_wrong("density", 1.f, 1.2f);
  }
  void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                const SurfaceSampleBlock& out) const override {
    Shape::sample_solid_angle_block(p, u, count, out);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) out.pdf[i] *= 1.1f;
  }

 private:
  SurfaceInteraction point(const Vec2& p) const {
    SurfaceInteraction si;
    si.p = Vec3(p, 0);
    si.p_error = 1e-6f;
    si.uv = 0.5f * p + 0.5f;
    si.dp_du = Vec3(2, 0, 0), si.dp_dv = Vec3(0, 2, 0);
    if (wrong_.is("normal")) si.n = Vec3(0, 0, 1.1f);
    return si;
  }

  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongSquare, kinome::Category::kShape, "wrong", "Has a fault.",
              kinome::test::kTable);
