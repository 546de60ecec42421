// Checks of volumes, phase functions and media.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/medium.h"
#include "kit/block_memory.h"
#include "kit/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

/// Returns the part of a medium's or volume's box to test: a cube if the box is infinite or empty.
Aabb tested_box(const Aabb& box) {
  const bool is_usable = !box.empty() && is_finite(box.lo) && is_finite(box.hi);
  return is_usable ? box : Aabb(Vec3(-1.f), Vec3(1.f));
}

Vec3 point_in(const Aabb& box, Random& random) {
  return glm::mix(box.lo, box.hi, Vec3(random.unit2(), random.unit()));
}

std::string at_point(const Vec3& p) {
  return fmt::format(", at ({}, {}, {})", p.x, p.y, p.z);
}

bool are_close(float a, float b, float scale) {
  return std::abs(a - b) <= 1e-4f * scale + 1e-30f;
}

/// Segments o + t d in a box, 0 <= t <= length.
struct BoxSegments {
  Columns3 o, d;
  float* length;

  BoxSegments(BlockMemory& memory, const Aabb& box, size_t count, Random& random)
      : o(memory.three()), d(memory.three()), length(memory.one()) {
    for (size_t i = 0; i < count; ++i) {
      const Vec3 a = point_in(box, random), to = point_in(box, random) - a;
      length[i] = glm::length(to);
      o.set(i, a);
      d.set(i, length[i] > 0 ? to / length[i] : Vec3(1, 0, 0));
    }
  }
};

/// Compares an integral along a segment with the midpoint rule: returns whether they agree up to
/// the rule's error.
template <class Value>
bool is_integral(float stated, const BoxSegments& segments, size_t i, float max,
                 const Value& value) {
  constexpr int kSteps = 1000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const float t = segments.length[i] * (static_cast<float>(k) + 0.5f) / kSteps;
    sum += double{value(segments.o.at(i) + segments.d.at(i) * t)};
  }
  const double expected = sum * double{segments.length[i]} / kSteps;
  return std::abs(stated - expected) <= 5e-3 * double{max} * double{segments.length[i]} + 1e-30;
}

/// Tests bounds in a grid of blocks: calls value(p, fail) at points of each block.
template <class Extremes, class Range>
Outcome check_extremes(const Aabb& box, uint64_t seed, const Extremes& extremes,
                       const Range& range_at) {
  Outcome outcome;
  Random random(seed);
  const Vec3 size = box.extent();
  // Larger than the box, because blocks may be anywhere.
  const BlockGrid blocks{{box.lo - 0.1f * size, box.hi + 0.1f * size}, {5, 3, 4}};
  std::vector<float> lo(blocks.count(), kNan), hi(blocks.count(), kNan);
  extremes(blocks, lo.data(), hi.data());
  size_t i = 0;
  for (glm::uvec3 at(0); at.z < blocks.size.z; ++at.z) {
    for (at.y = 0; at.y < blocks.size.y; ++at.y) {
      for (at.x = 0; at.x < blocks.size.x; ++at.x, ++i) {
        for (int k = 0; k < 200; ++k) {
          const Vec3 p = point_in(blocks.block(at), random);
          const auto [least, most] = range_at(p, random);
          if (least >= lo[i] && most <= hi[i]) continue;
          outcome.fail(
              fmt::format("extremes() returns {:.6g} to {:.6g} for a block with the "
                          "values {:.6g} to {:.6g}{}",
                          lo[i], hi[i], least, most, at_point(p)));
        }
      }
    }
  }
  outcome.measured = fmt::format("200 points in each of {} blocks", blocks.count());
  return outcome;
}

// ---- volumes

struct VolumeValue {
  float channels[Volume::kMaxChannels] = {};
  float min = kInfinity, max = -kInfinity;
  bool is_finite = true;

  VolumeValue(const Volume& volume, const Vec3& p) {
    volume.eval(p, channels);
    for (uint32_t c = 0; c < volume.channels(); ++c) {
      min = std::min(min, channels[c]), max = std::max(max, channels[c]);
      is_finite = is_finite && std::isfinite(channels[c]);
    }
  }
};

/// Returns a point in or near the volume's box; sometimes far away.
Vec3 near_point(const Aabb& box, Random& random, int i) {
  const Vec3 size = box.extent();
  const Vec3 p = point_in({box.lo - 0.5f * size, box.hi + 0.5f * size}, random);
  return i % 100 == 1 ? p * 1e6f : p;
}

