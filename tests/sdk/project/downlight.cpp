// A small lamp that shines down (-y), brightest along its axis.
//
//     I(d) = intensity max(-d.y, 0)
//
//     <emitter type="downlight"> <point name="position" y="3"/> </emitter>

#include <algorithm>
#include <cmath>

#include <kinome/emitter.h>
#include <kinome/plugin.h>
#include <kinome/warp.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"position", ParameterType::kVector, "0 2 0", "Position of the lamp."},
    {"intensity", ParameterType::kEmission, "1", "Radiant intensity straight down."},
};

class Downlight final : public Emitter {
 public:
  explicit Downlight(const Properties& props)
      : position_(props.vector("position")), intensity_(props.color("intensity")) {}

  // Direct light comes from a single direction at any point. Only is_delta() and sample_direct()
  // are needed for it.
  bool is_delta() const override { return true; }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& /*u*/) const override {
    const Vec3 to = position_ - p;
    const float distance = glm::length(to);
    if (!(distance > 0 && to.y > 0)) return std::nullopt;
    DirectSample sample;
    sample.d = to / distance;
    sample.distance = distance;
    sample.pdf = 1;
    sample.radiance = intensity(-sample.d) / (distance * distance);
    sample.is_delta = true;
    return sample;
  }

  // Emitted rays, for `ptracer` and for light after a bounce in `clustered`.
  std::optional<EmissionSample> sample_emission(const Vec2& /*position*/,
                                                const Vec2& direction) const override {
    const Vec3 local = square_to_cosine_hemisphere(direction);
    EmissionSample ray;
    ray.o = position_;
    ray.d = Vec3(local.x, -local.z, local.y);
    ray.pdf_direction = cosine_hemisphere_pdf(local.z);
    ray.power = intensity(ray.d) / ray.pdf_direction;
    return ray;
  }
  std::optional<EmissionDensity> emission_density(const Vec3& d) const override {
    return EmissionDensity{cosine_hemisphere_pdf(-d.y), 0};
  }

 private:
  Rgb intensity(const Vec3& d) const { return intensity_ * std::max(-d.y, 0.f); }

  Vec3 position_;
  Rgb intensity_;
};

}  // namespace

KINOME_PLUGIN(Downlight, Category::kEmitter, "downlight", "A small lamp that shines down (-y).",
              kParameters);
