// Checks of the light that leaves an emitter, along rays and as light points.

#include <cmath>

#include <fmt/format.h>

#include "kinome/clustered_light.h"
#include "kinome/render_context.h"
#include "kit/scenes/emitter_scene.h"
#include "kit/scenes/rays.h"
#include "kit/statistics/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Sums of light by octant of its direction, and over all octants.
struct Octants {
  Moments sums[9][3];
  /// Adds a sample with `weight` in direction d, and 0 for all other octants.
  void add(const Vec3& d, const Rgb& weight) {
    const int octant = (d.x > 0) + 2 * (d.y > 0) + 4 * (d.z > 0);
    for (int i = 0; i < 9; ++i) {
      for (int c = 0; c < 3; ++c) {
        sums[i][c].add(i == octant || i == 8 ? static_cast<double>(weight[c]) : 0.);
      }
    }
  }
  /// Adds a variance for rounding, because all samples may have the same value.
  std::vector<Estimate> estimates() const {
    std::vector<Estimate> all;
    for (const auto& part : sums) {
      for (const Moments& m : part) {
        all.push_back({m.mean(), m.variance_of_mean() + std::pow(1e-4 * m.mean(), 2)});
      }
    }
    return all;
  }
  double total() const { return sums[8][0].mean() + sums[8][1].mean() + sums[8][2].mean(); }
};

Outcome emitter_emission(const Subject& subject, double alpha) {
  Outcome outcome;
  EmitterScene at(subject);
  Random random(subject.request().seed + 4);
  const int count = subject.samples(40000);
  Octants emitted, expected;
  int emitted_rays = 0;
  Vec3 o(0.f);
  for (int i = 0; i < count; ++i) {
    const auto ray = random_emission(at.emitter(), random);
    if (!ray) {
      emitted.add(Vec3(0, 0, 1), Rgb(0.f));
      continue;
    }
    ++emitted_rays;
    o = ray->o;
    if (!is_finite(ray->o) || !is_finite(ray->d) || std::abs(glm::length(ray->d) - 1) > 1e-4f) {
      outcome.fail("sample_emission() returns a ray that is not finite, or not of unit length");
      return outcome;
    }
    if (!is_finite(ray->power)) outcome.fail("sample_emission() returns power that is not finite");
    const bool is_distant = ray->pdf_position > 0;
    emitted.add(ray->d, is_distant ? ray->power * ray->pdf_position : ray->power);
  }
  if (emitted_rays == 0) {
    outcome.measured =
        "not implemented: light tracing and bounces in clustered ignore this emitter";
    return outcome;
  }
  for (int i = 0; i < count; ++i) {
    const auto [d, power] = at.reference_emission(random, o);
    expected.add(d, power);
  }
  if (expected.total() == 0 && at.emitter().is_surface()) {
    outcome.measured = fmt::format(
        "{} rays; nothing to compare with, because eval_surface() is 0, as for "
        "emitters that emit in single directions",
        emitted_rays);
    return outcome;
  }
  // A peak that few samples hit is not a fault; the variances account for it approximately.
  const Verdict verdict = largest_z_test(emitted.estimates(), expected.estimates(), alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) {
    outcome.fail(fmt::format("sample_emission() emits {:.4g} times the light of {}",
                             emitted.total() / expected.total(), at.value_name()));
  }
  return outcome;
}

Outcome emitter_emission_density(const Subject& subject, double alpha) {
  Outcome outcome;
  const EmitterScene at(subject);
  if (at.emitter().is_surface() || !at.emitter().emission_density(Vec3(0, 0, 1))) {
    outcome.measured = "not implemented";
    return outcome;
  }
  Random random(subject.request().seed + 5);
  std::vector<float> ratios;
  for (int i = 0; i < subject.samples(1000); ++i) {
    const auto ray = random_emission(at.emitter(), random);
    if (!ray || ray->pdf_direction == 0) continue;
    const auto density = at.emitter().emission_density(ray->d);
    const float position_density = density ? density->position : 0;
    if (std::abs(position_density - ray->pdf_position) > 2e-3f * ray->pdf_position) {
      outcome.fail(
          fmt::format("sample_emission() returns a density of positions of {:.4g}, but "
                      "emission_density() returns {:.4g}",
                      ray->pdf_position, position_density));
    }
    if (density) ratios.push_back(ratio_of(ray->pdf_direction, density->direction));
  }
  DensityCells test;
  test.sample = [&](Random& numbers) -> std::optional<Vec3> {
    const auto ray = random_emission(at.emitter(), numbers);
    if (!ray || !(ray->pdf_direction > 0)) return std::nullopt;
    return ray->d;
  };
  test.pdf = [&](const Vec3& d) {
    const auto density = at.emitter().emission_density(d);
    return density ? double{density->direction} : 0.;
  };
  test.samples = subject.samples(30000);
  test.seed = subject.request().seed + 6;
  if (!test.sample(random)) {
    outcome.measured = "parallel light, which has no density of directions";
    return outcome;
  }
  const DensityVerdict verdict = density_test(test, alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) outcome.fail(cause_of(verdict, "emission_density()"));
  if (!ratios.empty()) {
    check_ratios(ratios,
                 "sample_emission() returns densities of directions {:.4g} times those of "
                 "emission_density()",
                 outcome);
  }
  return outcome;
}

