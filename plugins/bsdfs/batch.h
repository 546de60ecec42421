#pragma once

#include <algorithm>

#include "bounded_texture.h"
#include "kinome/bsdf.h"
#include "kinome/properties.h"
#include "kinome/texture.h"
#include "kinome/warp.h"
#include "kinome/wide/bsdf.h"

/// Helpers that most BSDF plugins share. The number type F of the formulas is float for one point,
/// or wide::Float for several.
namespace kinome {

using namespace wide::formulas;
using wide::BsdfSampleOf;
using wide::BsdfValueOf;
using wide::choose;
using wide::ColorInput;
using wide::lobe_number;
using wide::NumberInput;
using wide::weighted_sample;

/// Probability of sampling the first of two lobes with sampling weights a and b. If only one of
/// them is selected, it gets all samples. If both are, each has a probability of at least 1e-4:
/// rounding must not leave a lobe that reflects light without density.
template <class F>
F lobe_probability(bool has_a, bool has_b, F a, F b) {
  if (!has_a || !has_b) {
    return has_a ? 1.f : 0.f;
  }
  const F sum = a + b;
  return select(sum > 0.f, clamp(a / sum, F(1e-4f), F(1 - 1e-4f)), F(0.5f));
}

/// Clamps a texture's value to [0,1], for use as a weight. NaN becomes 0.
template <class F>
F clamped_share(const F& value) {
  return select(value > 0.f, min(value, F(1.f)), F(0.f));
}

/// Upper bound of densities, so that their squares (power heuristic) don't overflow.
inline constexpr float kMaxPdf = 1e18f;

/// Reads a reflectance. If the texture exceeds 1, it is clamped to [0,1] with a warning. Otherwise
/// it is returned unchanged, with negative texels if it has any.
inline std::shared_ptr<Texture> reflectance_texture(const Properties& props,
                                                    const std::string& name) {
  return bounded_texture(props, name, props.texture(name), 1);
}

/// Reads a texture whose values must be finite and not negative.
inline std::shared_ptr<Texture> nonnegative_texture(const Properties& props,
                                                    const std::string& name) {
  auto texture = props.texture(name);
  if (!(texture->min() >= 0)) {
    throw props.error(name, "must not be negative, got " + format_number(texture->min()));
  }
  if (!std::isfinite(texture->max())) {
    throw props.error(name, "must be finite, got " + format_number(texture->max()));
  }
  return texture;
}

/// Reads a number that must be finite and not negative.
inline float nonnegative_number(const Properties& props, const char* name) {
  return props.real(name, "must not be negative",
                    [](float value) { return value >= 0 && std::isfinite(value); });
}

/// Largest valid roughness. Fourth powers of larger ones would overflow, and microfacets reflect
/// almost nothing at 1e6.
inline constexpr float kMaxRoughness = 1e6f;

inline void check_roughness(const Properties& props, const std::string& name, float min_value,
                            float max_value) {
  if (!(min_value >= 0)) {
    throw props.error(name, "must not be negative, got " + format_number(min_value));
  }
  if (!(max_value <= kMaxRoughness)) {
    throw props.error(name, "must be at most 1e6, got " + format_number(max_value));
  }
}
/// Reads a roughness: the alpha of microfacets, or its square root.
inline std::shared_ptr<Texture> roughness_texture(const Properties& props,
                                                  const std::string& name) {
  auto texture = props.texture(name);
  check_roughness(props, name, texture->min(), texture->max());
  return texture;
}

/// Reads a roughness that must be uniform.
inline float roughness_number(const Properties& props, const char* name) {
  const float alpha = props.real(name);
  check_roughness(props, name, alpha, alpha);
  return alpha;
}

/// Samples the diffuse lobe of `lobes`, proportional to the cosine.
template <class F, class Lobes>
KINOME_WIDE BsdfSampleOf<F> diffuse_sample(const Lobes& lobes, const Vec2Of<F>& u2) {
  return weighted_sample<F>(lobes, warp::square_to_cosine_hemisphere<VecOf<F>>(u2),
                            IntOf<F>(lobe_number(Lobe::kDiffuse)));
}

/// Mirrors wi at the normal.
template <class V>
V mirrored(const V& wi) {
  return {-wi.x, -wi.y, wi.z};
}
/// Samples the mirror direction, a delta lobe.
template <class F>
KINOME_WIDE BsdfSampleOf<F> mirror_sample(const VecOf<F>& wi, const RgbOf<F>& weight) {
  return {mirrored(wi), 1.f, weight, lobe_number(Lobe::kDelta)};
}

/// Mean of a texture's channels. Mitsuba weights lobes by it.
inline float mean_of_channels(const Texture& texture) {
  const Rgb m = texture.mean();
  return (m.x + m.y + m.z) / 3;
}
/// Returns the specular fraction of all reflection; 0.5 if both parts are 0.
inline float specular_share(float diffuse, float specular) {
  return diffuse + specular > 0 ? specular / (diffuse + specular) : 0.5f;
}

}  // namespace kinome
