// Checks whether a BSDF's samples agree with its values and densities, at a point of a scene.

#include "kinome/warp.h"
#include "audit/audit_words.h"
#include "audit/object_audit.h"
#include "audit/rounding.h"

namespace kinome {
namespace {

/// Ranges of f and of the density around a direction.
struct Neighbourhood {
  ColorRange f;
  ValueRange pdf;
  Neighbourhood(const Bsdf& bsdf, const SurfaceInteraction& si, const Vec3& wo) {
    for (const Vec3& neighbour : neighbours(wo)) {
      const BsdfValue value = bsdf.eval_pdf(si, Lobe::kAll, neighbour);
      f.add(value.f);
      pdf.add(static_cast<double>(value.pdf));
    }
  }
};

}  // namespace

const char* find_invalid_value(const Bsdf& bsdf, const AuditPlace& place) {
  const SurfaceInteraction& si = *place.si;
  const auto evaluate = [&](const Vec3& wo) -> const char* {
    const BsdfValue value = bsdf.eval_pdf(si, Lobe::kAll, wo);
    if (!is_finite(value.f)) return audit_words::kValue;
    return is_density(value.pdf) ? nullptr : audit_words::kDensity;
  };
  if (const auto sample = bsdf.sample(si, Lobe::kAll, place.u(0), place.u2(1))) {
    if (!is_finite(sample->wo)) return audit_words::kDirection;
    if (!is_density(sample->pdf)) return audit_words::kDensity;
    if (!is_finite(sample->weight)) return audit_words::kValue;
    if (const char* const fault = evaluate(sample->wo)) return fault;
  }
  return evaluate(square_to_uniform_sphere(place.u2(3)));
}

const char* find_contradiction(const Bsdf& bsdf, const AuditPlace& place) {
  const SurfaceInteraction& si = *place.si;
  return confirmed([&](uint64_t attempt) -> const char* {
    const uint64_t u = first_number(attempt);
    const BsdfValue value =
        bsdf.eval_pdf(si, Lobe::kAll, square_to_uniform_sphere(place.u2(u + 3)));
    constexpr float kMinValue = 1e-30f;
    if (value.pdf == 0 && max_component(glm::abs(value.f)) > kMinValue) {
      return audit_words::kLightWithoutDensity;
    }
    const auto sample = bsdf.sample(si, Lobe::kAll, place.u(u), place.u2(u + 1));
    if (!sample) return nullptr;
    if (!is_unit(sample->wo)) return audit_words::kLength;
    if (any(sample->lobe & Lobe::kDelta) || !(sample->pdf > 0 && sample->pdf < kInfinity)) {
      return nullptr;
    }
    const Neighbourhood around(bsdf, si, sample->wo);
    if (!around.pdf.agrees_with(static_cast<double>(sample->pdf))) return audit_words::kBsdfPdf;
    return around.f.agrees_with(sample->weight * sample->pdf) ? nullptr : audit_words::kBsdfWeight;
  });
}

}  // namespace kinome
