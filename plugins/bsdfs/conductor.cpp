#include "conductor_index.h"
#include "kinome/plugin.h"
#include "kinome/wide/fresnel.h"

/// A smooth conductor. It reflects in the mirror direction only, by the Fresnel reflectance of the
/// complex index eta + i k. One-sided.
///
///     <bsdf type="conductor"><string name="material" value="Au"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_CONDUCTOR_PARAMETERS,
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1",
     "scale factor of the reflection"},
};

class Conductor final : public wide::FormulaBsdf<Conductor> {
 public:
  explicit Conductor(const Properties& props)
      : index_(props), specular_(reflectance_texture(props, "specular_reflectance")) {
    lobes_ = Lobe::kDelta;
  }

  template <class F>
  struct Lobes {
    VecOf<F> wi;
    RgbOf<F> reflectance;

    BsdfValueOf<F> value(const VecOf<F>& /*wo*/) const { return {RgbOf<F>(0.f), 0.f}; }
    BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& /*u2*/) const {
      return mirror_sample<F>(wi, reflectance);
    }
  };
  auto inputs() const { return std::tie(specular_, index_.eta(), index_.k()); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([](const VecOf<F>& wi, const RgbOf<F>& specular, const RgbOf<F>& eta, const RgbOf<F>& k) {
      return Lobes<F>{wi, specular * fresnel_conductor(min(wi.z, F(1.f)),
                                                       ConductorIndex::bounded(eta),
                                                       ConductorIndex::bounded(k))};
    });
  }

  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }

 private:
  ConductorIndex index_;
  ColorInput specular_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Conductor, kinome::Category::kBsdf, "conductor",
              "Smooth metal: a mirror with Fresnel reflectance.", kinome::kParameters);
