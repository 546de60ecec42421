// Checks of textures, samplers and filters.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kinome/block_points.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/sampler.h"
#include "kinome/texture.h"
#include "kit/scenes/block_memory.h"
#include "kit/statistics/density_cells.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

// ---- textures

Outcome texture_values(const Subject& subject) {
  Outcome outcome;
  const auto texture = subject.make<Texture>();
  Random random(subject.request().seed + 1);
  const float slack = 1e-3f * std::max(std::abs(texture->max()), std::abs(texture->min()));
  const Rgb first = texture->eval(Vec2(0.3f));
  const int count = subject.samples(10000);
  for (int i = 0; i < count && outcome.passed; ++i) {
    Vec2 uv = 4.f * random.unit2() - 1.5f;
    if (i % 100 == 1) uv *= 1e6f;
    const Rgb value = texture->eval(uv);
    const std::string where = fmt::format(", at uv ({}, {})", uv.x, uv.y);
    if (!is_finite(value)) outcome.fail("eval() is not finite" + where);
    if (!std::isfinite(texture->eval_1(uv))) outcome.fail("eval_1() is not finite" + where);
    const float max = max_component(value), min = std::min({value.x, value.y, value.z});
    if (max > texture->max() + slack) {
      outcome.fail(
          fmt::format("eval() is {:.5g}, but max() is {:.5g}{}", max, texture->max(), where));
    }
    if (min < texture->min() - slack) {
      outcome.fail(
          fmt::format("eval() is {:.5g}, but min() is {:.5g}{}", min, texture->min(), where));
    }
    if (max_component(value - texture->channel_max()) > slack) {
      outcome.fail("eval() is greater than channel_max()" + where);
    }
    if (texture->is_uniform() && max_component(glm::abs(value - first)) > slack) {
      outcome.fail("is_uniform() is true, but eval() varies" + where);
    }
  }
  outcome.measured = fmt::format("{} points, min() is {:.4g}, max() is {:.4g}", count,
                                 texture->min(), texture->max());
  return outcome;
}

Outcome texture_mean(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto texture = subject.make<Texture>();
  Random random(subject.request().seed + 2);
  Moments channels[3];
  for (int i = 0; i < subject.samples(40000); ++i) {
    const Rgb value = texture->eval(random.unit2());
    for (int c = 0; c < 3; ++c) channels[c].add(double{value[c]});
  }
  std::vector<Estimate> found, expected;
  for (int c = 0; c < 3; ++c) {
    found.push_back({channels[c].mean(), channels[c].variance_of_mean()});
    const double mean = double{texture->mean()[c]};
    expected.push_back({mean, std::pow(1e-3 * mean, 2)});
  }
  const Verdict verdict = largest_z_test(found, expected, alpha);
  outcome.measured = verdict.text;
  if (!verdict.passed) {
    outcome.fail(
        fmt::format("mean() is ({:.4g}, {:.4g}, {:.4g}), but the mean of eval() is "
                    "({:.4g}, {:.4g}, {:.4g})",
                    expected[0].mean, expected[1].mean, expected[2].mean, found[0].mean,
                    found[1].mean, found[2].mean));
  }
  return outcome;
}

/// Returns the number of surface points at which block functions differ from those for single
/// points.
int different_points(const Texture& texture, int count, Random& random, float slack) {
  BlockMemory memory(1);
  const Columns3 colour = memory.three();
  float* const number = memory.one();
  int different = 0;
  for (int i = 0; i < count; ++i) {
    SurfaceInteraction si;
    si.uv = random.unit2();
    const PointBlock point(si);
    texture.eval_block_at(point.block(), colour);
    texture.eval_1_block_at(point.block(), number);
    different += !(max_component(glm::abs(texture.eval_at(si) - colour.at(0))) <= slack &&
                   std::abs(texture.eval_1_at(si) - number[0]) <= slack);
  }
  return different;
}

