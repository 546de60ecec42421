#include "batch.h"
#include "dielectric_index.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"

/// A smooth boundary between two dielectrics, such as glass and air. It reflects a part of the
/// light and refracts the rest by Snell's law. Two-sided: int_ior is the index on the side that the
/// normal points away from. A closed shape is solid.
///
///     <bsdf type="dielectric"><string name="int_ior" value="bk7"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_SMOOTH_DIELECTRIC_PARAMETERS("inside", "outside"),
};

class Dielectric final : public wide::FormulaBsdf<Dielectric> {
 public:
  static constexpr bool kSeenFromBehind = true;

  explicit Dielectric(const Properties& props)
      : reflectance_(reflectance_texture(props, "specular_reflectance")),
        transmittance_(reflectance_texture(props, "specular_transmittance")) {
    relative_index_ = relative_ior(props);
    lobes_ = Lobe::kDelta;
    transmits_ = true;
  }

  template <class F>
  struct Lobes {
    VecOf<F> wi;
    RgbOf<F> reflectance, transmittance;
    DielectricBoundary<F> boundary;

    BsdfValueOf<F> value(const VecOf<F>& /*wo*/) const { return {RgbOf<F>(0.f), 0.f}; }
    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& /*u2*/) const {
      // The probabilities are the Fresnel terms, which therefore cancel in the weights.
      return choose(
          u1 < boundary.reflectance, [&] { return mirror_sample<F>(wi, reflectance); },
          [&] { return refracted(); });
    }

   private:
    BsdfSampleOf<F> refracted() const {
      const F cosine = select(wi.z > 0.f, -boundary.cos_t, boundary.cos_t);
      return {{-boundary.eta_ti * wi.x, -boundary.eta_ti * wi.y, cosine},
              1.f,
              transmittance * sqr(boundary.eta_ti),
              lobe_number(Lobe::kDelta)};
    }
  };
  auto inputs() const { return std::tie(reflectance_, transmittance_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([this](const VecOf<F>& wi, const RgbOf<F>& reflectance, const RgbOf<F>& transmittance) {
      return Lobes<F>{wi, reflectance, transmittance,
                      dielectric_boundary(wi.z, relative_index_)};
    });
  }

  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }

 private:
  ColorInput reflectance_;
  ColorInput transmittance_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Dielectric, kinome::Category::kBsdf, "dielectric",
              "Smooth glass, water and the like: reflects and refracts.", kinome::kParameters);
