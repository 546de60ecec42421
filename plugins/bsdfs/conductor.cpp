#include "conductor_index.h"
#include "fresnel.h"
#include "kinome/plugin.h"

/// A smooth conductor: the mirror direction only, weighted by Fresnel's reflectance for the complex
/// index eta + i k. One-sided.
///
///     <bsdf type="conductor"><string name="material" value="Au"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_CONDUCTOR_PARAMETERS,
    {"specular_reflectance", ParameterType::kReflectanceTexture, "1", "factor on the reflection"},
};

class Conductor final : public Bsdf {
 public:
  explicit Conductor(const Properties& props)
      : index_(props), specular_(reflectance_texture(props, "specular_reflectance")) {
    lobes_ = Lobe::kDelta;
  }

  void eval_pdf(const SurfaceInteraction&, Lobe, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    zero_batch(wo, out);
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& /*u2*/) const override {
    if (!any(mask & Lobe::kDelta) || !(si.wi.z > 0)) {
      return std::nullopt;
    }
    const Rgb f = fresnel_conductor(std::min(si.wi.z, 1.f), index_.eta(si.uv), index_.k(si.uv));
    return BsdfSample{Vec3(-si.wi.x, -si.wi.y, si.wi.z), 1.f, specular_->eval(si.uv) * f,
                      Lobe::kDelta};
  }

  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }

 private:
  ConductorIndex index_;
  std::shared_ptr<Texture> specular_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Conductor, kinome::Category::kBsdf, "conductor",
              "Smooth metal: a mirror with Fresnel reflectance.", kinome::kParameters);
