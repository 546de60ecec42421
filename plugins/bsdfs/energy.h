#pragma once

#include <algorithm>

#include "batch.h"

namespace kinome {

/// A diffuse and a specular reflectance that are kept from exceeding 1 together, as Mitsuba 0.6
/// does: where the sum of their maxima exceeds 1 in any channel, both are scaled by .99 / sum.
class ReflectancePair {
 public:
  explicit ReflectancePair(const Properties& props)
      : diffuse_(reflectance_texture(props, "diffuse_reflectance")),
        specular_(reflectance_texture(props, "specular_reflectance")) {
    const float sum = max_component(diffuse_->channel_max() + specular_->channel_max());
    if (props.boolean("ensure_energy_conservation") && sum > 1) {
      scale_ = 0.99f / sum;
    }
    const float d = luminance(diffuse_->mean());
    const float s = luminance(specular_->mean());
    specular_probability_ = d + s > 0 ? s / (d + s) : 0.5f;
  }

  Rgb diffuse(const SurfaceInteraction& si) const { return scale_ * diffuse_.at(si); }
  Rgb specular(const SurfaceInteraction& si) const { return scale_ * specular_.at(si); }
  /// The textures, whose values are to be multiplied by scale().
  const ColorInput& diffuse_input() const { return diffuse_; }
  const ColorInput& specular_input() const { return specular_; }
  float scale() const { return scale_; }
  /// The probability of the specular lobe: where both may be sampled, its share of the average
  /// luminance.
  float glossy_probability(Lobe mask) const {
    return lobe_probability(any(mask & Lobe::kGlossy), any(mask & Lobe::kDiffuse),
                            specular_probability_, 1 - specular_probability_);
  }
  /// The diffuse lobe has a form; the glossy one has none.
  BsdfForm form_kind() const {
    BsdfForm form;
    if (any(lobes() & Lobe::kGlossy)) form.glossy = BsdfForm::Glossy::kOther;
    return form;
  }
  template <class F>
  wide::FormOf<F> form_of(const RgbOf<F>& diffuse) const {
    return {scale_ * diffuse, RgbOf<F>(0.f), 1.f, 1.f};
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

/// The rows of a plugin's table that ReflectancePair reads.
#define KINOME_REFLECTANCE_PAIR_PARAMETERS                                               \
  {"diffuse_reflectance", ::kinome::ParameterType::kReflectanceTexture, "0.5", "weight kd"},        \
      {"specular_reflectance", ::kinome::ParameterType::kReflectanceTexture, "0.2", "weight ks"}, { \
    "ensure_energy_conservation", ::kinome::ParameterType::kBoolean, "true",             \
        "scale both reflectances by .99 / max(kd + ks) where that exceeds 1"             \
  }

}  // namespace kinome
