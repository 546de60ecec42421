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

/// Compares emitters over blocks with the same emitters at single points, for each instruction set.
/// Tolerances are multiples of kRounding, a few roundings of numbers of magnitude 1.
namespace kinome::test::emitter_block_test {
namespace {

using namespace emitter_block;

struct DirectMemory {
  explicit DirectMemory(size_t count)
      : memory(count),
        p(memory.three()),
        u(memory.two()),
        out{memory.three(), memory.one(), memory.one(), memory.three(), memory.one()} {}
  BlockMemory memory;
  Columns3 p;
  Columns2 u;
  DirectBlock out;
};

/// `share`: permitted relative rounding error of the pdf and the radiance.
void expect_same(const Case& c, const std::optional<DirectSample>& expected, const DirectBlock& out,
                 size_t i, float share) {
  const DirectSample light = expected.value_or(DirectSample{});
  // Near the edge of the light, rounding may decide whether it is visible.
  const float scale = light.is_delta && light.distance < kInfinity ? sqr(light.distance) : 1;
  const float slack = kRounding * c.sharpness * c.largest / scale;
  const bool is_seen = out.pdf[i] > 0;
  const Rgb radiance = is_seen ? out.radiance.at(i) : Rgb(0.f);
  EXPECT_LE(largest_difference(radiance, light.radiance),
            slack + share * largest_coordinate(light.radiance));
  if (is_seen != expected.has_value()) {
    EXPECT_LE(largest_coordinate(radiance + light.radiance), 4 * slack);
    return;
  }
  if (!is_seen) return;
  EXPECT_NEAR(out.pdf[i], light.pdf, light.pdf * share);
  EXPECT_LE(largest_difference(out.d.at(i), light.d), share);
  EXPECT_EQ(out.is_delta[i], light.is_delta ? 1 : 0);
  if (light.distance < kInfinity) {
    EXPECT_NEAR(out.distance[i], light.distance, light.distance * share);
  } else {
    EXPECT_EQ(out.distance[i], kInfinity);
  }
}

TEST_P(EmitterBlocks, AreSampledAsFromPoints) {
  for_lights([](const Case& c, const Emitter& emitter) {
    Random random(1);
    for (const size_t count : {size_t{1}, size_t{15}, size_t{16}, size_t{17}, size_t{33},
                               size_t{700}}) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        DirectMemory block(count);
        for (size_t i = 0; i < count; ++i) {
          const float far = random.unit() < .1f ? 1e10f : 1.f;
          block.p.set(i, Vec3(.3f, .2f, -1) +
                             random.direction() * (far * std::exp(random.between(-5, 5))));
          if (i % 16 == 3) block.p.set(i, {.3f, .2f, -1});  // at the emitter itself
          if (emitter.is_delta()) continue;  // lamps ignore their random numbers, which stay NaN
          block.u.set(i, {random.unit(), random.unit()});
          if (i % 16 == 5) block.u.set(i, {0, 0});
          if (i % 16 == 7) block.u.set(i, {kOneMinusEpsilon, kOneMinusEpsilon});
        }
        emitter.sample_direct_block(block.p, block.u, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          const Vec3 p = block.p.at(i);
          expect_same(c, emitter.sample_direct(p, block.u.at(i)), block.out, i, 2 * kRounding);
          if (testing::Test::HasFailure()) {
            FAIL() << "at " << i << " of " << count << ", u " << block.u.x[i] << ' ' << block.u.y[i]
                   << ", p " << p.x << ' ' << p.y << ' ' << p.z;
          }
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, DeltasAreMarked) {
  for_lights([](const Case& c, const Emitter& emitter) {
    const bool is_map_or_sky = c.name.starts_with("constant") || c.name.starts_with("envmap");
    EXPECT_EQ(emitter.is_delta(), !is_map_or_sky);
  });
  for_surfaces([](const Case&, const Shape&, const Emitter& emitter) {
    EXPECT_FALSE(emitter.is_delta());
  });
}

TEST_P(EmitterBlocks, SurfacesAreSampledAsFromPoints) {
  for_surfaces([](const Case& c, const Shape& shape, const Emitter& emitter) {
    Random random(3);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        DirectMemory block(count);
        for (size_t i = 0; i < count; ++i) {
          block.p.set(i, random.direction() * std::exp(random.between(-2, 5)));
          block.u.set(i, {random.unit(), random.unit()});
        }
        emitter.sample_direct_block(block.p, block.u, count, block.out);
        for (size_t i = 0; i < count; ++i) {
          const Vec3 p = block.p.at(i);
          const auto expected = emitter.sample_direct(p, block.u.at(i));
          const auto sample = shape.sample_solid_angle(p, block.u.at(i));
          if (!sample) continue;
          // Positions have the error p_error, which matters at small distances and grazing angles.
          const Vec3 to = sample->si.p - p;
          const float height = std::abs(glm::dot(sample->si.n, to));
          const float share =
              kRounding * (4 + 2 * glm::length(to) / height) + 8 * sample->si.p_error / height;
          if (!(share < 1e-3f)) continue;
          expect_same(c, expected, block.out, i, share);
          if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
        }
      }
    }
  });
}

TEST_P(EmitterBlocks, SurfacesShineAsAtPoints) {
  for_surfaces([](const Case& c, const Shape& shape, const Emitter& emitter) {
    Random random(4);
    for (const size_t count : kRanges) {
      for (const bool with_pdf : {true, false}) {
        BlockMemory memory(count);
        SurfaceBlock points;
        points.count = count;
        for (Columns3* column :
             {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi}) {
          *column = memory.three();
        }
        points.uv = memory.two();
        points.p_error = memory.one();
        points.primitive = memory.indices();
        points.ray = memory.indices();
        std::vector<const Shape*> shapes(padded(count), &shape);
        points.shape = shapes.data();
        const Columns3 from = memory.three(), radiance = memory.three();
        float* const pdf = memory.one();
        std::vector<SurfaceInteraction> single(count);
        for (size_t i = 0; i < count; ++i) {
          SurfaceInteraction& si = single[i];
          si = shape.sample_surface({random.unit(), random.unit()});
          si.wi = random.direction();
          points.p.set(i, si.p), points.n.set(i, si.n), points.wi.set(i, si.wi);
          points.s.set(i, si.frame.s), points.t.set(i, si.frame.t);
          points.sn.set(i, si.frame.n), points.uv.set(i, si.uv);
          points.p_error[i] = si.p_error;
          from.set(i, random.direction() * std::exp(random.between(0, 5)));
        }
        emitter.eval_surface_block(points, from, radiance, with_pdf ? pdf : nullptr);
        for (size_t i = 0; i < count; ++i) {
          ASSERT_LE(largest_difference(radiance.at(i), emitter.eval_surface(single[i])),
                    kRounding * c.largest * c.sharpness);
          if (!with_pdf) continue;
          const float expected = emitter.pdf_surface(from.at(i), single[i]);
          const Vec3 to = single[i].p - from.at(i);
          const float cosine = std::abs(glm::dot(single[i].n, to)) / glm::length(to);
          ASSERT_NEAR(pdf[i], expected, expected * kRounding * (1 + 1 / cosine));
        }
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Sets, EmitterBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace
}  // namespace kinome::test::emitter_block_test
