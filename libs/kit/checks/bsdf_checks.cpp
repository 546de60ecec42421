// Checks of BSDFs: whether values, densities and samples are valid and agree with one another.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/bsdf_points.h"
#include "kit/scenes/emitter_scene.h"
#include "kit/statistics/density_cells.h"
#include "kit/statistics/random.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

const char* find_fault(const BsdfValue& value) {
  if (!is_finite(value.f)) return "eval_pdf() returns a value that is not finite";
  if (std::min({value.f.x, value.f.y, value.f.z}) < 0) return "eval_pdf() returns a negative value";
  if (!(value.pdf >= 0)) return "eval_pdf() returns a density that is negative or NaN";
  if (value.pdf == 0 && max_component(value.f) > 1e-30f) {
    return "eval_pdf() returns a density of 0 where the value isn't 0";
  }
  return nullptr;
}

const char* find_fault(const Bsdf& bsdf, const SurfaceInteraction& si, Lobe mask,
                       const BsdfSample& sample) {
  if (!is_finite(sample.wo) || !is_finite(sample.weight)) {
    return "sample() returns a value that is not finite";
  }
  if (!(sample.pdf >= 0)) return "sample() returns a density that is negative or NaN";
  if (std::min({sample.weight.x, sample.weight.y, sample.weight.z}) < 0) {
    return "sample() returns a negative weight";
  }
  if (std::abs(glm::length(sample.wo) - 1) > 1e-4f) {
    return "sample() returns directions that are not of unit length";
  }
  if (!any(sample.lobe & bsdf.lobes())) return "sample() returns a lobe that is not in lobes_";
  if (!any(sample.lobe & mask)) return "sample() returns a lobe that was not requested";
  if (any(sample.lobe & Lobe::kDelta) && sample.pdf != 1) {
    return "sample() returns a density of a delta lobe that is not 1";
  }
  // A BSDF that turns to the viewer may reflect a little below the horizon of the shading frame.
  if (!bsdf.transmits() && !bsdf.turns_to_viewer() && sample.wo.z * si.wi.z < -1e-4f &&
      max_component(sample.weight) > 0) {
    return "sample() sends light through the surface, but transmits_ is false";
  }
  return nullptr;
}

Outcome bsdf_values(const Subject& subject) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  Random random(subject.request().seed + 1);
  const int count = subject.samples(4000);
  for (int i = 0; i < count && outcome.passed; ++i) {
    Vec3 wi = random.direction();
    if (i % 50 == 1) wi = glm::normalize(Vec3(wi.x, wi.y, 1e-4f * wi.z));  // grazing
    if (i % 50 == 2) wi = Vec3(0, 0, wi.z > 0 ? 1 : -1);
    const SurfaceInteraction si = seen_from(wi);
    for (const Lobe mask : masks_of(*bsdf)) {
      const float ends[] = {0, 0x1p-24f, 0.5f, kOneMinusEpsilon};
      const float u1 = i % 10 ? random.unit() : ends[i / 10 % 4];
      const Vec2 u2 = i % 10 ? random.unit2() : Vec2(ends[i / 40 % 4], ends[i / 160 % 4]);
      const char* fault = find_fault(bsdf->eval_pdf(si, mask, direction_for(wi, i, random)));
      if (!fault) {
        if (const auto sample = bsdf->sample(si, mask, u1, u2)) {
          fault = find_fault(*bsdf, si, mask, *sample);
        }
      }
      if (fault) {
        outcome.fail(fmt::format("{}, for wi ({:.4g}, {:.4g}, {:.4g}), u1 {}, u2 ({}, {})", fault,
                                 wi.x, wi.y, wi.z, u1, u2.x, u2.y));
      }
    }
  }
  outcome.measured = fmt::format("values, densities, directions and lobes for {} viewers", count);
  return outcome;
}

/// Compares the densities and weights of samples with eval_pdf(), by the median of their ratios.
Outcome bsdf_density(const Subject& subject) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  Random random(subject.request().seed + 2);
  std::vector<float> densities, weights;
  for (int i = 0; i < subject.samples(4000); ++i) {
    const SurfaceInteraction si = seen_from(random.direction());
    const float u1 = random.unit();
    const auto sample = bsdf->sample(si, Lobe::kAll, u1, random.unit2());
    if (!sample || any(sample->lobe & Lobe::kDelta) || !(sample->pdf > 0)) continue;
    const BsdfValue value = bsdf->eval_pdf(si, Lobe::kAll, sample->wo);
    densities.push_back(ratio_of(sample->pdf, value.pdf));
    if (luminance(value.f) > 0) {
      weights.push_back(ratio_of(luminance(sample->weight) * value.pdf, luminance(value.f)));
    }
  }
  if (densities.empty() || weights.empty()) {
    outcome.measured = "only delta lobes, or no lobes";
    return outcome;
  }
  const float density = check_ratios(
      densities, "sample() returns densities {:.4g} times those of eval_pdf()", outcome);
  const float weight =
      check_ratios(weights, "sample() returns weights {:.4g} times f / pdf of eval_pdf()", outcome);
  outcome.measured = fmt::format(
      "samples have {:.5g} times the densities of eval_pdf(), and {:.5g} "
      "times the weights f / pdf; bound 1 ± 0.002",
      density, weight);
  return outcome;
}

