#include "batch.h"
#include "dielectric_index.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"

/// A thin plate of a dielectric, such as a window pane: light is reflected or goes straight
/// through. Reflections between the two faces are summed: R' = 2 R / (1 + R). Two-sided.
///
///     <bsdf type="thindielectric"><string name="int_ior" value="bk7"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_SMOOTH_DIELECTRIC_PARAMETERS("of the plate", "around it"),
};

class ThinDielectric final : public wide::FormulaBsdf<ThinDielectric> {
 public:
  static constexpr bool kSeenFromBehind = true;
  static constexpr bool kPassesStraight = true;

  explicit ThinDielectric(const Properties& props)
      : reflectance_(reflectance_texture(props, "specular_reflectance")),
        transmittance_(reflectance_texture(props, "specular_transmittance")),
        eta_(relative_ior(props)) {
    lobes_ = Lobe::kDelta;
    transmits_ = true;
    has_null_lobe_ = true;
  }

  template <class F>
  struct Lobes {
    VecOf<F> wi;
    RgbOf<F> reflectance, transmittance;
    F reflected;  ///< fraction of the light

    BsdfValueOf<F> value(const VecOf<F>& /*wo*/) const { return {RgbOf<F>(0.f), 0.f}; }
    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& /*u2*/) const {
      return choose(
          u1 < reflected, [&] { return mirror_sample<F>(wi, reflectance); },
          [&]() -> BsdfSampleOf<F> {
            return {-wi, 1.f, transmittance, lobe_number(Lobe::kDelta | Lobe::kNull)};
          });
    }
    wide::NullTransmissionOf<F> null_transmission() const {
      const F through = 1.f - reflected;
      return {transmittance * through, through};
    }
  };
  auto inputs() const { return std::tie(reflectance_, transmittance_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([this](const VecOf<F>& wi, const RgbOf<F>& reflectance, const RgbOf<F>& transmittance) {
      const F once = fresnel_dielectric(min(abs(wi.z), F(1.f)), eta_);
      return Lobes<F>{wi, reflectance, transmittance, 2.f * once / (1.f + once)};
    });
  }

  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }

 private:
  ColorInput reflectance_;
  ColorInput transmittance_;
  float eta_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::ThinDielectric, kinome::Category::kBsdf, "thindielectric",
              "A thin pane of glass: reflects light or lets it straight through.",
              kinome::kParameters);
