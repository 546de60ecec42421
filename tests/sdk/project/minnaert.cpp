// Minnaert's reflector (1941), which is darker at grazing angles, like the moon:
//
//     f = albedo (k + 1) / (2 pi) (cos_i cos_o)^(k - 1)
//
//     <bsdf type="minnaert"> <float name="k" value="1.5"/> </bsdf>

#include <algorithm>
#include <cmath>

#include <kinome/bsdf.h>
#include <kinome/plugin.h>
#include <kinome/texture.h>
#include <kinome/warp.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"albedo", ParameterType::kReflectanceTexture, "0.5", "Fraction reflected at normal incidence."},
    {"k", ParameterType::kFloat, "2", "Exponent of the darkening, at least 1 (none)."},
};

class Minnaert final : public Bsdf {
 public:
  explicit Minnaert(const Properties& props)
      : albedo_(props.texture("albedo")), k_(props.real("k")) {
    if (!(k_ >= 1)) throw props.error("k", "must be at least 1, got " + std::to_string(k_));
    lobes_ = Lobe::kDiffuse;
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    if (!is_seen(si, mask)) return {};
    const float density = pdf(wo.z);
    return {reflected(si) * density, density};
  }

  // Samples by the power of the cosine, so that every sample has the same weight.
  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float /*u1*/,
                                   const Vec2& u2) const override {
    if (!is_seen(si, mask)) return std::nullopt;
    const Vec3 wo = square_to_cosine_power(u2, k_);
    const float density = pdf(wo.z);
    if (!(density > 0)) return std::nullopt;
    return BsdfSample{wo, density, reflected(si), Lobe::kDiffuse};
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {albedo_->eval(si.uv), Rgb(0.f)};
  }

 private:
  bool is_seen(const SurfaceInteraction& si, Lobe mask) const {
    return si.wi.z > 0 && any(mask & lobes_);
  }
  /// Albedo toward the viewer under uniform light.
  Rgb reflected(const SurfaceInteraction& si) const {
    return albedo_->eval(si.uv) * std::pow(si.wi.z, k_ - 1);
  }
  float pdf(float cosine) const {
    return (k_ + 1) * (0.5f * kInvPi) * std::pow(std::max(cosine, 0.f), k_);
  }

  std::shared_ptr<const Texture> albedo_;
  float k_;
};

}  // namespace

KINOME_PLUGIN(Minnaert, Category::kBsdf, "minnaert", "Minnaert's reflector, point by point.",
              kParameters);
