// Plugins of each kind that implement only the scalar functions. Their default block functions must
// return the values of the scalar ones. Integrators have none; for BSDFs, see bsdf_block_test.cpp.

#include <gtest/gtest.h>

#include <bit>
#include <optional>

#include "kinome/block_points.h"
#include "kinome/emitter.h"
#include "kinome/sensor.h"
#include "kinome/shape.h"
#include "kinome/texture.h"
#include "plugins/bsdfs/default_blocks.h"
#include "support/block_memory.h"

namespace kinome::test::default_blocks_test {
namespace {

using namespace default_blocks;

class PointSampler final : public Sampler {
 public:
  float value_1d(const SampleKey& key, uint32_t dimension) const override {
    return mixed(key.x, key.y, key.sample, key.seed, dimension);
  }
  Vec2 value_2d(const SampleKey& key, uint32_t dimension) const override {
    return {value_1d(key, dimension), value_1d(key, dimension + 1)};
  }
  std::shared_ptr<Sampler> with_sample_count(uint32_t /*count*/) const override { return nullptr; }
};

TEST(DefaultBlocks, OfASampler) {
  const PointSampler sampler;
  const uint32_t x[] = {3, 0, 1u << 20}, y[] = {2, 9, 4};
  for (const size_t pixels : {0, 1, 3}) {
    for (const uint32_t samples : {1u, 15u, 16u, 17u}) {
      const PixelSamples block{x, y, pixels, 6, samples, 42};
      BlockMemory memory(block.count());
      float* const one = memory.one();
      const Columns2 two = memory.two();
      sampler.fill_1d_block(block, 3, one);
      sampler.fill_2d_block(block, 5, two);
      for (size_t i = 0; i < block.count(); ++i) {
        const size_t p = i / samples;
        const SampleKey key{x[p], y[p], 6 + static_cast<uint32_t>(i % samples), 42};
        EXPECT_EQ(one[i], sampler.value_1d(key, 3));
        EXPECT_EQ(two.at(i), sampler.value_2d(key, 5));
      }
    }
  }
}

class PointSensor final : public Sensor {
 public:
  Ray sample_ray(const Vec2& at, const Vec2& aperture) const override {
    Ray ray;
    ray.o = mixed_vector(at.x, at.y, aperture.x, aperture.y);
    ray.d = mixed_vector(ray.o.x);
    ray.tmin = mixed(at.x);
    ray.tmax = 1 + mixed(at.y);
    return ray;
  }
  std::optional<SensorConnection> connect(const Vec3& p, const Vec2& aperture) const override {
    if (p.x < 0.3f) return std::nullopt;
    const Vec3 d = mixed_vector(p.x, p.y, p.z, aperture.x, aperture.y);
    return SensorConnection{{d.y, d.x}, d, mixed(d.x), mixed(d.y)};
  }
};

TEST(DefaultBlocks, OfASensor) {
  const PointSensor sensor;
  for (const size_t count : kRanges) {
    Given given(count);
    const Columns2 position = given.two(), aperture = given.two();
    std::vector<RayHit16> rays(padded(count) / 16);
    sensor.sample_ray_block(position, aperture, count, rays.data());
    const Columns3 p = given.three();
    BlockMemory memory(count);
    const ConnectionBlock out{memory.two(), memory.three(), memory.one(), memory.one()};
    sensor.connect_block(p, aperture, count, out);
    for (size_t i = 0; i < count; ++i) {
      const Ray ray = ray_hit_of(rays.data(), i).ray;
      const Ray expected = sensor.sample_ray(position.at(i), aperture.at(i));
      EXPECT_EQ(ray.o, expected.o);
      EXPECT_EQ(ray.d, expected.d);
      EXPECT_EQ(ray.tmin, expected.tmin);
      EXPECT_EQ(ray.tmax, expected.tmax);
      const auto seen = sensor.connect(p.at(i), aperture.at(i));
      EXPECT_EQ(out.weight[i], seen ? seen->weight : 0.f);
      if (!seen) continue;
      EXPECT_EQ(out.film_position.at(i), seen->film_position);
      EXPECT_EQ(out.d.at(i), seen->d);
      EXPECT_EQ(out.distance[i], seen->distance);
    }
  }
}

class PointTexture final : public Texture {
 public:
  Rgb eval(const Vec2& uv) const override { return mixed_vector(uv.x, uv.y); }
  float eval_1(const Vec2& uv) const override { return mixed(uv.x, uv.y); }
  Rgb mean() const override { return Rgb(0.5f); }
  float max() const override { return 1; }
  float min() const override { return 0; }
};

TEST(DefaultBlocks, OfATexture) {
  const PointTexture texture;
  for (const size_t count : kRanges) {
    Given given(count);
    const Columns2 uv = given.two();
    BlockMemory memory(count);
    const Columns3 color = memory.three();
    float* const number = memory.one();
    texture.eval_block(uv, count, color);
    texture.eval_1_block(uv, count, number);
    for (size_t i = 0; i < count; ++i) {
      EXPECT_EQ(color.at(i), texture.eval(uv.at(i)));
      EXPECT_EQ(number[i], texture.eval_1(uv.at(i)));
    }
  }
}

class PointFilter final : public ReconstructionFilter {
 public:
  float eval(float x) const override { return mixed(x); }
};

TEST(DefaultBlocks, OfAFilter) {
  const PointFilter filter;
  for (const size_t count : kRanges) {
    Given given(count);
    BlockMemory memory(count);
    float *const x = given.one(), *const weight = memory.one();
    filter.eval_block(x, count, weight);
    for (size_t i = 0; i < count; ++i) EXPECT_EQ(weight[i], filter.eval(x[i]));
  }
}

class PointEmitter final : public Emitter {
 public:
  Rgb eval_environment(const Vec3& d) const override { return mixed_vector(d.x, d.y, d.z); }
  float pdf_environment(const Vec3& d) const override { return mixed(d.z, d.x, d.y); }
  Rgb eval_surface(const SurfaceInteraction& si) const override {
    return mixed_vector(si.p.x, si.n.y, si.frame.s.z, si.frame.t.x, si.frame.n.y, si.wi.z, si.uv.x,
                        si.p_error, si.primitive, si.dp_du.x, si.dp_dv.y);
  }
  float pdf_surface(const Vec3& p, const SurfaceInteraction& si) const override {
    return mixed(p.x, p.y, p.z, si.p.y);
  }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    if (u.x < 0.3f) return std::nullopt;
    const Vec3 d = mixed_vector(p.x, p.y, p.z, u.x, u.y);
    return DirectSample{d, mixed(d.x), mixed(d.y), mixed_vector(d.z), u.y < 0.5f};
  }
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const override {
    if (position.x < 0.3f) return std::nullopt;
    EmissionSample sample;
    sample.o = mixed_vector(position.x, position.y);
    sample.d = mixed_vector(direction.x, direction.y) - 0.5f;
    sample.n = mixed_vector(position.y) - 0.5f;
    sample.o_error = 0.01f;
    sample.power = mixed_vector(position.x, direction.y);
    return sample;
  }
};

TEST(DefaultBlocks, OfAnEmittersSamples) {
  const PointEmitter emitter;
  for (const size_t count : kRanges) {
    Given given(count);
    const Columns3 p = given.three();
    const Columns2 u = given.two(), v = given.two();
    BlockMemory memory(count);
    const DirectBlock direct{memory.three(), memory.one(), memory.one(), memory.three(),
                             memory.one()};
    const EmissionBlock emission{memory.three(), memory.three(), memory.three()};
    emitter.sample_direct_block(p, u, count, direct);
    emitter.sample_emission_block(u, v, count, emission);
    for (size_t i = 0; i < count; ++i) {
      const auto toward = emitter.sample_direct(p.at(i), u.at(i));
      EXPECT_EQ(direct.pdf[i], toward ? toward->pdf : 0.f);
      if (toward) {
        EXPECT_EQ(direct.d.at(i), toward->d);
        EXPECT_EQ(direct.distance[i], toward->distance);
        EXPECT_EQ(direct.radiance.at(i), toward->radiance);
        EXPECT_EQ(direct.is_delta[i], toward->is_delta ? 1.f : 0.f);
      }
      const auto leaving = emitter.sample_emission(u.at(i), v.at(i));
      EXPECT_EQ(emission.power.at(i), leaving ? leaving->power : Rgb(0.f));
      if (leaving) {
        EXPECT_EQ(emission.o.at(i), leaving->ray().o);
        EXPECT_EQ(emission.d.at(i), leaving->d);
      }
    }
  }
}

TEST(DefaultBlocks, OfAnEmittersLight) {
  const PointEmitter emitter;
  for (const size_t count : kRanges) {
    for (const bool with_pdf : {false, true}) {
      Given given(count);
      const Columns3 d = given.three();
      const SurfaceBlock points = given.points();
      BlockMemory memory(count);
      const Columns3 sky = memory.three(), surface = memory.three();
      float *const sky_pdf = memory.one(), *const surface_pdf = memory.one();
      emitter.eval_environment_block(d, count, sky, with_pdf ? sky_pdf : nullptr);
      emitter.eval_surface_block(points, d, surface, with_pdf ? surface_pdf : nullptr);
      for (size_t i = 0; i < count; ++i) {
        const SurfaceInteraction si = interaction_of(points, i);
        EXPECT_EQ(sky.at(i), emitter.eval_environment(d.at(i)));
        EXPECT_EQ(surface.at(i), emitter.eval_surface(si));
        if (!with_pdf) continue;
        EXPECT_EQ(sky_pdf[i], emitter.pdf_environment(d.at(i)));
        EXPECT_EQ(surface_pdf[i], emitter.pdf_surface(d.at(i), si));
      }
    }
  }
}

}  // namespace
}  // namespace kinome::test::default_blocks_test
