// Checks of emitters: light that arrives at a point. emission_checks.cpp checks light that leaves
// an emitter.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "kinome/block_points.h"
#include "kinome/clustered_light.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "kit/scenes/block_memory.h"
#include "kit/scenes/emitter_scene.h"
#include "kit/scenes/rays.h"
#include "kit/statistics/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

const char* find_fault(const DirectSample& sample) {
  if (!(sample.pdf >= 0)) return "sample_direct() returns a density that is negative or NaN";
  if (sample.pdf == 0) return nullptr;
  if (!is_finite(sample.d)) return "sample_direct() returns a direction that is not finite";
  if (std::abs(glm::length(sample.d) - 1) > 1e-4f) {
    return "sample_direct() returns directions that are not of unit length";
  }
  if (!(sample.distance > 0)) return "sample_direct() returns a distance that is not positive";
  if (!is_finite(sample.radiance)) return "sample_direct() returns a radiance that is not finite";
  return nullptr;
}

/// Returns a fault if too much of the light is negative. A little is accepted, because photographs
/// and colours outside of the gamut may have negative channels.
std::string negative_of(float sum, float negative) {
  const float share = -negative / sum;
  return share > 0.01f ? fmt::format("radiance is negative for {:.3g} of the light", share) : "";
}

Outcome emitter_values(const Subject& subject) {
  Outcome outcome;
  const EmitterScene at(subject);
  Random random(subject.request().seed + 1);
  const int count = subject.samples(4000);
  float sum = 0, negative = 0;  // sums of luminance
  const float ends[] = {0, 0x1p-24f, 0.5f, kOneMinusEpsilon};
  int lit = 0;
  for (int i = 0; i < count; ++i) {
    const Vec2 u = i < 16 ? Vec2(ends[i / 4], ends[i % 4]) : random.unit2();
    const auto sample = at.emitter().sample_direct(at.random_point(random), u);
    if (!sample) continue;
    if (const char* const fault = find_fault(*sample)) {
      outcome.fail(fmt::format("{}, for u = ({}, {})", fault, u.x, u.y));
      return outcome;
    }
    lit += sample->pdf > 0;
    if (!(sample->pdf > 0)) continue;
    const float light = luminance(sample->radiance) / sample->pdf;
    sum += std::abs(light);
    negative += std::min(light, 0.f);
  }
  for (int i = 0; at.emitter().is_environment() && i < count; ++i) {
    Vec3 d = random.direction();
    if (i < 6) d = Vec3(i / 2 == 0, i / 2 == 1, i / 2 == 2) * (i % 2 ? 1.f : -1.f);
    const Rgb radiance = at.emitter().eval_environment(d);
    const float pdf = at.emitter().pdf_environment(d);
    const std::string where = fmt::format("toward ({}, {}, {})", d.x, d.y, d.z);
    if (!is_finite(radiance)) outcome.fail("eval_environment() is not finite " + where);
    if (!(pdf >= 0 && std::isfinite(pdf))) {
      outcome.fail(fmt::format("pdf_environment() is {} {}", pdf, where));
    }
  }
  const std::string fault = negative_of(sum, negative);
  if (!fault.empty()) outcome.fail(fault);
  outcome.measured = fmt::format("{} samples, {} with light", count, lit);
  return outcome;
}

/// Compares the density of samples with pdf_environment() or pdf_surface(), by the median of their
/// ratios.
Outcome emitter_density(const Subject& subject) {
  Outcome outcome;
  const EmitterScene at(subject);
  Random random(subject.request().seed + 2);
  std::vector<float> ratios;
  for (int i = 0; i < subject.samples(2000); ++i) {
    const Vec3 p = at.random_point(random);
    const auto sample = at.emitter().sample_direct(p, random.unit2());
    if (!sample || !(sample->pdf > 0)) continue;
    const auto pdf = at.pdf_of(p, *sample);
    if (pdf) ratios.push_back(ratio_of(sample->pdf, *pdf));
  }
  if (ratios.empty()) {
    outcome.measured = "no samples to check";
    return outcome;
  }
  const float ratio = check_ratios(
      ratios,
      std::string("sample_direct() returns densities {:.4g} times those of ") + at.pdf_name(),
      outcome);
  outcome.measured = fmt::format("samples have {:.5g} times the densities of {}, bound 1 ± 0.002",
                                 ratio, at.pdf_name());
  return outcome;
}

constexpr int kEmitterPoints = 3;

