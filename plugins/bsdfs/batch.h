#pragma once

#include <algorithm>

#include "bounded_texture.h"
#include "kinome/bsdf.h"
#include "kinome/properties.h"
#include "kinome/texture.h"
#include "kinome/warp.h"
#include "kinome/wide/bsdf.h"

/// What most BSDF plugins share. Formulas are over numbers F, float or wide::Float: one point, or
/// several.
namespace kinome {

using namespace wide::formulas;
using wide::BsdfSampleOf;
using wide::BsdfValueOf;
using wide::choose;
using wide::ColorInput;
using wide::lobe_number;
using wide::NumberInput;
using wide::weighted_sample;

/// Probability of the first of two lobes with sampling weights a and b, of which a mask may leave
/// only one. Neither gets less than 1e-4, whatever the weights: a lobe that reflects something must
/// not be left without density by rounding.
template <class F>
F lobe_probability(bool has_a, bool has_b, F a, F b) {
  if (!has_a || !has_b) {
    return has_a ? 1.f : 0.f;
  }
  const F sum = a + b;
  return select(sum > 0.f, clamp(a / sum, F(1e-4f), F(1 - 1e-4f)), F(0.5f));
}

/// A texture's number as a share of something, in [0,1]; what is no number counts as 0.
template <class F>
F clamped_share(const F& value) {
  return select(value > 0.f, min(value, F(1.f)), F(0.f));
}

/// Densities stay below this, so that their squares (power heuristic) don't overflow.
inline constexpr float kMaxPdf = 1e18f;

/// A reflectance, whose texels are clamped with a warning if one exceeds 1. If none does, negative
/// ones are the texture's own affair: an image's are kept, a checkerboard has none.
inline std::shared_ptr<Texture> reflectance_texture(const Properties& props,
                                                    const std::string& name) {
  return bounded_texture(props, name, props.texture(name), 1);
}

/// An unbounded texture none of whose values may be negative.
inline std::shared_ptr<Texture> nonnegative_texture(const Properties& props,
                                                    const std::string& name) {
  auto texture = props.texture(name);
  if (!(texture->min() >= 0)) {
    throw props.error(name, "must not be negative, got " + std::to_string(texture->min()));
  }
  if (!std::isfinite(texture->max())) {
    throw props.error(name, "must be finite, got " + std::to_string(texture->max()));
  }
  return texture;
}

/// Roughnesses beyond it, whose fourth powers would overflow, are mistakes: at 1e6 microfacets
/// reflect next to nothing.
inline constexpr float kMaxRoughness = 1e6f;

inline void check_roughness(const Properties& props, const std::string& name, float least,
                            float most) {
  if (!(least >= 0)) {
    throw props.error(name, "must not be negative, got " + std::to_string(least));
  }
  if (!(most <= kMaxRoughness)) {
    throw props.error(name, "must be at most 1e6, got " + std::to_string(most));
  }
}
/// The alpha of microfacets, or the square root of it.
inline std::shared_ptr<Texture> roughness_texture(const Properties& props,
                                                  const std::string& name) {
  auto texture = props.texture(name);
  check_roughness(props, name, texture->min(), texture->max());
  return texture;
}

/// A direction about the normal, of the diffuse lobe of lobes.
template <class F, class Lobes>
KINOME_WIDE BsdfSampleOf<F> diffuse_sample(const Lobes& lobes, const Vec2Of<F>& u2) {
  return weighted_sample<F>(lobes, warp::square_to_cosine_hemisphere<VecOf<F>>(u2),
                            IntOf<F>(lobe_number(Lobe::kDiffuse)));
}

/// wi mirrored at the normal.
template <class V>
V mirrored(const V& wi) {
  return {-wi.x, -wi.y, wi.z};
}
/// The mirror's direction, of a delta lobe.
template <class F>
KINOME_WIDE BsdfSampleOf<F> mirror_sample(const VecOf<F>& wi, const RgbOf<F>& weight) {
  return {mirrored(wi), 1.f, weight, lobe_number(Lobe::kDelta)};
}

/// Mean of a texture's channels: what Mitsuba weighs lobes by.
inline float mean_of_channels(const Texture& texture) {
  const Rgb m = texture.mean();
  return (m.x + m.y + m.z) / 3;
}

}  // namespace kinome
