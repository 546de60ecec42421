#include "batch.h"
#include "kinome/plugin.h"

/// Lambertian reflection: f = reflectance / pi, from the front side only.
///
///     <bsdf type="diffuse"><rgb name="reflectance" value="0.2 0.25 0.7"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo"},
};

class Diffuse final : public wide::FormulaBsdf<Diffuse> {
 public:
  explicit Diffuse(const Properties& props)
      : reflectance_(reflectance_texture(props, "reflectance")) {
    lobes_ = Lobe::kDiffuse;
    is_lambertian_ = true;
  }

  template <class F>
  struct Lobes {
    RgbOf<F> albedo;

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F pdf = warp::cosine_hemisphere_pdf(wo.z);
      return {albedo * pdf, pdf};
    }
    BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& u2) const {
      const VecOf<F> wo = warp::square_to_cosine_hemisphere<VecOf<F>>(u2);
      return {wo, warp::cosine_hemisphere_pdf(wo.z), albedo, lobe_number(Lobe::kDiffuse)};
    }
  };
  auto inputs() const { return std::tie(reflectance_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([](const VecOf<F>& /*wi*/, const RgbOf<F>& albedo) { return Lobes<F>{albedo}; });
  }

  BsdfForm form_kind() const { return {}; }
  template <class F>
  wide::FormOf<F> form_of(const VecOf<F>& /*wi*/, const RgbOf<F>& albedo) const {
    return {albedo, RgbOf<F>(0.f), 1.f, 1.f};
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return reflectance_.at(si); }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {reflectance_.at(si), Rgb(0.f)};
  }

 private:
  ColorInput reflectance_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Diffuse, kinome::Category::kBsdf, "diffuse",
              "Ideally diffuse reflection, the same radiance in every direction.",
              kinome::kParameters);