constexpr std::pair<float, float> kViewers[] = {{3, 10}, {40, 200}, {80, -50}, {130, 30}};
constexpr int kMaxMasks = 3;

Outcome bsdf_sampling(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  uint64_t seed = subject.request().seed + 30;
  double min_p = 2;
  for (const auto& [theta, phi] : kViewers) {
    const SurfaceInteraction si = seen_at(theta, phi);
    for (const Lobe mask : masks_of(*bsdf)) {
      DensityCells test;
      test.sample = [&](Random& random) -> std::optional<Vec3> {
        const float u1 = random.unit();
        const auto sample = bsdf->sample(si, mask, u1, random.unit2());
        if (!sample || any(sample->lobe & Lobe::kDelta) || !(sample->pdf > 0)) return std::nullopt;
        return sample->wo;
      };
      test.pdf = [&](const Vec3& wo) { return double{bsdf->eval_pdf(si, mask, wo).pdf}; };
      test.samples = subject.samples(20000);
      test.seed = ++seed;
      const DensityVerdict verdict = density_test(test, alpha);
      if (outcome.passed && verdict.p_value < min_p) {
        min_p = verdict.p_value;
        outcome.measured = fmt::format(
            "{} for the worst of {} viewers; the density integrates to "
            "{:.4g}, {:.4g} of the calls returned a sample",
            verdict.text, std::size(kViewers), verdict.mass, verdict.accepted);
      }
      if (!verdict.passed) {
        outcome.fail(fmt::format("{}, for a viewer at {} degrees", cause_of(verdict, "eval_pdf()"),
                                 theta));
      }
    }
  }
  return outcome;
}

/// Compares f(wi, wo) / |cos wo| with f(wo, wi) / |cos wi|, taking the squared index of transmitted
/// light into account.
Outcome bsdf_reciprocity(const Subject& subject) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  if (bsdf->turns_to_viewer()) {
    outcome.measured = "not reciprocal, because turns_to_viewer() is true";
    return outcome;
  }
  Random random(subject.request().seed + 5);
  const int count = subject.samples(4000);
  int different = 0;
  double worst = 1;
  for (int i = 0; i < count; ++i) {
    const Vec3 a = random.direction(), b = direction_for(a, i, random);
    if (std::abs(a.z) < 1e-3f || std::abs(b.z) < 1e-3f) continue;
    double forth = double{luminance(bsdf->eval_pdf(seen_from(a), Lobe::kAll, b).f)} *
                   double{std::abs(a.z)};
    double back = double{luminance(bsdf->eval_pdf(seen_from(b), Lobe::kAll, a).f)} *
                  double{std::abs(b.z)};
    if (a.z * b.z < 0) {
      // Refraction multiplies radiance by the squared index: f(a, b) / f(b, a) = (n_a / n_b)².
      const double index = double{bsdf->relative_index()};
      (a.z > 0 ? forth : back) *= index * index;
    }
    const double larger = std::max(forth, back);
    if (std::abs(forth - back) <= 5e-3 * larger + 1e-9) continue;
    ++different;
    worst = std::max(worst, larger / std::max(1e-9, std::min(forth, back)));
  }
  outcome.measured = fmt::format(
      "{} of {} pairs of directions differ by more than 0.005 of the "
      "value, bound 1 of 500",
      different, count);
  if (different * 500 > count) {
    outcome.fail(fmt::format("f(wi, wo) isn't f(wo, wi): they differ by a factor of up to {:.3g}{}",
                             worst, bsdf->transmits() ? ", apart from the squared index" : ""));
  }
  return outcome;
}

/// Checks energy conservation under uniform light: at most as much light leaves as arrives. The
/// radiance of light that enters another medium is multiplied by the squared index.
Outcome bsdf_energy(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  Random random(subject.request().seed + 6);
  double max_energy = 0;
  for (const auto& [theta, phi] : kViewers) {
    const SurfaceInteraction si = seen_at(theta, phi);
    const double index = double{bsdf->relative_index()};
    Moments energy[3];
    for (int i = 0; i < subject.samples(20000); ++i) {
      const float u1 = random.unit();
      const auto sample = bsdf->sample(si, Lobe::kAll, u1, random.unit2());
      double scale = 1;
      if (sample && sample->wo.z * si.wi.z < 0 && !any(sample->lobe & Lobe::kNull)) {
        scale = si.wi.z > 0 ? index * index : 1 / (index * index);
      }
      for (int c = 0; c < 3; ++c) energy[c].add(sample ? scale * double{sample->weight[c]} : 0);
    }
    for (const Moments& channel : energy) {
      max_energy = std::max(max_energy, channel.mean());
      const double excess = channel.mean() - 1.001;
      if (excess > 0 &&
          normal_two_sided(excess / std::sqrt(channel.variance_of_mean() + 1e-12)) < alpha) {
        outcome.fail(
            fmt::format("more light leaves than arrives: {:.4g} times as much, for a "
                        "viewer at {} degrees",
                        channel.mean(), theta));
      }
    }
  }
  outcome.measured =
      fmt::format("reflects and transmits at most {:.4g} of the light, bound 1", max_energy);
  return outcome;
}

