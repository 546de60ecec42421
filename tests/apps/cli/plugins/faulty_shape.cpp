// A shape with a fault, for tests of the program's reaction.

#include "faulty.h"
#include "kinome/shape.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_FAULT_PARAMETER,
    {"bsdf", ParameterType::kObject, nullptr, "Its material.", false, Category::kBsdf},
    {"emitter", ParameterType::kObject, nullptr, "Its light.", false, Category::kEmitter},
};

/// A square in the plane z = 0, except for its fault.
class FaultyShape final : public Shape {
 public:
  explicit FaultyShape(const Properties& props) : Shape(props), fault_(props) {}

  Aabb bounds() const override {
    fault_.throw_if("bounds", "be bounded");
    return {Vec3(-1, -1, -0.01f), Vec3(1, 1, 0.01f)};
  }
  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    fault_.throw_if("intersect", "be hit");
    fault_.crash_if("in intersect");
    t = fault_.is("nan") ? kNan : -ray.o.z / ray.d.z;
    const Vec3 p = ray.o + ray.d * t;
    if (!(t > ray.tmin && t < ray.tmax && std::abs(p.x) < 1 && std::abs(p.y) < 1)) return false;
    hit.ng = Vec3(0, 0, 1);
    hit.u = p.x;
    hit.v = p.y;
    return true;
  }
  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override {
    fault_.throw_if("interaction", "be touched");
    SurfaceInteraction si;
    si.t = ray.tmax;
    si.p = Vec3(hit.u, hit.v, 0);
    si.wi = si.frame.to_local(glm::normalize(-ray.d));
    return si;
  }
  float area() const override { return 4; }
  SurfaceInteraction sample_surface(const Vec2& u) const override {
    SurfaceInteraction si;
    si.p = Vec3(u * 2.f - 1.f, 0);
    return si;
  }

 private:
  Fault fault_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::FaultyShape, kinome::Category::kShape, "faulty", "Has a fault.",
              kinome::test::kTable);
