// Checks of volumes.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kit/scenes/space_points.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

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

}  // namespace

void add_volume_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return volume_values(subject); });
  plan.add("blocks", 0, [&](double) { return volume_blocks(subject); });
  plan.add("extremes", 0, [&](double) { return volume_extremes(subject); });
  plan.add("integral", 0, [&](double) { return volume_integral(subject); });
}

}  // namespace kinome::check
