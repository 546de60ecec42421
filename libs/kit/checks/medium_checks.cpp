// Checks of media.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/medium.h"
#include "kit/scenes/space_points.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

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
  // Callers that need only a grey extinction pass the same column for all channels.
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

void add_medium_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return medium_values(subject); });
  plan.add("blocks", 0, [&](double) { return medium_blocks(subject); });
  plan.add("extremes", 0, [&](double) { return medium_extremes(subject); });
  plan.add("depth", 0, [&](double) { return medium_depth(subject); });
}

}  // namespace kinome::check