Outcome emitter_sampling(const Subject& subject, double alpha) {
  Outcome outcome;
  const EmitterScene at(subject);
  const int points = at.emitter().is_environment() ? 1 : kEmitterPoints;
  for (int i = 0; i < points; ++i) {
    Random around(subject.request().seed + 30 + static_cast<uint64_t>(i));
    const Vec3 p = at.random_point(around);
    DensityCells test;
    test.sample = [&](Random& random) -> std::optional<Vec3> {
      const auto sample = at.emitter().sample_direct(p, random.unit2());
      if (!sample || !(sample->pdf > 0)) return std::nullopt;
      return sample->d;
    };
    test.pdf = [&](const Vec3& d) { return at.pdf_along(p, d); };
    test.samples = subject.samples(30000);
    test.seed = subject.request().seed + 40 + static_cast<uint64_t>(i);
    const DensityVerdict verdict = density_test(test, alpha);
    if (outcome.passed) {
      outcome.measured =
          fmt::format("{}; {} integrates to {:.4g}, {:.4g} of the calls returned a sample",
                      verdict.text, at.pdf_name(), verdict.mass, verdict.accepted);
    }
    if (!verdict.passed) outcome.fail(cause_of(verdict, at.pdf_name()));
  }
  return outcome;
}

/// Checks an emitter whose light arrives at a point from a single direction.
Outcome emitter_delta(const Subject& subject) {
  Outcome outcome;
  const EmitterScene at(subject);
  Random random(subject.request().seed + 3);
  int seen = 0;
  for (int i = 0; i < subject.samples(1000); ++i) {
    const Vec3 p = at.random_point(random);
    const auto a = at.emitter().sample_direct(p, Vec2(kNan));
    const auto b = at.emitter().sample_direct(p, random.unit2());
    if (a.has_value() != b.has_value()) {
      outcome.fail("whether sample_direct() returns a sample depends on u");
    }
    if (!a || !b) continue;
    ++seen;
    if (!a->is_delta || a->pdf != 1)
      outcome.fail("a sample's is_delta is false or its pdf is not 1");
    if (glm::length(a->d - b->d) > 1e-6f || a->radiance != b->radiance) {
      outcome.fail("sample_direct() depends on u, which may be NaN here");
    }
  }
  outcome.measured = fmt::format("a single direction from each of {} lit points", seen);
  return outcome;
}

// ---- blocks

/// Number of a block's results that differ from those of single points, except for rounding.
struct EmitterDifferences {
  int count = 0, different = 0;
  void add(bool is_same) {
    ++count;
    different += !is_same;
  }
};

bool is_near(const Vec3& a, const Vec3& b) {
  const float larger = std::max(max_component(glm::abs(a)), max_component(glm::abs(b)));
  return max_component(glm::abs(a - b)) <= 2e-3f * larger + 1e-12f;
}

/// Compares eval_surface_block() with eval_surface() and pdf_surface() at points of the emitter's
/// surface.
EmitterDifferences surface_differences(const EmitterScene& at, Random& random) {
  const Shape& shape = *at.emitter().shape();
  EmitterDifferences differences;
  BlockMemory memory(1);
  const Columns3 from = memory.three(), radiance = memory.three();
  float* const pdf = memory.one();
  for (int i = 0; i < 300; ++i) {
    SurfaceInteraction si = shape.sample_surface(random.unit2());
    si.shape = &shape;
    const Vec3 p = at.random_point(random);
    si.wi = si.frame.to_local(glm::normalize(p - si.p));
    const PointBlock point(si);
    for (size_t lane = 0; lane < kBlockLanes; ++lane) from.set(lane, p);
    at.emitter().eval_surface_block(point.block(), from, radiance, pdf);
    differences.add(is_near(at.emitter().eval_surface(si), radiance.at(0)) &&
                    is_near(Vec3(at.emitter().pdf_surface(p, si)), Vec3(pdf[0])));
  }
  return differences;
}

/// Random arguments of an emitter's block functions.
struct EmitterBlockPoints {
  size_t count;
  Columns3 p, d;
  Columns2 u;
};

/// Compares sample_direct_block() with sample_direct().
EmitterDifferences direct_differences(const Emitter& emitter, const EmitterBlockPoints& at,
                                      BlockMemory& memory) {
  const DirectBlock direct{memory.three(), memory.one(), memory.one(), memory.three(),
                           memory.one()};
  emitter.sample_direct_block(at.p, at.u, at.count, direct);
  EmitterDifferences samples;
  for (size_t i = 0; i < at.count; ++i) {
    const auto a = emitter.sample_direct(at.p.at(i), at.u.at(i));
    const bool has = a && a->pdf > 0;
    samples.add(has == (direct.pdf[i] > 0) &&
                (!has || (is_near(a->d, direct.d.at(i)) &&
                          is_near(Vec3(a->pdf), Vec3(direct.pdf[i])) &&
                          is_near(a->radiance, direct.radiance.at(i)))));
  }
  return samples;
}