Outcome volume_values(const Subject& subject) {
  Outcome outcome;
  const auto volume = subject.make<Volume>();
  const uint32_t channels = volume->channels();
  if (channels != 1 && channels != 3 && channels != 6) {
    outcome.fail(fmt::format("channels() is {}, expected 1, 3 or 6", channels));
    return outcome;
  }
  if (volume->box().empty()) outcome.fail("box() is empty");
  Random random(subject.request().seed + 1);
  const Aabb box = tested_box(volume->box());
  const VolumeValue first(*volume, box.centre());
  const int count = subject.samples(10000);
  for (int i = 0; i < count && outcome.passed; ++i) {
    const Vec3 p = near_point(box, random, i);
    const VolumeValue value(*volume, p);
    if (!value.is_finite) outcome.fail("eval() is not finite" + at_point(p));
    if (value.max > volume->max()) {
      outcome.fail(fmt::format("eval() is {:.6g}, but max() is {:.6g}{}", value.max, volume->max(),
                               at_point(p)));
    }
    if (value.min < volume->min()) {
      outcome.fail(fmt::format("eval() is {:.6g}, but min() is {:.6g}{}", value.min, volume->min(),
                               at_point(p)));
    }
    if (volume->is_uniform() && (value.max != first.max || value.min != first.min)) {
      outcome.fail("is_uniform() is true, but eval() varies" + at_point(p));
    }
  }
  outcome.measured = fmt::format("{} points of {} channels, min() is {:.4g}, max() is {:.4g}",
                                 count, channels, volume->min(), volume->max());
  return outcome;
}

Outcome volume_blocks(const Subject& subject) {
  Outcome outcome;
  const auto volume = subject.make<Volume>();
  const uint32_t channels = std::min(volume->channels(), Volume::kMaxChannels);
  Random random(subject.request().seed + 2);
  const Aabb box = tested_box(volume->box());
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const Columns3 p = memory.three();
  float* values[Volume::kMaxChannels];
  for (float*& column : values) column = memory.one();
  for (size_t i = 0; i < count; ++i) p.set(i, near_point(box, random, static_cast<int>(i)));
  volume->eval_block(p, count, values);
  const float scale = std::max(std::abs(volume->max()), std::abs(volume->min()));
  int different = 0;
  for (size_t i = 0; i < count; ++i) {
    const VolumeValue value(*volume, p.at(i));
    bool is_same = true;
    for (uint32_t c = 0; c < channels; ++c) {
      is_same = is_same && are_close(values[c][i], value.channels[c], scale);
    }
    different += !is_same;
  }
  outcome.fail_if_many(different, static_cast<int>(count), 100,
                       "eval_block() differs from eval() at {} of {} points");
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured = fmt::format("a block of {} points compared with single points", count);
  return outcome;
}

Outcome volume_extremes(const Subject& subject) {
  const auto volume = subject.make<Volume>();
  return check_extremes(
      tested_box(volume->box()), subject.request().seed + 3,
      [&](const BlockGrid& blocks, float* lo, float* hi) { volume->extremes(blocks, lo, hi); },
      [&](const Vec3& p, Random&) {
        const VolumeValue value(*volume, p);
        return std::pair(value.min, value.max);
      });
}

Outcome volume_integral(const Subject& subject) {
  Outcome outcome;
  const auto volume = subject.make<Volume>();
  if (!volume->has_integral()) {
    outcome.measured = "not implemented";
    return outcome;
  }
  Random random(subject.request().seed + 4);
  const auto count = static_cast<size_t>(subject.samples(300));
  BlockMemory memory(count);
  const BoxSegments segments(memory, tested_box(volume->box()), count, random);
  float* values[Volume::kMaxChannels];
  for (float*& column : values) column = memory.one();
  volume->integral_block(segments.o, segments.d, segments.length, count, values);
  const float scale = std::max(std::abs(volume->max()), std::abs(volume->min()));
  int wrong = 0;
  for (size_t i = 0; i < count; ++i) {
    wrong += !is_integral(values[0][i], segments, i, scale,
                          [&](const Vec3& p) { return VolumeValue(*volume, p).channels[0]; });
  }
  outcome.fail_if_many(
      wrong, static_cast<int>(count), 100,
      "integral_block() differs from the integral of eval() for {} of {} segments");
  if (memory.is_overrun()) outcome.fail("integral_block() writes beyond its columns");
  outcome.measured = fmt::format("{} segments compared with 1000 points of each", count);
  return outcome;
}

// ---- phase functions

