#pragma once

#include <algorithm>

#include "kinome/bsdf.h"
#include "kinome/properties.h"
#include "kinome/texture.h"

/// What most BSDF plugins share.
namespace kinome {

/// Writes value(wo) -> BsdfValue for a whole batch. `value` is inlined into two loops, so that the
/// density costs nothing where it isn't wanted, and nothing in it depends on the neighbours: a
/// batch gives the same bits as single calls.
template <class Value>
inline void evaluate_batch(const DirectionBatch& wo, const BsdfValueBatch& out,
                           const Value& value) {
  if (out.pdf) {
    for (size_t i = 0; i < wo.count; ++i) {
      const BsdfValue v = value(Vec3(wo.x[i], wo.y[i], wo.z[i]));
      out.r[i] = v.f.x;
      out.g[i] = v.f.y;
      out.b[i] = v.f.z;
      out.pdf[i] = v.pdf;
    }
  } else {
    for (size_t i = 0; i < wo.count; ++i) {
      const BsdfValue v = value(Vec3(wo.x[i], wo.y[i], wo.z[i]));
      out.r[i] = v.f.x;
      out.g[i] = v.f.y;
      out.b[i] = v.f.z;
    }
  }
}

inline void zero_batch(const DirectionBatch& wo, const BsdfValueBatch& out) {
  evaluate_batch(wo, out, [](const Vec3&) { return BsdfValue{}; });
}

/// The sample wo of `lobe`, weighted by all lobes in `mask`; nullopt where nothing is reflected.
inline std::optional<BsdfSample> weighted_sample(const Bsdf& bsdf, const SurfaceInteraction& si,
                                                 Lobe mask, const Vec3& wo, Lobe lobe) {
  const BsdfValue v = bsdf.eval_pdf(si, mask, wo);
  if (!(v.pdf > 0)) {
    return std::nullopt;
  }
  return BsdfSample{wo, v.pdf, v.f / v.pdf, lobe};
}

/// Probability of the first of two lobes with sampling weights a and b, of which a mask may leave
/// only one. Neither gets less than 1e-4, whatever the weights: a lobe that reflects something must
/// not be left without density by rounding.
inline float lobe_probability(bool has_a, bool has_b, float a, float b) {
  if (!has_a || !has_b) {
    return has_a ? 1.f : 0.f;
  }
  const float sum = a + b;
  return sum > 0 ? std::clamp(a / sum, 1e-4f, 1 - 1e-4f) : 0.5f;
}

/// Densities stay below this, so that their squares (power heuristic) don't overflow.
inline constexpr float kMaxPdf = 1e18f;

/// A reflectance, whose texels must not exceed 1 either. Negative ones are the texture's own
/// affair: an image's are kept with a warning, a checkerboard has none.
inline std::shared_ptr<Texture> reflectance_texture(const Properties& props,
                                                    const std::string& name) {
  auto texture = props.texture(name);
  // Half floats and filtering round; 1e-3 is their precision at 1.
  if (texture->max() > 1.001f) {
    throw props.error(
        name, "must lie in [0,1], but its texture has the value " + std::to_string(texture->max()));
  }
  return texture;
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

/// Mean of a texture's channels: what Mitsuba weighs lobes by.
inline float mean_of_channels(const Texture& texture) {
  const Rgb m = texture.mean();
  return (m.x + m.y + m.z) / 3;
}

}  // namespace kinome
