// Checks of phase functions.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/phase.h"
#include "kit/scenes/block_memory.h"
#include "kit/statistics/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Points with frames of all directions.
MediumPoint phase_point(Random& random) {
  const Vec2 xy = random.unit2();
  const Vec3 p = 2.f * Vec3(xy, random.unit()) - 0.5f;
  return {p, Frame::from_normal(random.direction())};
}

Outcome phase_values(const Subject& subject) {
  Outcome outcome;
  const auto phase = subject.make<Phase>();
  Random random(subject.request().seed + 1);
  const int count = subject.samples(10000);
  for (int i = 0; i < count && outcome.passed; ++i) {
    const MediumPoint point = phase_point(random);
    const float value = phase->eval(point, random.direction());
    if (!(value >= 0) || !std::isfinite(value)) {
      outcome.fail(fmt::format("eval() is {}: it must be finite and not negative", value));
    }
    const float u1 = i % 50 == 0 ? 0 : random.unit();
    const Vec2 u2 = i % 50 == 1 ? Vec2(0) : i % 50 == 2 ? Vec2(kOneMinusEpsilon) : random.unit2();
    const PhaseSample drawn = phase->sample(point, u1, u2);
    if (drawn.pdf == 0) continue;
    if (!(std::abs(glm::length(drawn.wo) - 1) < 1e-4f)) {
      outcome.fail("sample() returns a direction that is not of unit length");
    }
    const float density = phase->eval(point, drawn.wo);
    if (!(std::abs(drawn.pdf - density) <= 0.01f * density)) {
      outcome.fail(
          fmt::format("sample() returns the density {:.5g} for a direction, but eval() "
                      "returns {:.5g}",
                      drawn.pdf, density));
    }
    const float area = phase->projected_area(point.p, point.frame.n);
    if (!(area >= phase->min_projected_area() && area <= phase->max_projected_area())) {
      outcome.fail(fmt::format("projected_area() is {:.5g}, which is outside of its bounds", area));
    }
    if (!phase->is_oriented() && area != 1) {
      outcome.fail("projected_area() isn't 1, but is_oriented_ is false");
    }
  }
  float weights = 0;
  for (const HgLobe& lobe : phase->lobes()) {
    weights += lobe.weight;
    if (!(std::abs(lobe.g) < 1 && lobe.weight >= 0)) outcome.fail("lobes() returns invalid lobes");
  }
  if (!(std::abs(weights - 1) < 1e-4f)) outcome.fail("the weights of lobes() don't add up to 1");
  outcome.measured = fmt::format("{} directions", count);
  return outcome;
}

Outcome phase_sampling(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto phase = subject.make<Phase>();
  const MediumPoint points[] = {
      {Vec3(0.3f, 0.4f, 0.6f), Frame::from_normal(Vec3(0, 0, 1))},
      {Vec3(0.8f, 0.1f, 0.7f), Frame::from_normal(glm::normalize(Vec3(2, -1, -3)))}};
  uint64_t seed = subject.request().seed + 2;
  for (const MediumPoint& point : points) {
    DensityCells test;
    test.samples = subject.samples(30000);
    test.seed = seed++;
    test.sample = [&](Random& random) -> std::optional<Vec3> {
      const float u1 = random.unit();
      const PhaseSample drawn = phase->sample(point, u1, random.unit2());
      return drawn.pdf > 0 ? std::optional(drawn.wo) : std::nullopt;
    };
    test.pdf = [&](const Vec3& wo) { return double{phase->eval(point, wo)}; };
    const DensityVerdict verdict = density_test(test, alpha);
    outcome.measured = fmt::format("{}; eval() integrates to {:.4g}", verdict.text, verdict.mass);
    if (verdict.passed) continue;
    const double ratio = verdict.mass / verdict.accepted;
    outcome.fail(std::abs(ratio - 1) > 0.03
                     ? fmt::format("eval() integrates to {:.4g}, expected 1", verdict.mass)
                     : "samples don't follow eval()");
  }
  return outcome;
}

Outcome phase_blocks(const Subject& subject) {
  Outcome outcome;
  const auto phase = subject.make<Phase>();
  Random random(subject.request().seed + 4);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  MediumPointBlock points{count, memory.three(), memory.three(), memory.three(), memory.three()};
  const Columns3 wo = memory.three(), drawn = memory.three();
  const Columns2 u2 = memory.two();
  float *const u1 = memory.one(), *const value = memory.one(), *const pdf = memory.one(),
               *const area = memory.one();
  for (size_t i = 0; i < count; ++i) {
    const MediumPoint point = phase_point(random);
    points.p.set(i, point.p);
    points.s.set(i, point.frame.s);
    points.t.set(i, point.frame.t);
    points.n.set(i, point.frame.n);
    wo.set(i, random.direction());
    u1[i] = random.unit();
    u2.set(i, random.unit2());
  }
  phase->eval_block(points, wo, value);
  phase->sample_block(points, u1, u2, drawn, pdf);
  phase->projected_area_block(points.p, points.n, count, area);
  int values = 0, samples = 0, areas = 0;
  for (size_t i = 0; i < count; ++i) {
    const MediumPoint point = points.at(i);
    const float expected = phase->eval(point, wo.at(i));
    values += !(std::abs(value[i] - expected) <= 2e-3f * expected + 1e-30f);
    const PhaseSample sample = phase->sample(point, u1[i], u2.at(i));
    samples += !(std::abs(pdf[i] - sample.pdf) <= 0.02f * sample.pdf &&
                 (sample.pdf == 0 || glm::length(drawn.at(i) - sample.wo) < 1e-3f));
    const float own = phase->projected_area(point.p, point.frame.n);
    areas += !(std::abs(area[i] - own) <= 2e-3f * own);
  }
  const auto judge = [&](int wrong, const std::string& what) {
    outcome.fail_if_many(wrong, static_cast<int>(count), 100, what + " at {} of {} points");
  };
  judge(values, "eval_block() differs from eval()");
  judge(samples, "sample_block() differs from sample()");
  judge(areas, "projected_area_block() differs from projected_area()");
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured = fmt::format("blocks of {} points compared with single points", count);
  return outcome;
}

}  // namespace

void add_phase_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return phase_values(subject); });
  plan.add("sampling", 2, [&](double alpha) { return phase_sampling(subject, alpha); });
  plan.add("blocks", 0, [&](double) { return phase_blocks(subject); });
}

}  // namespace kinome::check