/// Points with frames of all directions.
MediumPoint phase_point(Random& random) {
  return {2.f * Vec3(random.unit2(), random.unit()) - 0.5f, Frame::from_normal(random.direction())};
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

// ---- media

Outcome medium_values(const Subject& subject) {
  Outcome outcome;
  const auto medium = subject.make<Medium>();
  if (medium->box().empty()) outcome.fail("box() is empty");
  const Aabb box = tested_box(medium->box());
  Random random(subject.request().seed + 1);
  const MediumCoefficients first = medium->coefficients(box.centre(), Vec3(0, 0, 1));
  const int count = subject.samples(10000);
  for (int i = 0; i < count && outcome.passed; ++i) {
    const Vec3 p = point_in(box, random);
    const MediumCoefficients at = medium->coefficients(p, random.direction());
    const Rgb& sigma = at.extinction;
    if (!is_finite(sigma) || !is_finite(at.scattering)) {
      outcome.fail("coefficients() are not finite" + at_point(p));
    }
    if (max_component(-at.scattering) > 0 || max_component(at.scattering - sigma) > 0) {
      outcome.fail("the scattering is not between 0 and the extinction" + at_point(p));
    }
    if (-max_component(-sigma) < medium->min_extinction() ||
        max_component(sigma) > medium->max_extinction()) {
      outcome.fail(
          fmt::format("the extinction ({:.6g}, {:.6g}, {:.6g}) is outside of "
                      "min_extinction() to max_extinction(){}",
                      sigma.x, sigma.y, sigma.z, at_point(p)));
    }
    if (!medium->is_coloured() && (sigma.x != sigma.y || sigma.y != sigma.z)) {
      outcome.fail("the extinction is coloured, but is_coloured_ is false" + at_point(p));
    }
    if (medium->is_uniform() && (sigma != first.extinction || at.scattering != first.scattering)) {
      outcome.fail("is_uniform() is true, but coefficients() vary" + at_point(p));
    }
  }
  outcome.measured = fmt::format("{} points, extinction from {:.4g} to {:.4g}", count,
                                 medium->min_extinction(), medium->max_extinction());
  return outcome;
}

Outcome medium_blocks(const Subject& subject) {
  Outcome outcome;
  const auto medium = subject.make<Medium>();
  const Aabb box = tested_box(medium->box());
  Random random(subject.request().seed + 2);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const Columns3 p = memory.three(), d = memory.three();
  for (size_t i = 0; i < count; ++i) p.set(i, point_in(box, random)), d.set(i, random.direction());
  const MediumBlock out{memory.three(), memory.three()};
  medium->coefficients_block(p, d, count, out);
  // As for callers that need only a grey extinction.
  float* const grey = memory.one();
  if (!medium->is_coloured()) medium->coefficients_block(p, d, count, {{grey, grey, grey}, {}});
  int different = 0;
  for (size_t i = 0; i < count; ++i) {
    const MediumCoefficients at = medium->coefficients(p.at(i), d.at(i));
    const float slack = 1e-4f * max_component(at.extinction) + 1e-5f * medium->max_extinction();
    different += !(max_component(glm::abs(out.extinction.at(i) - at.extinction)) <= slack &&
                   max_component(glm::abs(out.scattering.at(i) - at.scattering)) <= slack &&
                   (medium->is_coloured() || std::abs(grey[i] - at.extinction.x) <= slack));
  }
  outcome.fail_if_many(different, static_cast<int>(count), 100,
                       "coefficients_block() differs from coefficients() at {} of {} points");
  if (memory.is_overrun()) outcome.fail("coefficients_block() writes beyond its columns");
  outcome.measured = fmt::format("a block of {} points compared with single points", count);
  return outcome;
}

Outcome medium_extremes(const Subject& subject) {
  const auto medium = subject.make<Medium>();
  const Aabb box = medium->box();
  return check_extremes(
      tested_box(box), subject.request().seed + 3,
      [&](const BlockGrid& blocks, float* lo, float* hi) { medium->extremes(blocks, lo, hi); },
      [&](const Vec3& p, Random& random) {
        const Vec3 inside = glm::clamp(p, box.lo, box.hi);
        const Rgb sigma = medium->coefficients(inside, random.direction()).extinction;
        if (p != inside) return std::pair(kInfinity, -kInfinity);  // no values there
        return std::pair(-max_component(-sigma), max_component(sigma));
      });
}

Outcome medium_depth(const Subject& subject) {
  Outcome outcome;
  const auto medium = subject.make<Medium>();
  if (!medium->has_optical_depth()) {
    outcome.measured = "not implemented";
    return outcome;
  }
  Random random(subject.request().seed + 4);
  const auto count = static_cast<size_t>(subject.samples(300));
  BlockMemory memory(count);
  const BoxSegments segments(memory, tested_box(medium->box()), count, random);
  const Columns3 depth = memory.three();
  medium->optical_depth_block(segments.o, segments.d, segments.length, count, depth);
  int wrong = 0;
  for (size_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      wrong += !is_integral(
          depth.at(i)[c], segments, i, medium->max_extinction(),
          [&](const Vec3& p) { return medium->coefficients(p, segments.d.at(i)).extinction[c]; });
    }
  }
  outcome.fail_if_many(wrong, static_cast<int>(3 * count), 100,
                       "optical_depth_block() differs from the integral of the extinction for {} "
                       "of {} segments and channels");
  if (memory.is_overrun()) outcome.fail("optical_depth_block() writes beyond its columns");
  outcome.measured = fmt::format("{} segments compared with 1000 points of each", count);
  return outcome;
}

}  // namespace

void add_volume_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return volume_values(subject); });
  plan.add("blocks", 0, [&](double) { return volume_blocks(subject); });
  plan.add("extremes", 0, [&](double) { return volume_extremes(subject); });
  plan.add("integral", 0, [&](double) { return volume_integral(subject); });
}

void add_phase_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return phase_values(subject); });
  plan.add("sampling", 2, [&](double alpha) { return phase_sampling(subject, alpha); });
  plan.add("blocks", 0, [&](double) { return phase_blocks(subject); });
}

void add_medium_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return medium_values(subject); });
  plan.add("blocks", 0, [&](double) { return medium_blocks(subject); });
  plan.add("extremes", 0, [&](double) { return medium_extremes(subject); });
  plan.add("depth", 0, [&](double) { return medium_depth(subject); });
}

}  // namespace kinome::check