Outcome texture_blocks(const Subject& subject) {
  Outcome outcome;
  const auto texture = subject.make<Texture>();
  Random random(subject.request().seed + 3);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  const Columns2 uv = memory.two(), slopes = memory.two();
  const Columns3 colours = memory.three();
  float* const numbers = memory.one();
  for (size_t i = 0; i < count; ++i) uv.set(i, 4.f * random.unit2() - 1.5f);
  texture->eval_block(uv, count, colours);
  texture->eval_1_block(uv, count, numbers);
  texture->eval_1_gradient_block(uv, count, slopes);
  const float slack = 2e-3f * std::max(std::abs(texture->max()), std::abs(texture->min())) + 1e-12f;
  int colour = 0, number = 0, slope = 0, difference = 0;
  for (size_t i = 0; i < count; ++i) {
    const Vec2 at = uv.at(i), gradient = texture->eval_1_gradient(at), other = slopes.at(i);
    colour += !(max_component(glm::abs(texture->eval(at) - colours.at(i))) <= slack);
    number += !(std::abs(texture->eval_1(at) - numbers[i]) <= slack);
    slope += !(glm::length(gradient - other) <= 0.05f * glm::length(gradient) + 100 * slack);
    const float step = 1e-3f;
    const Vec2 by_values(
        (texture->eval_1(at + Vec2(step, 0)) - texture->eval_1(at - Vec2(step, 0))) / (2 * step),
        (texture->eval_1(at + Vec2(0, step)) - texture->eval_1(at - Vec2(0, step))) / (2 * step));
    difference += !(glm::length(gradient - by_values) <=
                    0.1f * glm::length(gradient) + 10 * slack + 1e-4f / step * std::abs(texture->max()));
  }
  const auto judge = [&](int wrong, int accepted_one_of, const std::string& what) {
    outcome.fail_if_many(wrong, static_cast<int>(count), accepted_one_of,
                         what + " at {} of {} points");
  };
  judge(colour, 100, "eval_block() differs from eval()");
  judge(number, 100, "eval_1_block() differs from eval_1()");
  judge(slope, 50, "eval_1_gradient_block() differs from eval_1_gradient()");
  judge(difference, 5, "eval_1_gradient() isn't the slope of eval_1()");
  if (texture->attribute().empty()) {  // a texture with an attribute needs a mesh
    judge(different_points(*texture, static_cast<int>(count), random, slack), 100,
          "eval_block_at() or eval_1_block_at() differs from single points");
  }
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured = fmt::format("blocks of {} points compared with single points", count);
  return outcome;
}

// ---- samplers

/// Returns the index of the part of [0, 1), divided into n equal parts, that contains x. Clamps
/// values outside of [0, 1), which faulty plugins return.
size_t part_of(float x, int n) {
  if (!(x > 0)) return 0;
  return static_cast<size_t>(std::min(x, 1.f) * static_cast<float>(n) * kOneMinusEpsilon);
}

/// Number of pixels whose samples are tested.
constexpr uint32_t kPixels = 2000;

SampleKey key_of(const Subject& subject, uint32_t pixel, uint32_t sample) {
  return {pixel % 50, pixel / 50, sample, subject.request().seed};
}

Outcome sampler_values(const Subject& subject) {
  Outcome outcome;
  const auto sampler = subject.make<Sampler>();
  for (uint32_t i = 0; i < 4000 && outcome.passed; ++i) {
    const SampleKey key = key_of(subject, i, i % 10 ? i % 7 : 0xffffff00u + i % 256);
    const uint32_t dimension = i % 13;
    const float x = sampler->value_1d(key, dimension);
    const Vec2 xy = sampler->value_2d(key, dimension);
    if (!(std::min({x, xy.x, xy.y}) >= 0 && std::max({x, xy.x, xy.y}) < 1)) {
      outcome.fail(fmt::format("a value is outside of [0, 1), for sample {} and dimension {}",
                               key.sample, dimension));
    }
    if (sampler->value_1d(key, dimension) != x || sampler->value_2d(key, dimension) != xy) {
      outcome.fail("a second call with the same key and dimension returns a different value");
    }
  }
  for (const uint32_t count : {1u, 5u, 64u}) {
    const auto other = sampler->with_sample_count(count);
    if (!other || other->sample_count() < count) {
      outcome.fail(
          fmt::format("with_sample_count({}) returns a sampler with fewer samples", count));
    }
  }
  outcome.measured = "4000 keys, each called twice";
  return outcome;
}

Outcome sampler_uniform(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto sampler = subject.make<Sampler>();
  constexpr int kSide = 8;
  for (const uint32_t dimension : {0u, 4u, 7u}) {
    std::vector<double> line(kSide * kSide), square(line.size());
    const uint32_t samples = std::min(sampler->sample_count(), 16u);
    for (uint32_t pixel = 0; pixel < kPixels; ++pixel) {
      for (uint32_t s = 0; s < samples; ++s) {
        const SampleKey key = key_of(subject, pixel, s);
        const float x = sampler->value_1d(key, dimension);
        const Vec2 xy = sampler->value_2d(key, dimension);
        line[part_of(x, kSide * kSide)] += 1;
        square[part_of(xy.x, kSide) * kSide + part_of(xy.y, kSide)] += 1;
      }
    }
    const std::vector<double> even(line.size(),
                                   static_cast<double>(kPixels) * samples / double(line.size()));
    const Verdict by_line = chi2_test(line, even, alpha), by_square = chi2_test(square, even, alpha);
    outcome.measured = by_square.text;
    if (!by_line.passed) outcome.fail(fmt::format("value_1d({}) is not uniform", dimension));
    if (!by_square.passed) outcome.fail(fmt::format("value_2d({}) is not uniform", dimension));
  }
  return outcome;
}

