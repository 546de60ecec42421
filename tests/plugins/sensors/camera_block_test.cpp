// Tests that samplers, sensors and filters return the same for blocks of samples as for single
// samples. Uses the library of each instruction set that this processor supports.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kinome/sensor.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::camera_block_test {
namespace {

/// Calls fn(make) for each instruction set; make(xml) creates an object from its libraries.
template <class Function>
void for_each_set(const Function& fn) {
  for (const InstructionSet set : instruction_sets()) {
    SCOPED_TRACE(to_string(set));
    fn([set](const std::string& xml) { return make_for<Object>(set, xml); });
  }
}

class EverySampler : public testing::TestWithParam<const char*> {};

void expect_same_numbers(const Sampler& sampler, const PixelSamples& block) {
  BlockMemory memory(block.count());
  float* const one = memory.one();
  const Columns2 two = memory.two();
  sampler.fill_1d_block(block, 9, one);
  sampler.fill_2d_block(block, 4, two);
  for (size_t i = 0; i < block.count(); ++i) {
    const size_t p = i / block.samples;
    const auto sample = block.first_sample + static_cast<uint32_t>(i % block.samples);
    const SampleKey key{block.x[p], block.y[p], sample, block.seed};
    ASSERT_EQ(one[i], sampler.value_1d(key, 9)) << block.samples << " " << i;
    ASSERT_EQ(two.at(i), sampler.value_2d(key, 4)) << block.samples << " " << i;
  }
}

TEST_P(EverySampler, FillsBlocksWithTheSameNumbers) {
  const std::vector<uint32_t> x = {0, 7, 1u << 20, static_cast<uint32_t>(-3), 5};
  const std::vector<uint32_t> y = {0, 1, 900, static_cast<uint32_t>(-1), 5};
  for_each_set([&](const auto& make) {
    for (const int count : {16, 5000}) {
      const auto sampler = std::dynamic_pointer_cast<Sampler>(make(
          std::string("<sampler type=\"") + GetParam() +
          "\"><integer name=\"sample_count\" value=\"" + std::to_string(count) + "\"/></sampler>"));
      // Tests vectors within a pixel, vectors across pixels, and a partial last vector.
      for (const uint32_t samples : {1u, 3u, 4u, 15u, 16u, 17u, 48u}) {
        for (const uint32_t first : {0u, 5u, 4294967200u}) {
          for (const size_t pixels : {size_t{1}, x.size()}) {
            const PixelSamples block{x.data(), y.data(), pixels, first, samples, 77};
            expect_same_numbers(*sampler, block);
          }
        }
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Samplers, EverySampler,
                         testing::Values("sobol", "independent", "stratified", "halton",
                                         "multijitter", "orthogonal"));

class EveryFilterBlock : public testing::TestWithParam<const char*> {};

TEST_P(EveryFilterBlock, WeighsAsPointByPoint) {
  for_each_set([&](const auto& make) {
    const auto filter = std::dynamic_pointer_cast<ReconstructionFilter>(
        make(std::string("<rfilter type=\"") + GetParam() + "\"/>"));
    for (const size_t count : {1u, 15u, 16u, 17u, 400u}) {
      BlockMemory memory(count);
      float *const x = memory.one(), *const w = memory.one();
      for (size_t i = 0; i < count; ++i) {
        x[i] =
            (2 * static_cast<float>(i) / static_cast<float>(count) - 1) * 1.1f * filter->radius();
      }
      filter->eval_block(x, count, w);
      // Tolerance: two ulps of the exponential, which is at most 1; the filter subtracts a
      // constant.
      for (size_t i = 0; i < count; ++i) ASSERT_NEAR(w[i], filter->eval(x[i]), 2.5e-7f) << x[i];
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Filters, EveryFilterBlock, testing::Values("box", "tent", "gaussian"));

std::string sensor_xml(const std::string& type) {
  const char* const optics = type == "thinlens" ? R"(<float name="aperture_radius" value="0.4"/>
                                                     <float name="focus_distance" value="3"/>)"
                                                : "";
  return "<sensor type=\"" + type + R"("><transform name="to_world">
      <lookat origin="1,2,-7" target="0.3,0.2,1" up="0.1,1,0"/></transform>)" +
         optics + "</sensor>";
}

class EverySensor : public testing::TestWithParam<const char*> {};

TEST_P(EverySensor, MakesTheSameRays) {
  for_each_set([&](const auto& make) {
    const auto sensor = std::dynamic_pointer_cast<Sensor>(make(sensor_xml(GetParam())));
    for (const size_t count : {1u, 15u, 16u, 17u, 33u}) {
      BlockMemory memory(count);
      const Columns2 at = memory.two(), lens = memory.two();
      for (size_t i = 0; i < count; ++i) {
        const auto f = static_cast<float>(i);
        at.set(i, {20 * f - 3, 500 - 17 * f});
        lens.set(i, {std::fmod(0.37f * f, 1.f), std::fmod(0.71f * f, 1.f)});
      }
      // Vectors must be aligned.
      struct alignas(64) Rays {
        RayHit16 blocks[3];
      };
      const auto rays = std::make_unique<Rays>();
      sensor->sample_ray_block(at, lens, count, rays->blocks);
      for (size_t i = 0; i < count; ++i) {
        const Ray expected = sensor->sample_ray(at.at(i), lens.at(i));
        const Ray ray = ray_hit_of(rays->blocks, i).ray;
        // Tolerance: some ten roundings of coordinates up to 8.
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(ray.o[c], expected.o[c], 2e-6f) << i;
          ASSERT_NEAR(ray.d[c], expected.d[c], 6e-7f) << i;
        }
        ASSERT_NEAR(ray.tmin, expected.tmin, 6e-7f * expected.tmin);
        ASSERT_NEAR(ray.tmax, expected.tmax, 6e-7f * expected.tmax);
      }
    }
  });
}

TEST_P(EverySensor, SeesTheSamePoints) {
  for_each_set([&](const auto& make) {
    const auto sensor = std::dynamic_pointer_cast<Sensor>(make(sensor_xml(GetParam())));
    for (const size_t count : {1u, 15u, 16u, 17u, 400u}) {
      BlockMemory memory(count);
      const Columns3 p = memory.three();
      const Columns2 lens = memory.two();
      size_t seen = 0;
      for (size_t i = 0; i < count; ++i) {
        const auto f = static_cast<float>(i);
        // Some points are outside the image, some behind the camera, and one is at the lens.
        p.set(i, {3 * std::sin(f), 2 * std::cos(1.7f * f), i % 5 == 4 ? -20.f : std::sin(3 * f)});
        if (i % 32 == 13) p.set(i, {1, 2, -7});
        lens.set(i, {std::fmod(0.37f * f, 1.f), std::fmod(0.71f * f, 1.f)});
      }
      const ConnectionBlock out{memory.two(), memory.three(), memory.one(), memory.one()};
      sensor->connect_block(p, lens, count, out);
      for (size_t i = 0; i < count; ++i) {
        const auto expected = sensor->connect(p.at(i), lens.at(i));
        ASSERT_EQ(out.weight[i] > 0, expected.has_value()) << i;
        // The direction has unit length even if the point isn't seen.
        ASSERT_NEAR(glm::length(out.d.at(i)), 1, 1e-6f) << i;
        if (!expected) continue;
        ++seen;
        // Tolerance: some ten roundings of positions up to a thousand pixels.
        for (int c = 0; c < 2; ++c) {
          ASSERT_NEAR(out.film_position.at(i)[c], expected->film_position[c], 2e-3f) << i;
        }
        ASSERT_LE(largest_difference(out.d.at(i), expected->d), 2e-6f) << i;
        ASSERT_NEAR(out.distance[i], expected->distance, 1e-5f) << i;
        ASSERT_NEAR(out.weight[i], expected->weight, 1e-5f * expected->weight) << i;
      }
      if (count == 400) {
        EXPECT_GT(seen, 10u);
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Sensors, EverySensor,
                         testing::Values("perspective", "orthographic", "thinlens"));

}  // namespace
}  // namespace kinome::test::camera_block_test