/// Compares eval_environment_block() and eval_environment_batch() with eval_environment(). Returns
/// the differences of both.
std::pair<EmitterDifferences, EmitterDifferences> environment_differences(
    const Emitter& emitter, const EmitterBlockPoints& at, BlockMemory& memory) {
  const Columns3 radiance = memory.three();
  float* const pdf = memory.one();
  emitter.eval_environment_block(at.d, at.count, radiance, pdf);
  std::vector<Vec3> directions(at.count);
  std::vector<Rgb> batch(at.count);
  std::vector<float> batch_pdf(at.count);
  for (size_t i = 0; i < at.count; ++i) directions[i] = at.d.at(i);
  eval_environment(emitter, directions, batch, batch_pdf);
  EmitterDifferences blocks, batches;
  for (size_t i = 0; i < at.count; ++i) {
    const Rgb value = emitter.eval_environment(directions[i]);
    const float density = emitter.pdf_environment(directions[i]);
    blocks.add(is_near(value, radiance.at(i)) && is_near(Vec3(density), Vec3(pdf[i])));
    batches.add(is_near(value, batch[i]) && is_near(Vec3(density), Vec3(batch_pdf[i])));
  }
  return {blocks, batches};
}

/// Compares sample_emission_block() with sample_emission().
EmitterDifferences emission_differences(const Emitter& emitter, const EmitterBlockPoints& at,
                                        BlockMemory& memory, Random& random) {
  const EmissionBlock emitted{memory.three(), memory.three(), memory.three()};
  const Columns2 numbers{at.d.x, at.d.y};  // random numbers for directions
  for (size_t i = 0; i < at.count; ++i) numbers.set(i, random.unit2());
  emitter.sample_emission_block(at.u, numbers, at.count, emitted);
  EmitterDifferences rays;
  for (size_t i = 0; i < at.count; ++i) {
    const auto ray = emitter.sample_emission(at.u.at(i), numbers.at(i));
    const bool has = ray && !is_black(ray->power);
    rays.add(has == !is_black(emitted.power.at(i)) &&
             (!has || (is_near(ray->ray().o, emitted.o.at(i)) &&
                       is_near(ray->d, emitted.d.at(i)) &&
                       is_near(ray->power, emitted.power.at(i)))));
  }
  return rays;
}

Outcome emitter_blocks(const Subject& subject) {
  Outcome outcome;
  const EmitterScene at(subject);
  const Emitter& emitter = at.emitter();
  Random random(subject.request().seed + 7);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const EmitterBlockPoints points{count, memory.three(), memory.three(), memory.two()};
  for (size_t i = 0; i < count; ++i) {
    points.p.set(i, at.random_point(random));
    points.u.set(i, random.unit2());
    points.d.set(i, random.direction());
  }
  const auto judge = [&](const EmitterDifferences& differences, const std::string& what) {
    outcome.fail_if_many(differences.different, differences.count, 100,
                         what + " at {} of {} points");
  };
  judge(direct_differences(emitter, points, memory),
        "sample_direct_block() differs from sample_direct()");
  if (emitter.is_environment()) {
    const auto [blocks, batches] = environment_differences(emitter, points, memory);
    judge(blocks, "eval_environment_block() differs from eval_environment()");
    judge(batches, "eval_environment_batch() differs from eval_environment()");
  }
  judge(emission_differences(emitter, points, memory, random),
        "sample_emission_block() differs from sample_emission()");
  if (at.is_surface()) {
    judge(surface_differences(at, random), "eval_surface_block() differs from eval_surface()");
  }
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured =
      fmt::format("blocks of {} points compared with single points, bound 1 of 100", count);
  return outcome;
}

bool is_of_grid(const std::string& fault) {
  return fault.find("cell_grid") != std::string::npos;
}

}  // namespace

void add_emitter_checks(const Subject& subject, Plan& plan) {
  const auto emitter = subject.make<Emitter>();
  if (emitter->is_indirect()) return;  // emits no light of its own
  plan.add("values", 0, [&](double) { return emitter_values(subject); });
  if (emitter->is_delta()) {
    plan.add("delta", 0, [&](double) { return emitter_delta(subject); });
  } else {
    plan.add("density", 0, [&](double) { return emitter_density(subject); });
    plan.add("sampling", emitter->is_environment() ? 1 : kEmitterPoints,
             [&](double alpha) { return emitter_sampling(subject, alpha); });
  }
  plan.add("blocks", 0, [&](double) { return emitter_blocks(subject); });
  plan.add("consistency", 0, [&](double) {
    return audit(subject, [](const std::string& fault) { return !is_of_grid(fault); });
  });
  if (emitter->is_environment()) {
    plan.add("cell_grid", 0, [&](double) { return audit(subject, is_of_grid); });
  }
  add_emission_checks(subject, plan);
  add_irradiance_checks(subject, plan);
  add_origin_checks(subject, plan);
  add_against_check(subject, plan);
}

}  // namespace kinome::check
