// Checks whether an emitter's samples agree with its surface or its environment, as seen from a
// point of a scene.

#include "kinome/clustered_light.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "audit/audit_words.h"
#include "audit/environment_audit.h"
#include "audit/object_audit.h"
#include "audit/rounding.h"

namespace kinome {
namespace {

/// Index of a random number that isn't used elsewhere.
constexpr uint64_t kFreeNumber = 50;

/// Rays look for the shape within this distance of the sampled point, relative to the distance of
/// the point.
constexpr float kWindow = 1e-3f;

/// Returns true if rounding changes the cosine at the surface by less than a tenth of the tolerance
/// of ValueRange.
bool is_resolved(const SurfaceInteraction& light, const SurfaceInteraction& from) {
  const float height = std::abs(glm::dot(light.n, from.p - light.p));
  return height > 1e4f * (light.p_error + from.p_error);
}

/// Result of tracing rays around a sample's direction, limited to the neighbourhood of the sampled
/// point on the emitter's shape.
struct Traced {
  bool is_missed = false;  ///< no ray hits anything
  bool is_known = false;   ///< `pdf` and `radiance` belong to the sampled point
  ValueRange pdf;
  ColorRange radiance;
};

/// Returns true if a hit is on the face or curved surface that was sampled. Another one that is
/// near, or intersects it, has different densities.
bool is_of_sample(const SurfaceInteraction& hit, const AuditPlace& place,
                  const DirectSample& sample) {
  const Vec3 sampled = place.si->p + sample.d * sample.distance;
  const float rounding = 4 * hit.p_error + 1e-6f * sample.distance + 0.05f * place.si->p_error;
  return std::abs(glm::dot(hit.n, sampled - hit.p)) <= rounding;
}

Traced trace(const Emitter& emitter, const AuditPlace& place, const DirectSample& sample) {
  std::array<RayHit, 9> rays;
  const auto directions = neighbours(sample.d);
  for (size_t i = 0; i < rays.size(); ++i) {
    rays[i].ray.o = place.si->p;
    rays[i].ray.d = directions[i];
    rays[i].ray.tmin = sample.distance * (1 - kWindow);
    rays[i].ray.tmax = sample.distance * (1 + kWindow);
  }
  RenderCounters counters;
  place.scene.intersect(rays, Coherence::kCoherent, counters);
  Traced traced;
  traced.is_missed = true;
  for (const RayHit& hit : rays) {
    if (!hit.hit.valid()) continue;
    traced.is_missed = false;
    const SurfaceInteraction si = place.scene.interaction(hit);
    if (si.shape != emitter.shape()) continue;
    if (!is_resolved(si, *place.si) || !is_of_sample(si, place, sample)) return {};
    traced.is_known = true;
    traced.pdf.add(static_cast<double>(emitter.pdf_surface(place.si->p, si)));
    traced.radiance.add(emitter.eval_surface(si));
  }
  return traced;
}

/// Returns true if the emitter is about as small as the rounding error of coordinates. Its solid
/// angle is estimated from the density.
bool is_too_small(const AuditPlace& place, const DirectSample& sample) {
  const float extent = max_component(glm::abs(place.si->p)) + sample.distance;
  const float angle = 4 * (kDirectionError * extent + place.si->p_error) / sample.distance;
  return sample.pdf * sqr(angle) > 1e-4f;
}

/// Returns true if the emitter is seen at a grazing angle, where rays may miss it due to rounding.
bool is_grazing(const Emitter& emitter, const DirectSample& sample) {
  return !(sqr(sample.distance) > 0.05f * sample.pdf * emitter.shape()->area());
}

const char* surface_contradiction(const Emitter& emitter, const AuditPlace& place,
                                  const DirectSample& sample) {
  if (!place.si || place.si->shape == emitter.shape()) return nullptr;
  if (!(sample.distance > 0 && sample.distance < kInfinity)) return nullptr;
  if (is_too_small(place, sample)) return nullptr;
  const Traced traced = trace(emitter, place, sample);
  if (traced.is_missed && !is_grazing(emitter, sample)) return audit_words::kOffSurface;
  if (!traced.is_known) return nullptr;
  if (!traced.pdf.agrees_with(static_cast<double>(sample.pdf))) return audit_words::kSurfacePdf;
  return traced.radiance.agrees_with(sample.radiance) ? nullptr : audit_words::kSurfaceRadiance;
}

const char* contradiction_of_sample(const Emitter& emitter, const AuditPlace& place,
                                    const DirectSample& sample) {
  if (!(sample.pdf > 0 && sample.pdf < kInfinity)) return nullptr;
  if (!is_unit(sample.d)) return audit_words::kLength;
  if (sample.is_delta) return sample.pdf == 1 ? nullptr : audit_words::kDeltaPdf;
  if (emitter.is_environment()) return environment_contradiction(emitter, sample);
  return emitter.shape() ? surface_contradiction(emitter, place, sample) : nullptr;
}

bool is_same(const DirectSample& a, const DirectSample& b) {
  ColorRange radiance;
  ValueRange pdf;
  radiance.add(a.radiance);
  pdf.add(static_cast<double>(a.pdf));
  return glm::length(a.d - b.d) < kDirectionError && radiance.agrees_with(b.radiance) &&
         pdf.agrees_with(static_cast<double>(b.pdf)) && a.is_delta == b.is_delta;
}

/// Returns the sample of sample_direct_block() for a block with one point.
DirectSample first_of_block(const Emitter& emitter, const Vec3& p, const Vec2& u) {
  alignas(kColumnAlignment) float columns[14][kBlockLanes];
  const auto column = [&](size_t k) { return columns[k]; };
  const Columns3 from{column(0), column(1), column(2)};
  const Columns2 numbers{column(3), column(4)};
  for (size_t i = 0; i < kBlockLanes; ++i) {
    from.set(i, p);
    numbers.set(i, u);
  }
  const DirectBlock block{{column(5), column(6), column(7)},
                          column(8),
                          column(9),
                          {column(10), column(11), column(12)},
                          column(13)};
  emitter.sample_direct_block(from, numbers, 1, block);
  DirectSample sample;
  sample.d = block.d.at(0);
  sample.distance = block.distance[0];
  sample.pdf = block.pdf[0];
  sample.radiance = block.radiance.at(0);
  sample.is_delta = block.is_delta[0] > 0;
  return sample;
}

const char* contradiction_of_samples(const Emitter& emitter, const AuditPlace& place,
                                     uint64_t attempt) {
  const Vec3 p = place.p();
  const Vec2 u = place.u2(first_number(attempt));
  const auto sample = emitter.sample_direct(p, u);
  const bool has_sample = sample && sample->pdf > 0;
  if (has_sample) {
    if (const char* const fault = contradiction_of_sample(emitter, place, *sample)) return fault;
  }
  // For a small or distant surface, the different rounding of vector code may miss it entirely.
  if (!emitter.is_environment()) return nullptr;
  const DirectSample in_block = first_of_block(emitter, p, u);
  if (has_sample != (in_block.pdf > 0) || (has_sample && !is_same(*sample, in_block))) {
    return audit_words::kSampleBlock;
  }
  return nullptr;
}

}  // namespace

const char* find_invalid_value(const Emitter& emitter, const AuditPlace& place) {
  if (place.si && !emitter.is_indirect()) {
    const auto sample = emitter.sample_direct(place.si->p, place.u2(0));
    if (sample && !is_density(sample->pdf)) return audit_words::kDensity;
    if (sample && sample->pdf > 0 && !is_finite(sample->d)) return audit_words::kDirection;
    if (sample && sample->pdf > 0 && !is_finite(sample->radiance)) return audit_words::kValue;
  }
  if (emitter.is_environment()) {
    if (!is_finite(emitter.eval_environment(place.d))) return audit_words::kValue;
    if (!is_density(emitter.pdf_environment(place.d))) return audit_words::kDensity;
  }
  if (place.si && emitter.shape() && emitter.shape() == place.si->shape) {
    if (!is_finite(emitter.eval_surface(*place.si))) return audit_words::kValue;
    const Vec3 from = place.si->p - place.d;
    if (!is_density(emitter.pdf_surface(from, *place.si))) return audit_words::kDensity;
  }
  return nullptr;
}

const char* find_contradiction(const Emitter& emitter, const AuditPlace& place) {
  if (emitter.is_indirect() || (!place.si && !emitter.is_environment())) return nullptr;
  const char* fault = confirmed(
      [&](uint64_t attempt) { return contradiction_of_samples(emitter, place, attempt); });
  if (fault || !emitter.is_environment()) return fault;
  for (const Vec3& d : {place.d, square_to_uniform_sphere(place.u2(kFreeNumber))}) {
    if (emitter.pdf_environment(d) == 0 && !is_black(emitter.eval_environment(d))) {
      return audit_words::kLightWithoutDensity;
    }
  }
  const auto grid = cell_grid_of(emitter);
  if (!grid) return nullptr;
  return confirmed(
      [&](uint64_t attempt) { return grid_contradiction(emitter, *grid, place, attempt); });
}

}  // namespace kinome
