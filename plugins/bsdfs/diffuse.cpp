#include "batch.h"
#include "kinome/plugin.h"
#include "kinome/warp.h"

/// Lambertian reflection: f = reflectance / pi, from the front side only.
///
///     <bsdf type="diffuse"><rgb name="reflectance" value="0.2 0.25 0.7"/></bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"reflectance", ParameterType::kReflectanceTexture, "0.5", "albedo"},
};

class Diffuse final : public Bsdf {
 public:
  explicit Diffuse(const Properties& props)
      : reflectance_(reflectance_texture(props, "reflectance")) {
    lobes_ = Lobe::kDiffuse;
    is_lambertian_ = true;
  }

  void eval_pdf(const SurfaceInteraction& si, Lobe mask, const DirectionBatch& wo,
                const BsdfValueBatch& out) const override {
    if (!any(mask & Lobe::kDiffuse) || !(si.wi.z > 0)) {
      zero_batch(wo, out);
      return;
    }
    const Rgb albedo = reflectance_->eval(si.uv);
    evaluate_batch(wo, out, [albedo](const Vec3& d) {
      const float pdf = cosine_hemisphere_pdf(d.z);
      return BsdfValue{albedo * pdf, pdf};
    });
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& u2) const override {
    if (!any(mask & Lobe::kDiffuse) || !(si.wi.z > 0)) {
      return std::nullopt;
    }
    const Vec3 wo = square_to_cosine_hemisphere(u2);
    return BsdfSample{wo, cosine_hemisphere_pdf(wo.z), reflectance_->eval(si.uv), Lobe::kDiffuse};
  }

  std::optional<BsdfForm> form(const SurfaceInteraction& si) const override {
    BsdfForm form;
    form.diffuse = reflectance_->eval(si.uv);
    return form;
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {reflectance_->eval(si.uv), Rgb(0.f)};
  }

 private:
  std::shared_ptr<Texture> reflectance_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Diffuse, kinome::Category::kBsdf, "diffuse",
              "Ideally diffuse reflection, the same radiance in every direction.",
              kinome::kParameters);
