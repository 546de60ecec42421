#include <gtest/gtest.h>

#include <cmath>

#include "kinome/emitter.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "plugins/emitters/emitter_block.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"
#include "support/shape_helpers.h"

/// Tests blocks of emitted rays, and environments in blocks.
namespace kinome::test::emission_block_test {
namespace {

using namespace emitter_block;

TEST_P(EmitterBlocks, EnvironmentsMatchSingleDirections) {
  for_lights([](const Case& c, const Emitter& emitter) {
    if (!emitter.is_environment()) return;
    Random random(2);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      for (const bool with_pdf : {true, false}) {
        BlockMemory memory(count);
        const Columns3 d = memory.three(), radiance = memory.three();
        float* const pdf = memory.one();
        for (size_t i = 0; i < count; ++i) {
          d.set(i, random.direction());
          // The poles, directions near them, and the seam of the columns.
          if (i % 16 == 1) d.set(i, {0, i % 32 < 16 ? 1 : -1, 0});
          if (i % 16 == 3) d.set(i, glm::normalize(Vec3(1e-4f * random.unit(), -1, 1e-5f)));
          if (i % 16 == 5) d.set(i, {0, 0, i % 32 < 16 ? 1 : -1});
          if (i % 16 == 7) d.set(i, {-0.f, 0, -1});
        }
        emitter.eval_environment_block(d, count, radiance, with_pdf ? pdf : nullptr);
        for (size_t i = 0; i < count; ++i) {
          const float slack = 4 * kRounding * c.sharpness;
          ASSERT_LE(largest_difference(radiance.at(i), emitter.eval_environment(d.at(i))),
                    slack * c.largest)
              << "at " << i << " of " << count;
          if (!with_pdf) continue;
          const float expected = emitter.pdf_environment(d.at(i));
          // The map's largest density is at most some ten times that of a uniform distribution.
          ASSERT_NEAR(pdf[i], expected, slack * 20 * kUniformSpherePdf + 4 * kRounding * expected)
              << "at " << i << " of " << count;
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, EnvironmentsKeepNaNToItself) {
  for_lights([](const Case&, const Emitter& emitter) {
    if (!emitter.is_environment()) return;
    BlockMemory memory(16);
    const Columns3 d = memory.three(), radiance = memory.three();
    for (size_t i = 0; i < 16; ++i) {
      if (i % 2 == 0) d.set(i, {0, 0, 1});
    }
    emitter.eval_environment_block(d, 16, radiance, nullptr);
    for (size_t i = 0; i < 16; i += 2) {
      EXPECT_LE(largest_difference(radiance.at(i), emitter.eval_environment({0, 0, 1})), 1e-3f);
    }
  });
}

struct EmissionMemory {
  explicit EmissionMemory(size_t count)
      : memory(count),
        position(memory.two()),
        direction(memory.two()),
        out{memory.three(), memory.three(), memory.three()} {}
  BlockMemory memory;
  Columns2 position, direction;
  EmissionBlock out;
};

/// `size`: magnitude of the coordinates of ray origins.
void expect_same_rays(const Case& c, const Emitter& emitter, const EmissionMemory& block, size_t i,
                      float size) {
  const Vec2 position = block.position.at(i), direction = block.direction.at(i);
  const EmissionSample expected =
      emitter.sample_emission(position, direction).value_or(EmissionSample{});
  const Rgb power = block.out.power.at(i);
  if (is_black(expected.power)) {
    // Near the edge of the light, rounding may decide whether power is emitted.
    ASSERT_LE(largest_coordinate(power), 1e-4f * c.largest);
    return;
  }
  const auto share = [](float pdf) { return pdf > 0 ? 1 / pdf : 1; };
  const float shown = c.largest * share(expected.pdf_direction) * share(expected.pdf_position);
  ASSERT_LE(largest_difference(power, expected.power),
            2 * kRounding * c.sharpness * std::max(largest_coordinate(expected.power), shown));
  const Ray ray = expected.ray();
  EXPECT_LE(largest_difference(block.out.o.at(i), ray.o), 2 * kRounding * size);
  // The height over a surface is the square root of a difference from 1.
  const float height = is_black(expected.n) ? 1 : std::abs(glm::dot(expected.n, expected.d));
  EXPECT_LE(largest_difference(block.out.d.at(i), ray.d), kRounding * (2 + 1 / height));
}

void fill_numbers(Random& random, size_t count, const EmissionMemory& block) {
  for (size_t i = 0; i < count; ++i) {
    block.position.set(i, {random.unit(), random.unit()});
    block.direction.set(i, {random.unit(), random.unit()});
    if (i % 16 == 5) block.position.set(i, {0, 0});
    if (i % 16 == 7) block.position.set(i, {kOneMinusEpsilon, kOneMinusEpsilon});
  }
}

TEST_P(EmitterBlocks, SendRaysAsOneByOne) {
  for_lights([&](const Case& c, const Emitter&) {
    const auto emitter = make_for<Emitter>(GetParam(), c.xml);
    emitter->prepare({Vec3(-2, -1, -3), Vec3(2, 4, 1)});
    Random random(5);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      EmissionMemory block(count);
      fill_numbers(random, count, block);
      emitter->sample_emission_block(block.position, block.direction, count, block.out);
      for (size_t i = 0; i < count; ++i) {
        expect_same_rays(c, *emitter, block, i, 16);
        if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
      }
    }
  });
}

TEST_P(EmitterBlocks, SurfacesSendRaysAsOneByOne) {
  for_surfaces([](const Case& c, const Shape&, const Emitter& emitter) {
    Random random(6);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 10; ++repeat) {
        EmissionMemory block(count);
        fill_numbers(random, count, block);
        emitter.sample_emission_block(block.position, block.direction, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          expect_same_rays(c, emitter, block, i, 2);
          if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
        }
      }
    }
  });
}

}  // namespace
}  // namespace kinome::test::emission_block_test