Outcome bsdf_reflectance(const Subject& subject) {
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  Random random(subject.request().seed + 7);
  const int count = subject.samples(1000);
  for (int i = 0; i < count; ++i) {
    const Vec3 wi = random.direction();
    const SurfaceInteraction si = seen_from(wi);
    const LobeReflectance parts = bsdf->reflectance(si);
    for (const auto& [lobe, part] :
         {std::pair(Lobe::kDiffuse, parts.diffuse), std::pair(Lobe::kGlossy, parts.glossy)}) {
      if (!is_finite(part) || std::min({part.x, part.y, part.z}) < 0) {
        outcome.fail("reflectance() is negative or not finite");
      }
      const Vec3 wo = direction_for(wi, i, random);
      const bool is_lit = is_black(part) && wo.z * wi.z > 0 &&
                          !is_black(bsdf->eval_pdf(si, lobe, wo).f);
      if (is_lit) {
        outcome.fail(fmt::format("reflectance() has no {} part where eval_pdf() has one",
                                 lobe == Lobe::kDiffuse ? "diffuse" : "glossy"));
      }
      const bool is_declared = any(bsdf->lobes() & lobe);
      if (!is_declared && !is_black(bsdf->eval_pdf(si, lobe, wo).f)) {
        outcome.fail("eval_pdf() has values of a lobe that is not in lobes_");
      }
    }
    if (std::abs(glm::length(bsdf->reflection_frame(si).n) - 1) > 1e-4f) {
      outcome.fail("reflection_frame() has a normal that is not of unit length");
    }
  }
  outcome.measured = fmt::format("reflectance() for {} viewers", count);
  return outcome;
}

/// Returns the mean weight and the fraction of samples with Lobe::kNull, by the midpoint rule over
/// u1.
NullTransmission sampled_transmission(const Bsdf& bsdf, const SurfaceInteraction& si,
                                      const Vec2& u2, int steps) {
  NullTransmission sum;
  for (int k = 0; k < steps; ++k) {
    const float u1 = (static_cast<float>(k) + 0.5f) / static_cast<float>(steps);
    const auto sample = bsdf.sample(si, Lobe::kAll, u1, u2);
    if (!sample || !any(sample->lobe & Lobe::kNull)) continue;
    sum.transmittance += sample->weight / static_cast<float>(steps);
    sum.probability += 1 / static_cast<float>(steps);
  }
  return sum;
}

Outcome bsdf_null_transmission(const Subject& subject) {
  constexpr int kSteps = 1000;
  constexpr float kMaxError = 5e-3f;
  Outcome outcome;
  const auto bsdf = subject.make<Bsdf>();
  Random random(subject.request().seed + 9);
  float worst = 0;
  for (int i = 0; i < subject.samples(200); ++i) {
    SurfaceInteraction si = seen_from(random.direction());
    si.uv = random.unit2();
    const NullTransmission sampled = sampled_transmission(*bsdf, si, random.unit2(), kSteps);
    if (!bsdf->has_null_lobe() && sampled.probability > 0) {
      outcome.fail("sample() returns Lobe::kNull, but has_null_lobe_ is false");
    }
    const NullTransmission returned = bsdf->null_transmission(si);
    const Vec3 error = glm::abs(returned.transmittance - sampled.transmittance);
    worst = std::max(
        {worst, max_component(error), std::abs(returned.probability - sampled.probability)});
  }
  outcome.measured = fmt::format(
      "null_transmission() differs from samples by up to {:.2g}, bound "
      "{:.2g}",
      worst, kMaxError);
  if (!(worst <= kMaxError)) {
    outcome.fail(
        fmt::format("null_transmission() differs from samples with Lobe::kNull by {:.2g}", worst));
  }
  return outcome;
}

}  // namespace

void add_bsdf_checks(const Subject& subject, Plan& plan) {
  constexpr int kTests = kMaxMasks * static_cast<int>(std::size(kViewers));
  plan.add("values", 0, [&](double) { return bsdf_values(subject); });
  plan.add("density", 0, [&](double) { return bsdf_density(subject); });
  plan.add("sampling", kTests, [&](double alpha) { return bsdf_sampling(subject, alpha); });
  plan.add("reciprocity", 0, [&](double) { return bsdf_reciprocity(subject); });
  plan.add("energy", kTests, [&](double alpha) { return bsdf_energy(subject, alpha); });
  plan.add("reflectance", 0, [&](double) { return bsdf_reflectance(subject); });
  plan.add("straight", 0, [&](double) { return bsdf_null_transmission(subject); });
  plan.add("blocks", 0, [&](double) { return bsdf_blocks(subject); });
  plan.add("consistency", 0, [&](double) {
    return audit(subject, [](const std::string&) { return true; });
  });
}

}  // namespace kinome::check
