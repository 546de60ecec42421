#pragma once

#include <algorithm>

#include "batch.h"

namespace kinome {

/// A diffuse and a specular reflectance whose sum stays below 1, as in Mitsuba 0.6: if the sum of
/// their maxima exceeds 1 in any channel, both are scaled by .99 / sum.
class ReflectancePair {
 public:
  explicit ReflectancePair(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")) {
    const float sum = max_component(diffuse_->channel_max() + specular_->channel_max());
    if (props.boolean("ensure_energy_conservation") && sum > 1) {
      scale_ = 0.99f / sum;
    }
    specular_probability_ =
        specular_share(luminance(diffuse_->mean()), luminance(specular_->mean()));
  }

  Rgb diffuse(const SurfaceInteraction& si) const { return scale_ * diffuse_.at(si); }
  Rgb specular(const SurfaceInteraction& si) const { return scale_ * specular_.at(si); }
  /// The textures. Callers must multiply their values by scale().
  const ColorInput& diffuse_input() const { return diffuse_; }
  const ColorInput& specular_input() const { return specular_; }
  float scale() const { return scale_; }
  /// Probability of sampling the specular lobe. If both lobes may be sampled, it is the specular
  /// fraction of the mean luminance.
  float glossy_probability(Lobe mask) const {
    return lobe_probability(any(mask & Lobe::kGlossy), any(mask & Lobe::kDiffuse),
                            specular_probability_, 1 - specular_probability_);
  }
  Lobe lobes() const {
    return (diffuse_->max() > 0 ? Lobe::kDiffuse : Lobe::kNone) |
           (specular_->max() > 0 ? Lobe::kGlossy : Lobe::kNone);
  }

 private:
  ColorInput diffuse_;
  ColorInput specular_;
  float scale_ = 1;
  float specular_probability_ = 0.5f;
};

/// Base of BSDFs with a ReflectancePair, whose textures are the first two inputs of Self.
template <class Self>
class PairBsdf : public wide::FormulaBsdf<Self> {
 public:
  explicit PairBsdf(const Properties& props) : reflectances_(props) {
    this->lobes_ = reflectances_.lobes();
  }

  /// A BsdfForm can represent the diffuse lobe, but not the glossy one.
  BsdfForm form_kind() const {
    BsdfForm form;
    if (any(this->lobes_ & Lobe::kGlossy)) form.glossy = BsdfForm::Glossy::kOther;
    return form;
  }
  template <class F, class... Others>
  wide::FormOf<F> form_of(const VecOf<F>& /*wi*/, const RgbOf<F>& diffuse,
                          const Others&... /*unused*/) const {
    return {reflectances_.scale() * diffuse, RgbOf<F>(0.f), 1.f, 1.f};
  }

  Rgb albedo(const SurfaceInteraction& si) const override {
    return reflectances_.diffuse(si) + reflectances_.specular(si);
  }
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {reflectances_.diffuse(si), reflectances_.specular(si)};
  }

 protected:
  ReflectancePair reflectances_;
};

/// Parameters that ReflectancePair reads.
#define KINOME_REFLECTANCE_PAIR_PARAMETERS                                          \
  {"diffuse_reflectance", ::kinome::ParameterType::kReflectanceTexture, "0.5",      \
   "kd, weight of the diffuse lobe"},                                               \
      {"specular_reflectance", ::kinome::ParameterType::kReflectanceTexture, "0.2", \
       "ks, weight of the specular lobe"},                                          \
  {                                                                                 \
    "ensure_energy_conservation", ::kinome::ParameterType::kBoolean, "true",        \
        "scale both reflectances by .99 / max(kd + ks) if the maximum exceeds 1"    \
  }

}  // namespace kinome
