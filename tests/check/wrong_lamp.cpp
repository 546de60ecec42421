// A surface that emits the same radiance in all directions outside, except for its fault.

#include "kinome/emitter.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {
    KINOME_WRONG_PARAMETER,
};

class WrongLamp final : public Emitter {
 public:
  explicit WrongLamp(const Properties& props) : wrong_(props) {}

  bool is_surface() const override { return true; }
  Rgb eval_surface(const SurfaceInteraction& si) const override {
    return Rgb(si.wi.z > 0 ? 1.f : 0.f);
  }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    const auto found = shape()->sample_solid_angle(p, u);
    if (!found) return std::nullopt;
    const Vec3 to = found->si.p - p;
    DirectSample sample;
    sample.distance = glm::length(to);
    sample.d = to / sample.distance;
    if (!(glm::dot(sample.d, found->si.n) < 0)) return std::nullopt;
    sample.distance *= wrong_.or_wrong("distance", 1.f, 0.5f);
    sample.pdf = found->pdf;
    sample.radiance = Rgb(1);
    return sample;
  }
  float pdf_surface(const Vec3& p, const SurfaceInteraction& si) const override {
    return si.wi.z > 0 ? shape()->pdf_solid_angle(p, si) : 0.f;
  }
  void eval_surface_block(const SurfaceBlock& points, const Columns3& from,
                          const Columns3& radiance, float* pdf) const override {
    Emitter::eval_surface_block(points, from, radiance, pdf);
    for (size_t i = 0; wrong_.is("block") && i < points.count; ++i) {
      radiance.set(i, radiance.at(i) * 1.1f);
    }
  }
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const override {
    const float part = wrong_.or_wrong("half", 1.f, 0.5f);
    const SurfaceInteraction si = shape()->sample_surface({part * position.x, position.y});
    const Vec3 local = square_to_cosine_hemisphere(direction);
    EmissionSample ray;
    ray.o = si.p + si.n * wrong_.or_wrong("above", 0.f, 0.1f);
    ray.o_error = si.p_error;
    ray.n = wrong_.or_wrong("normal", si.n, Vec3(0, 1, 0));
    ray.d = si.frame.to_world(local);
    ray.pdf_direction = cosine_hemisphere_pdf(local.z);
    ray.power = Rgb(kPi * shape()->area());
    return ray;
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongLamp, kinome::Category::kEmitter, "wrong_lamp", "Has a fault.",
              kinome::test::kTable);
