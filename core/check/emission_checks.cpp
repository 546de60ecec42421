#include "check/emission_checks.h"

#include <cmath>

#include <fmt/format.h>

#include "check/density_cells.h"
#include "check/emitter_scene.h"
#include "check/rays.h"
#include "kinome/light_points.h"
#include "kinome/render_context.h"

namespace kinome::check {
namespace {

/// Sums by the octant that light goes to.
struct Octants {
  Moments sums[8][3];
  /// `weight` toward d; all other octants get nothing.
  void add(const Vec3& d, const Rgb& weight) {
    const int octant = (d.x > 0) + 2 * (d.y > 0) + 4 * (d.z > 0);
    for (int i = 0; i < 8; ++i) {
      for (int c = 0; c < 3; ++c) {
        sums[i][c].add(i == octant ? static_cast<double>(weight[c]) : 0.);
      }
    }
  }
  std::vector<Estimate> estimates() const {
    std::vector<Estimate> all;
    for (const auto& octant : sums) {
      for (const Moments& m : octant) all.push_back({m.mean(), m.variance_of_mean()});
    }
    return all;
  }
  double total() const {
    double sum = 0;
    for (const auto& octant : sums) {
      for (const Moments& m : octant) sum += m.mean();
    }
    return sum;
  }
};

Outcome emitter_emission(const Subject& subject, double alpha) {
  Outcome outcome;
  const EmitterScene at(subject);
  Random random(subject.request().seed + 4);
  const int count = subject.samples(40000);
  Octants emitted, expected;
  int had = 0;
  Vec3 o(0.f);
  for (int i = 0; i < count; ++i) {
    const Vec2 position = random.unit2();
    const auto ray = at.emitter().sample_emission(position, random.unit2());
    if (!ray) {
      emitted.add(Vec3(0, 0, 1), Rgb(0.f));
      continue;
    }
    ++had;
    o = ray->o;
    if (!is_finite(ray->o) || !is_finite(ray->d) || std::abs(glm::length(ray->d) - 1) > 1e-4f) {
      outcome.fail("sample_emission() returns a ray that is not finite, or not of unit length");
      return outcome;
    }
    if (!is_finite(ray->power)) outcome.fail("sample_emission() returns power that is not finite");
    const bool is_distant = ray->pdf_position > 0;
    emitted.add(ray->d, is_distant ? ray->power * ray->pdf_position : ray->power);
  }
  if (had == 0) {
    outcome.measured = "not offered: light tracing, and light after bounces by clustered, miss it";
    return outcome;
  }
  for (int i = 0; i < count; ++i) {
    const auto [d, power] = at.reference_emission(random, o);
    expected.add(d, power);
  }
  if (expected.total() == 0 && at.emitter().is_surface()) {
    outcome.measured = fmt::format("{} rays; eval_surface() is 0, as where light leaves along "
                                   "single directions: there is nothing to compare with", had);
    return outcome;
  }
  // A peak that few samples find is no fault of either side: its variance tells, roughly.
  const Verdict verdict = z_test(emitted.estimates(), expected.estimates(), alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) {
    outcome.fail(fmt::format("sample_emission() sends out {:.4g} times the light that {} has",
                             emitted.total() / expected.total(), at.value_name()));
  }
  return outcome;
}

Outcome emitter_emission_density(const Subject& subject, double alpha) {
  Outcome outcome;
  const EmitterScene at(subject);
  if (at.emitter().is_surface() || !at.emitter().emission_density(Vec3(0, 0, 1))) {
    outcome.measured = "not told";
    return outcome;
  }
  Random random(subject.request().seed + 5);
  for (int i = 0; i < subject.samples(1000); ++i) {
    const Vec2 position = random.unit2();
    const auto ray = at.emitter().sample_emission(position, random.unit2());
    if (!ray || ray->pdf_direction == 0) continue;
    const auto told = at.emitter().emission_density(ray->d);
    const float position_told = told ? told->position : 0;
    if (std::abs(position_told - ray->pdf_position) > 2e-3f * ray->pdf_position) {
      outcome.fail(fmt::format("sample_emission() has density {:.4g} of positions, and "
                               "emission_density() {:.4g}",
                               ray->pdf_position, position_told));
    }
  }
  DensityCells test;
  test.sample = [&](Random& numbers) -> std::optional<Vec3> {
    const Vec2 position = numbers.unit2();
    const auto ray = at.emitter().sample_emission(position, numbers.unit2());
    if (!ray || !(ray->pdf_direction > 0)) return std::nullopt;
    return ray->d;
  };
  test.pdf = [&](const Vec3& d) {
    const auto told = at.emitter().emission_density(d);
    return told ? double{told->direction} : 0.;
  };
  test.samples = subject.samples(30000);
  test.seed = subject.request().seed + 6;
  if (!test.sample(random)) {
    outcome.measured = "parallel light: no density of directions";
    return outcome;
  }
  const DensityVerdict verdict = density_test(test, alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) outcome.fail(cause_of(verdict, "emission_density()"));
  return outcome;
}

/// Points that stand for all of its light: as `clustered` by the thesis's importances asks for them.
Outcome emitter_light_points(const Subject& subject) {
  Outcome outcome;
  const EmitterScene at(subject);
  RenderContext context({.threads = 1, .seed = subject.request().seed});
  constexpr uint32_t kCount = 4096;
  const auto points = at.emitter().light_points(at.scene(), context, kCount);
  if (!points) {
    outcome.measured = "not offered: clustered by the thesis's importances doesn't see it";
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
  return outcome;
}

}  // namespace

void add_emission_checks(const Subject& subject, Plan& plan) {
  plan.add("emission", 1, [&](double alpha) { return emitter_emission(subject, alpha); });
  plan.add("emission_density", 1,
           [&](double alpha) { return emitter_emission_density(subject, alpha); });
  plan.add("light_points", 0, [&](double) { return emitter_light_points(subject); });
}

}  // namespace kinome::check