/// Returns the irradiance from light points at p, on a surface with the unit normal n.
glm::dvec3 irradiance_of(const LightPoints& points, const Vec3& p, const Vec3& n) {
  glm::dvec3 sum(0.);
  for (size_t i = 0; i < points.size(); ++i) {
    if (points.kind == LightPoints::Kind::kDistant) {
      sum += glm::dvec3(points.power[i] * std::max(0.f, glm::dot(points.position[i], n)));
      continue;
    }
    const Vec3 to = points.position[i] - p;
    const float distance2 = glm::dot(to, to);
    const Vec3 d = to / std::sqrt(distance2);
    const float cosine = -glm::dot(points.normal[i], d);
    if (!(cosine > 0)) continue;
    const Rgb intensity = points.is_lambertian(i)
                              ? points.power[i] * cosine
                              : points.emission->intensity(points.emission_id[i], -d);
    sum += glm::dvec3(intensity * (std::max(0.f, glm::dot(d, n)) / distance2));
  }
  return sum;
}

/// Compares the irradiance from light points with that from sample_direct(), at some points and
/// summed over them. The finite number of light points causes errors of a few percent.
Verdict light_points_test(const EmitterScene& at, const LightPoints& points, int count,
                          uint64_t seed, double alpha, double& ratio) {
  Random random(seed);
  std::vector<Estimate> expected, sampled;
  Estimate expected_sum, sampled_sum;
  for (int side = 0; side < 6; ++side) {
    const Vec3 p = at.random_point(random);
    Vec3 n(0.f);
    n[side / 2] = side % 2 ? -1.f : 1.f;
    const glm::dvec3 by_points = irradiance_of(points, p, n);
    Moments by_samples[3], luminances;
    for (int i = 0; i < count; ++i) {
      const auto sample = at.emitter().sample_direct(p, random.unit2());
      Rgb value(0.f);
      if (sample && sample->pdf > 0) {
        value = sample->radiance * (std::max(0.f, glm::dot(sample->d, n)) / sample->pdf);
      }
      for (int c = 0; c < 3; ++c) by_samples[c].add(double{value[c]});
      luminances.add(double{luminance(value)});
    }
    for (int c = 0; c < 3; ++c) {
      const Moments& m = by_samples[c];
      expected.push_back({by_points[c], std::pow(0.02 * by_points[c], 2)});
      sampled.push_back({m.mean(), m.variance_of_mean()});
    }
    expected_sum.mean += double{luminance(Rgb(by_points))};
    sampled_sum.mean += luminances.mean();
    sampled_sum.variance_of_mean += luminances.variance_of_mean();
  }
  ratio = expected_sum.mean / sampled_sum.mean;
  expected_sum.variance_of_mean = std::pow(0.01 * expected_sum.mean, 2);
  expected.push_back(expected_sum);
  sampled.push_back(sampled_sum);
  return largest_z_test(expected, sampled, alpha);
}

/// Checks light_points(), which `clustered` uses with the importances of the thesis.
Outcome emitter_light_points(const Subject& subject, double alpha) {
  Outcome outcome;
  const EmitterScene at(subject);
  RenderContext context({.threads = 1, .seed = subject.request().seed});
  constexpr uint32_t kCount = 4096;
  // Points that are derived by probing aren't the plugin's.
  const ClusteredLight* const own = clustered_light(at.emitter());
  const auto points = own ? own->light_points(at.scene(), context, kCount) : std::nullopt;
  if (!points) {
    outcome.measured =
        "not implemented: clustered with the importances of the thesis ignores this emitter, or "
        "probes it if it is an environment";
    return outcome;
  }
  const size_t count = points->size();
  const bool is_local = points->kind == LightPoints::Kind::kLocal;
  if (points->power.size() != count || points->extent.size() != count ||
      (is_local && points->normal.size() != count)) {
    outcome.fail("light_points() has columns of different lengths");
    return outcome;
  }
  for (size_t i = 0; i < count; ++i) {
    if (!is_finite(points->position[i]) || !is_finite(points->power[i])) {
      outcome.fail("light_points() has a value that is not finite");
    }
    if (!(points->extent[i] > 0)) outcome.fail("light_points() has an extent that is not positive");
    const Vec3 direction = is_local ? points->normal[i] : points->position[i];
    if (std::abs(glm::length(direction) - 1) > 1e-4f) {
      outcome.fail("light_points() has a direction that is not of unit length");
    }
  }
  outcome.measured = fmt::format("{} points", count);
  if (!outcome.passed) return outcome;
  double ratio = 0;
  const Verdict verdict = light_points_test(at, *points, subject.samples(10000),
                                            subject.request().seed + 8, alpha, ratio);
  outcome.measured = fmt::format("{} points, {:.4g} times the irradiance: {}", count, ratio,
                                 verdict.text);
  if (!verdict.passed) {
    outcome.fail(
        fmt::format("light_points() has {:.2g} times the light of sample_direct()", ratio));
  }
  return outcome;
}

}  // namespace

void add_emission_checks(const Subject& subject, Plan& plan) {
  plan.add("emission", 1, [&](double alpha) { return emitter_emission(subject, alpha); });
  plan.add("emission_density", 1,
           [&](double alpha) { return emitter_emission_density(subject, alpha); });
  plan.add("light_points", 1,
           [&](double alpha) { return emitter_light_points(subject, alpha); });
}

}  // namespace kinome::check
