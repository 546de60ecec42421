#pragma once

#include <memory>

#include "batch.h"
#include "dielectric_index.h"
#include "kinome/wide/fresnel.h"

namespace kinome {

/// Parameters of both kinds of coats.
#define KINOME_COAT_PARAMETERS                                                                     \
  {"int_ior", ParameterType::kFloatOrName, "bk7", "index of refraction of the coat"},              \
      {"ext_ior", ParameterType::kFloatOrName, "air", "index of refraction outside"},              \
      {"thickness", ParameterType::kFloat, "1", "thickness of the coat, in units of 1 / sigma_a"}, \
      {"sigma_a", ParameterType::kUnitlessTexture, "0", "absorption coefficient of the coat"},     \
      {"specular_reflectance", ParameterType::kReflectanceTexture, "1",                            \
       "scale factor of the coat's reflection"},                                                   \
  {                                                                                                \
    "bsdf", ParameterType::kObject, nullptr, "the coated BSDF", true, Category::kBsdf              \
  }

/// A dielectric coat over another BSDF, as in Mitsuba 0.6: the boundary's reflection, plus
///
///     f(wi, wo) = T(wi) T(wo) / eta² exp(-sigma_a d (1 / cos_i' + 1 / cos_o')) f'(wi', wo'),
///
/// where f' is the nested BSDF and wi' and wo' are the directions inside the coat. Light that the
/// boundary reflects back inside is lost. Boundary must provide
///
///     float transmittance(float cosine) const;  // from outside
///     Lobe lobe() const;                        // of the reflection
///     BsdfValue value(const Vec3& wi, const Vec3& wo) const;  // without specular_reflectance
///     std::optional<BsdfSample> sample(const Vec3& wi, const Vec2& u) const;  // weight as well
template <class Boundary>
class Coat : public Bsdf {
 public:
  Coat(const Properties& props, float eta, Boundary boundary)
      : eta_(eta),
        boundary_(std::move(boundary)),
        absorption_(nonnegative_texture(props, "sigma_a")),
        specular_(reflectance_texture(props, "specular_reflectance")),
        thickness_(props.real("thickness")),
        specular_weight_(mean_of_channels(*specular_)),
        nested_(props.object<Bsdf>()) {
    if (nested_->transmits()) throw props.error("bsdf", "must not transmit light");
    if (!(thickness_ >= 0) || !std::isfinite(thickness_)) {
      throw props.error("thickness", "must be finite and not negative");
    }
    lobes_ = nested_->lobes() | (specular_->max() > 0 ? boundary_.lobe() : Lobe::kNone);
    turns_to_viewer_ = nested_->turns_to_viewer();
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe mask, const Vec3& wo) const override {
    if (!(si.wi.z * wo.z > 0)) return {};
    const float share = coat_probability(si, mask);
    BsdfValue value;
    if (share < 1) {
      const SurfaceInteraction inside = below(si);
      const Vec3 wo_inside = refracted_in(wo);
      // If the index is larger outside, no light enters or leaves beyond the critical angle.
      if (inside.wi.z != 0 && wo_inside.z != 0) {
        value = nested_->eval_pdf(inside, mask, wo_inside);
        const float stretch = wo.z / (sqr(eta_) * wo_inside.z);
        value.f *= passed(si, inside.wi, wo, wo_inside) * stretch;
        value.pdf *= stretch * (1 - share);
      }
    }
    if (share > 0) {
      const BsdfValue coat = boundary_.value(upright(si.wi, si.wi), upright(wo, si.wi));
      value.f += coat.f * specular_.at(si);
      value.pdf += coat.pdf * share;
    }
    if (!(value.pdf > 0)) return {};
    return value;
  }

  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe mask, float u1,
                                   const Vec2& u2) const override {
    if (si.wi.z == 0 || !any(mask & lobes_)) return std::nullopt;
    const float share = coat_probability(si, mask);
    const bool is_coat = u1 < share;
    auto sample = is_coat ? sample_coat(si, share, u2) : sample_nested(si, mask, share, u1, u2);
    if (!sample || any(sample->lobe & Lobe::kDelta)) return sample;
    const BsdfValue value = eval_pdf(si, mask, sample->wo);
    if (!(value.pdf > 0)) return std::nullopt;
    sample->pdf = value.pdf;
    sample->weight = value.f / value.pdf;
    return sample;
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return nested_->albedo(si); }
  /// Estimates the reflectance for the viewing direction si.wi and light from near the normal.
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const SurfaceInteraction inside = below(si);
    LobeReflectance value = nested_->reflectance(inside);
    const Vec3 normal(0, 0, si.wi.z < 0 ? -1 : 1);
    const Rgb share = passed(si, inside.wi, normal, normal);
    value.diffuse *= share;
    value.glossy *= share;
    if (boundary_.lobe() == Lobe::kGlossy) {
      value.glossy += specular_.at(si) * (1 - boundary_.transmittance(std::abs(si.wi.z)));
    }
    return value;
  }
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.frame_toward_viewer();
  }

 private:
  Vec3 refracted_in(const Vec3& w) const {
    const float x = w.x / eta_, y = w.y / eta_;
    return {x, y, std::copysign(std::sqrt(std::max(1 - x * x - y * y, 0.f)), w.z)};
  }
  /// Returns nullopt for total internal reflection.
  std::optional<Vec3> refracted_out(const Vec3& w) const {
    const float x = w.x * eta_, y = w.y * eta_;
    const float cos2 = 1 - x * x - y * y;
    if (!(cos2 > 0)) return std::nullopt;
    return Vec3(x, y, std::copysign(std::sqrt(cos2), w.z));
  }
  SurfaceInteraction below(const SurfaceInteraction& si) const {
    SurfaceInteraction inside = si;
    inside.wi = refracted_in(si.wi);
    return inside;
  }
  /// Returns w, mirrored to the other side if wi is behind the surface.
  static Vec3 upright(const Vec3& w, const Vec3& wi) {
    return {w.x, w.y, wi.z < 0 ? -w.z : w.z};
  }

  /// Returns the fraction of light that enters along wi and leaves along wo.
  Rgb passed(const SurfaceInteraction& si, const Vec3& wi_inside, const Vec3& wo,
             const Vec3& wo_inside) const {
    const float length =
        thickness_ * (1 / std::abs(wi_inside.z) + 1 / std::abs(wo_inside.z));
    const float both = boundary_.transmittance(std::abs(si.wi.z)) *
                       boundary_.transmittance(std::abs(wo.z));
    // No light enters or leaves in the tangent plane.
    if (wi_inside.z == 0 || wo_inside.z == 0) return Rgb(0.f);
    if (absorption_->max() == 0) return Rgb(both);
    return both * glm::exp(-absorption_.at(si) * length);
  }

  float coat_probability(const SurfaceInteraction& si, Lobe mask) const {
    const float t = boundary_.transmittance(std::abs(si.wi.z));
    const bool has_coat = specular_weight_ > 0 && any(mask & boundary_.lobe());
    return lobe_probability(has_coat, any(mask & nested_->lobes()), (1 - t) * specular_weight_, t);
  }

  std::optional<BsdfSample> sample_coat(const SurfaceInteraction& si, float share,
                                        const Vec2& u2) const {
    auto sample = boundary_.sample(upright(si.wi, si.wi), u2);
    if (!sample) return std::nullopt;
    sample->wo = upright(sample->wo, si.wi);
    sample->weight *= specular_.at(si) / share;
    return sample;
  }

  std::optional<BsdfSample> sample_nested(const SurfaceInteraction& si, Lobe mask, float share,
                                          float u1, const Vec2& u2) const {
    const SurfaceInteraction inside = below(si);
    if (inside.wi.z == 0) return std::nullopt;
    const float nested_u1 = std::clamp((u1 - share) / (1 - share), 0.f, kOneMinusEpsilon);
    auto sample = nested_->sample(inside, mask, nested_u1, u2);
    if (!sample) return std::nullopt;
    const auto wo = refracted_out(sample->wo);
    if (!wo) return std::nullopt;
    sample->weight *= passed(si, inside.wi, *wo, sample->wo) / (1 - share);
    sample->wo = *wo;
    return sample;
  }

  float eta_;
  Boundary boundary_;
  ColorInput absorption_;
  ColorInput specular_;
  float thickness_;
  float specular_weight_;
  std::shared_ptr<Bsdf> nested_;
};

}  // namespace kinome
