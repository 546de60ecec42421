// Scalar functions for light paths.

#include "transport/light_paths/adjoint.h"

#include "kinome/shape.h"
#include "kinome/warp.h"

namespace kinome::transport {

namespace {

/// Returns the weight of a delta sample as seen from the direction that the light leaves in.
/// Returns nullopt if another normal is seen from there, because its mirror direction differs.
std::optional<kinome::Rgb> seen_delta(const SurfaceInteraction& si, const BsdfSample& sent,
                                      const kinome::Rgb& weight) {
  constexpr float kMaxDistance = 1e-3f;  // of equal directions, due to rounding
  const Bsdf& bsdf = si.shape->bsdf();
  SurfaceInteraction seen = si;
  seen.wi = sent.wo;
  const auto forth = bsdf.sample(si, Lobe::kDelta, 0.5f, kinome::Vec2(0.5f));
  const auto back = bsdf.sample(seen, Lobe::kDelta, 0.5f, kinome::Vec2(0.5f));
  if (!forth || !back || !(glm::distance(back->wo, si.wi) < kMaxDistance)) return std::nullopt;
  kinome::Rgb out(0.f);
  for (int k = 0; k < 3; ++k) {
    if (forth->weight[k] > 0) out[k] = weight[k] * (back->weight[k] / forth->weight[k]);
  }
  return out;
}

/// Samples a BSDF that doesn't sample all directions from which the light is seen, because its
/// normal turns to the viewer. Half of the samples are distributed by the cosine, on both sides if
/// the BSDF transmits light. `weight` is set only for deltas.
std::optional<BsdfSample> sample_turning(const SurfaceInteraction& si, Lobe lobes, float u_lobe,
                                         const kinome::Vec2& u) {
  const Bsdf& bsdf = si.shape->bsdf();
  const bool by_bsdf = u_lobe < 0.5f;
  std::optional<BsdfSample> sample;
  if (by_bsdf) {
    sample = bsdf.sample(si, lobes, 2 * u_lobe, u);
    if (!sample) return std::nullopt;
    if (any(sample->lobe & Lobe::kDelta)) {
      sample->weight *= 2;
      return sample;
    }
  } else {
    float side = si.wi.z < 0 ? -1.f : 1.f;
    if (bsdf.transmits() && u_lobe < 0.75f) side = -side;
    sample.emplace();
    sample->wo = square_to_cosine_hemisphere(u) * kinome::Vec3(1, 1, side);
    sample->lobe = lobes & (Lobe::kDiffuse | Lobe::kGlossy);
  }
  const bool is_possible = bsdf.transmits() || si.wi.z * sample->wo.z > 0;
  const float share = bsdf.transmits() ? 0.5f : 1.f;  // share of samples on one side
  const float by_cosine =
      is_possible ? share * cosine_hemisphere_pdf(std::abs(sample->wo.z)) : 0.f;
  sample->pdf = 0.5f * (bsdf.eval_pdf(si, lobes, sample->wo).pdf + by_cosine);
  if (!(sample->pdf > 0)) return std::nullopt;
  return sample;
}

}  // namespace

std::optional<AdjointSample> sample_adjoint(const SurfaceInteraction& si, Lobe lobes, float u_lobe,
                                            const kinome::Vec2& u) {
  const Bsdf& bsdf = si.shape->bsdf();
  const bool has_others = any(lobes & bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
  const auto sample = bsdf.turns_to_viewer() && has_others ? sample_turning(si, lobes, u_lobe, u)
                                                           : bsdf.sample(si, lobes, u_lobe, u);
  if (!sample) return std::nullopt;
  kinome::Rgb weight = sample->weight;
  const bool is_delta = any(sample->lobe & Lobe::kDelta);
  if (!is_delta) {
    SurfaceInteraction seen = si;
    seen.wi = sample->wo;
    weight = bsdf.eval_pdf(seen, lobes, si.wi).f / sample->pdf;
  } else if (bsdf.turns_to_viewer()) {
    const auto back = seen_delta(si, *sample, weight);
    if (!back) return std::nullopt;
    weight = *back;
  } else if (!any(sample->lobe & Lobe::kNull)) {
    weight *= power_over_radiance(si.wi.z, sample->wo.z, bsdf.relative_index());
  }
  const kinome::Vec3 to = si.frame.to_world(sample->wo);
  return AdjointSample{to, weight * adjoint_factor(si, si.frame.to_world(si.wi), to), is_delta,
                       any(sample->lobe & Lobe::kNull)};
}

std::optional<SeenPoint> connect_point(const Sensor& sensor, const SurfaceInteraction& si,
                                       const kinome::Vec2& aperture) {
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return std::nullopt;
  const auto connection = sensor.connect(si.p, aperture);
  if (!connection) return std::nullopt;
  SurfaceInteraction seen = si;
  seen.wi = si.frame.to_local(connection->d);
  const kinome::Rgb f = bsdf.eval_pdf(seen, Lobe::kAll, si.wi).f;
  const float factor = adjoint_factor(si, si.frame.to_world(si.wi), connection->d);
  return SeenPoint{connection->film_position, f * (factor * connection->weight),
                   si.shadow_ray(connection->d, connection->distance)};
}

}  // namespace kinome::transport