/// Checks that different dimensions, pixels and seeds are uncorrelated.
Outcome sampler_independent(const Subject& subject, double alpha) {
  Outcome outcome;
  const auto sampler = subject.make<Sampler>();
  const char* const pairs[] = {"dimensions", "pixels", "seeds"};
  for (int pair = 0; pair < 3; ++pair) {
    Moments joint;
    for (uint32_t pixel = 0; pixel < kPixels; ++pixel) {
      const SampleKey key = key_of(subject, 2 * pixel, 0);
      SampleKey other = key;
      if (pair == 1) other.x += 1;
      if (pair == 2) other.seed += 1;
      const float a = sampler->value_1d(key, 3);
      const float b = sampler->value_1d(other, pair == 0 ? 4 : 3);
      joint.add((double{a} - 0.5) * (double{b} - 0.5));
    }
    const Verdict verdict =
        z_test({{joint.mean(), joint.variance_of_mean()}}, {{0, 0}}, alpha);
    outcome.measured = verdict.text;
    if (!verdict.passed) {
      outcome.fail(fmt::format("samples of different {} are correlated: {:.3g}", pairs[pair],
                               joint.mean() * 12));
    }
  }
  return outcome;
}

Outcome sampler_blocks(const Subject& subject) {
  Outcome outcome;
  const auto sampler = subject.make<Sampler>();
  const std::vector<uint32_t> x = {3, 4, 5, 3, 700}, y = {0, 0, 0, 9, 31};
  PixelSamples block{x.data(), y.data(), x.size(), 2, 7, subject.request().seed};
  BlockMemory memory(block.count());
  float* const line = memory.one();
  const Columns2 square = memory.two();
  sampler->fill_1d_block(block, 5, line);
  sampler->fill_2d_block(block, 6, square);
  int different = 0;
  for (uint32_t i = 0; i < block.count(); ++i) {
    const SampleKey key{x[i / 7], y[i / 7], 2 + i % 7, block.seed};
    different += sampler->value_1d(key, 5) != line[i];
    different += sampler->value_2d(key, 6) != square.at(i);
  }
  if (different > 0) {
    outcome.fail(
        fmt::format("fill_1d_block() or fill_2d_block() differs from value_1d() and "
                    "value_2d() for {} of {} samples",
                    different, 2 * block.count()));
  }
  if (memory.is_overrun()) outcome.fail("a block function writes beyond its columns");
  outcome.measured =
      fmt::format("blocks of {} compared with single values, bit by bit", block.count());
  return outcome;
}

// ---- filters

Outcome filter_values(const Subject& subject) {
  Outcome outcome;
  const auto filter = subject.make<ReconstructionFilter>();
  const float radius = filter->radius();
  if (!(radius > 0 && radius < 1000)) {
    outcome.fail(fmt::format("radius() is {}", radius));
    return outcome;
  }
  Random random(subject.request().seed + 1);
  const auto count = static_cast<size_t>(subject.samples(2001));
  BlockMemory memory(count);
  float *const x = memory.one(), *const values = memory.one();
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    x[i] = radius * 1.5f * (2 * (static_cast<float>(i) + random.unit()) / static_cast<float>(count) - 1);
  }
  filter->eval_block(x, count, values);
  for (size_t i = 0; i < count && outcome.passed; ++i) {
    const float value = filter->eval(x[i]);
    sum += double{value} * 3 * double{radius} / static_cast<double>(count);
    if (!std::isfinite(value)) outcome.fail(fmt::format("eval({}) is not finite", x[i]));
    // Skip values near the radius, where rounding decides.
    if (std::abs(std::abs(x[i]) - radius) < 1e-4f * radius) continue;
    if (std::abs(x[i]) > radius && value != 0) {
      outcome.fail(
          fmt::format("eval({}) is {}, expected 0 beyond the radius {}", x[i], value, radius));
    }
    if (std::abs(filter->eval(-x[i]) - value) > 1e-4f * std::abs(filter->eval(0))) {
      outcome.fail(fmt::format("eval({}) is {}, but eval({}) is {}: filters must be symmetric",
                               x[i], value, -x[i], filter->eval(-x[i])));
    }
    if (!(std::abs(values[i] - value) <= 1e-3f * std::abs(filter->eval(0)))) {
      outcome.fail(fmt::format("eval_block() returns {} for {}, but eval() returns {}", values[i],
                               x[i], value));
    }
  }
  if (!(sum > 0)) {
    outcome.fail(
        fmt::format("the integral is {:.4g}, but must be positive: films divide by it", sum));
  }
  if (memory.is_overrun()) outcome.fail("eval_block() writes beyond its columns");
  outcome.measured =
      fmt::format("radius {:.4g}, integral {:.4g}, a block of {} compared with single values",
                  radius, sum, count);
  return outcome;
}

}  // namespace

void add_texture_checks(const Subject& subject, Plan& plan) {
  if (!subject.make<Texture>()->attribute().empty()) return;  // has no values without a mesh
  plan.add("values", 0, [&](double) { return texture_values(subject); });
  plan.add("mean", 1, [&](double alpha) { return texture_mean(subject, alpha); });
  plan.add("blocks", 0, [&](double) { return texture_blocks(subject); });
}

void add_sampler_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return sampler_values(subject); });
  plan.add("uniform", 6, [&](double alpha) { return sampler_uniform(subject, alpha); });
  plan.add("independent", 3, [&](double alpha) { return sampler_independent(subject, alpha); });
  plan.add("blocks", 0, [&](double) { return sampler_blocks(subject); });
}

void add_filter_checks(const Subject& subject, Plan& plan) {
  plan.add("values", 0, [&](double) { return filter_values(subject); });
}

}  // namespace kinome::check
