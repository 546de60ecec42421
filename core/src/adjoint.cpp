#include "kinome/adjoint.h"

#include "kinome/shape.h"

namespace kinome {

std::optional<AdjointSample> sample_adjoint(const SurfaceInteraction& si, Lobe lobes, float u_lobe,
                                            const Vec2& u) {
  const Bsdf& bsdf = si.shape->bsdf();
  const auto sample = bsdf.sample(si, lobes, u_lobe, u);
  if (!sample) return std::nullopt;
  Rgb weight = sample->weight;
  if (!any(sample->lobe & Lobe::kDelta)) {
    SurfaceInteraction seen = si;
    seen.wi = sample->wo;
    weight = bsdf.eval_pdf(seen, lobes, si.wi).f / sample->pdf;
  }
  const Vec3 to = si.frame.to_world(sample->wo);
  return AdjointSample{to, weight * adjoint_factor(si, si.frame.to_world(si.wi), to)};
}

std::optional<SeenPoint> connect_point(const Sensor& sensor, const SurfaceInteraction& si,
                                       const Vec2& aperture) {
  const Bsdf& bsdf = si.shape->bsdf();
  if (!any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return std::nullopt;
  const auto connection = sensor.connect(si.p, aperture);
  if (!connection) return std::nullopt;
  SurfaceInteraction seen = si;
  seen.wi = si.frame.to_local(connection->d);
  const Rgb f = bsdf.eval_pdf(seen, Lobe::kAll, si.wi).f;
  const float factor = adjoint_factor(si, si.frame.to_world(si.wi), connection->d);
  return SeenPoint{connection->film_position, f * (factor * connection->weight),
                   si.shadow_ray(connection->d, connection->distance)};
}

}  // namespace kinome
