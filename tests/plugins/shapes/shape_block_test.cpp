#include <gtest/gtest.h>

#include <cmath>

#include "kinome/shape.h"
#include "shape_cases.h"
#include "support/shape_helpers.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

/// Compares shapes over blocks with the same shapes at single points, for each instruction set.
/// Tolerances are multiples of kRounding, a few roundings of values of magnitude 1. They are larger
/// if the formula divides by a small value.
namespace kinome::test::shape_block_test {
namespace {

constexpr float kRounding = 8 * 0x1p-24f;

class ShapeBlocks : public testing::TestWithParam<InstructionSet> {
 protected:
  template <class Action>
  void for_shapes(const Action& action) const {
    for (const ShapeCase& c : shape_cases()) {
      SCOPED_TRACE(c.name);
      const auto shape = make_for<Shape>(GetParam(), c.xml);
      ASSERT_TRUE(shape);
      action(c, *shape);
    }
  }
};

/// Returns a ray toward a point in or near the shape, from inside, near or far away.
Ray random_ray(const ShapeCase& c, Random& random) {
  Ray ray;
  const float distance = c.size * std::exp(random.between(-3, 7));
  const Vec3 target = c.centre + random.direction() * (c.size * random.between(0, 1.1f));
  ray.o = target + random.direction() * distance;
  ray.d = (target - ray.o) * random.between(.1f, 3);
  if (random.unit() < .2f) ray.tmin = random.between(0, 5);
  if (random.unit() < .2f) ray.tmax = random.between(0, 5);
  return ray;
}

void set(Ray16& rays, size_t i, const Ray& ray) {
  Columns3{rays.ox, rays.oy, rays.oz}.set(i, ray.o);
  Columns3{rays.dx, rays.dy, rays.dz}.set(i, ray.d);
  rays.tmin[i] = ray.tmin;
  rays.tmax[i] = ray.tmax;
}

/// Sets `out` to a hit of a random ray, or of a random point of a random triangle of a mesh.
bool random_hit(const ShapeCase& c, const Shape& shape, Random& random, RayHit& out) {
  out.ray = random_ray(c, random);
  out.hit = Hit{};
  if (c.primitives == 0) {
    out.ray.tmin = 0;
    out.ray.tmax = kInfinity;
    float t = 0;
    if (!shape.intersect(out.ray, t, out.hit)) return false;
    out.ray.tmax = t;
    return true;
  }
  out.hit.primitive = static_cast<uint32_t>(random.between(0, static_cast<float>(c.primitives)));
  const float u = random.unit(), v = random.unit();
  out.hit.u = std::min(u, 1 - u);
  out.hit.v = v * (1 - out.hit.u);
  out.ray.tmax = 1;
  return true;
}

/// A block with `count` hits. The other lanes of its rays are NaN.
struct HitBlock {
  HitBlock(const ShapeCase& c, const Shape& shape, size_t count, Random& random)
      : hits(count), rays(padded(count) / 16), memory(count) {
    for (RayHit16& block : rays) {
      std::fill_n(reinterpret_cast<float*>(&block), sizeof block / sizeof(float), kNan);
    }
    points.count = count;
    for (Columns3* column : {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi}) {
      *column = memory.three();
    }
    points.uv = memory.two();
    points.p_error = memory.one();
    points.primitive = memory.indices();
    points.ray = memory.indices();
    for (size_t i = 0; i < count; ++i) {
      while (!random_hit(c, shape, random, hits[i])) {
      }
      // The order of points differs from that of rays.
      const size_t k = count - 1 - i;
      points.ray[i] = static_cast<uint32_t>(k);
      RayHit16& block = rays[k / 16];
      set(block.ray, k % 16, hits[i].ray);
      block.u[k % 16] = hits[i].hit.u;
      block.v[k % 16] = hits[i].hit.v;
      block.primitive[k % 16] = hits[i].hit.primitive;
    }
  }
  std::vector<RayHit> hits;
  std::vector<RayHit16> rays;
  BlockMemory memory;
  SurfaceBlock points;
};

/// Distance of two coordinates on a circle, where 0 and 1 are equal.
float distance_of_turns(float a, float b) {
  const float d = std::abs(a - b);
  return std::min(d, std::abs(1 - d));
}

void expect_same(const SurfaceInteraction& si, const SurfaceBlock& block, size_t i) {
  EXPECT_LE(largest_difference(block.p.at(i), si.p), si.p_error / 4);
  EXPECT_NEAR(block.p_error[i], si.p_error, 1e-6f * si.p_error);
  EXPECT_LE(largest_difference(block.n.at(i), si.n), kRounding);
  EXPECT_LE(largest_difference(block.sn.at(i), si.frame.n), kRounding);
  EXPECT_LE(distance_of_turns(block.uv.x[i], si.uv.x), kRounding);
  EXPECT_LE(distance_of_turns(block.uv.y[i], si.uv.y), kRounding);
  EXPECT_EQ(block.primitive[i], si.primitive);
  if (block.dp_du.x) {
    // Without a derivative, dp_du is that of any frame around n, which loses digits for z near -1.
    const float slack = si.n.z < 0 ? 1 / std::max(std::abs(1 + std::abs(si.n.z)), 1e-6f) : 1;
    EXPECT_LE(largest_difference(block.dp_du.at(i), si.dp_du),
              kRounding * slack * largest_coordinate(si.dp_du));
    EXPECT_LE(largest_difference(block.dp_dv.at(i), si.dp_dv),
              kRounding * slack * largest_coordinate(si.dp_dv));
  }
  // s is the part of dp_du perpendicular to n, which may cancel.
  const Vec3 along = si.dp_du - si.frame.n * glm::dot(si.frame.n, si.dp_du);
  const float left = glm::length(along) / glm::length(si.dp_du);
  if (left > .5e-6f && left < 2e-6f) return;  // rounding decides whether it is used
  const float bound = left > 1e-6f ? 2 * kRounding / left : kRounding;
  EXPECT_LE(largest_difference(block.s.at(i), si.frame.s), bound);
  EXPECT_LE(largest_difference(block.t.at(i), si.frame.t), bound);
  EXPECT_LE(largest_difference(block.wi.at(i), si.wi), bound);
}

TEST_P(ShapeBlocks, InteractionsMatchSinglePoints) {
  for_shapes([](const ShapeCase& c, const Shape& shape) {
    Random random(1);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        HitBlock block(c, shape, count, random);
        if (repeat % 2 == 0) {
          block.points.dp_du = block.memory.three();
          block.points.dp_dv = block.memory.three();
        }
        shape.interaction_block(block.rays.data(), block.points);
        for (size_t i = 0; i < count; ++i) {
          expect_same(shape.interaction(block.hits[i].ray, block.hits[i].hit), block.points, i);
          if (testing::Test::HasFailure()) {
            const RayHit& hit = block.hits[i];
            FAIL() << "at " << i << " of " << count << ": primitive " << hit.hit.primitive << ", u "
                   << hit.hit.u << ", v " << hit.hit.v;
          }
        }
      }
    }
  });
}

TEST_P(ShapeBlocks, RaysMeetThemAsSingleOnesDo) {
  for_shapes([](const ShapeCase& c, const Shape& shape) {
    if (c.primitives > 0) return;
    Random random(2);
    size_t hits = 0, misses = 0;
    for (int repeat = 0; repeat < 200; ++repeat) {
      alignas(64) Ray16 rays;
      reset(rays);
      alignas(64) int valid[16];
      std::vector<Ray> single(16);
      for (size_t i = 0; i < 16; ++i) {
        valid[i] = random.unit() < .8f ? -1 : 0;
        single[i] = random_ray(c, random);
        if (valid[i] == 0) single[i].o.x = single[i].d.y = single[i].tmax = kNan;
        // Also tests rays from the surface itself, through the middle, and past the rim.
        if (i == 3) single[i].o = shape.sample_surface({random.unit(), random.unit()}).p;
        if (i == 5) single[i].d = c.centre - single[i].o;
        if (i == 7) single[i].d = Vec3(0, 0, 1);
        set(rays, i, single[i]);
      }
      ShapeHit16 found;
      std::fill_n(found.t, 16, kNan);
      shape.intersect_block(rays, valid, found);
      for (size_t i = 0; i < 16; ++i) {
        float t = kInfinity;
        Hit hit;
        if (valid[i] == 0 || !shape.intersect(single[i], t, hit)) t = kInfinity;
        // Both use the same steps in double precision.
        ASSERT_EQ(found.t[i], t) << "ray " << i;
        ++(t < kInfinity ? hits : misses);
        if (t < kInfinity) {
          EXPECT_EQ(found.primitive[i], 0u);
        }
      }
    }
    EXPECT_GT(hits, 300u);
    EXPECT_GT(misses, 300u);
  });
}

/// Returns viewpoints: near and far, inside the shape, at its centre, and on its surface.
Vec3 random_viewer(const ShapeCase& c, const Shape& shape, Random& random) {
  const float kind = random.unit();
  if (kind < .1f) return c.centre;
  if (kind < .2f) return shape.sample_surface({random.unit(), random.unit()}).p;
  return c.centre + random.direction() * (c.size * std::exp(random.between(-4, 10)));
}

TEST_P(ShapeBlocks, AreSampledAsFromPoints) {
  for_shapes([](const ShapeCase& c, const Shape& shape) {
    Random random(3);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        BlockMemory memory(count);
        const Columns3 p = memory.three();
        const Columns2 u = memory.two();
        const SurfaceSampleBlock out{memory.three(), memory.three(), memory.two(), memory.one()};
        for (size_t i = 0; i < count; ++i) {
          p.set(i, random_viewer(c, shape, random));
          u.set(i, {random.unit(), random.unit()});
        }
        shape.sample_solid_angle_block(p, u, count, out);
        for (size_t i = 0; i < count; ++i) {
          const auto sample = shape.sample_solid_angle(p.at(i), u.at(i));
          const SurfaceInteraction si = sample ? sample->si : shape.sample_surface(u.at(i));
          const Vec3 to = si.p - p.at(i);
          const float distance = glm::length(to);
          // Skips positions whose error decides whether they are visible, and from which side.
          if (!si.resolves(to / distance, distance / 4)) continue;
          ASSERT_EQ(out.pdf[i] > 0, sample.has_value()) << i << " of " << count;
          if (!sample) continue;
          // A sphere's azimuth has single precision.
          EXPECT_LE(largest_difference(out.p.at(i), si.p), si.p_error + kRounding * c.size);
          EXPECT_LE(largest_difference(out.sn.at(i), si.frame.n), 2 * kRounding);
          // At the poles of a sphere, u is arbitrary.
          const float sine = std::sin(kPi * std::clamp(si.uv.y, .001f, .999f));
          EXPECT_LE(distance_of_turns(out.uv.x[i], si.uv.x), 2 * kRounding / sine);
          EXPECT_LE(distance_of_turns(out.uv.y[i], si.uv.y), 2 * kRounding);
          // Errors of the position and of the cosine matter at grazing angles.
          const float height = std::abs(glm::dot(si.n, to));
          const float error = kRounding * (2 + distance / height) + 8 * si.p_error / height;
          EXPECT_NEAR(out.pdf[i], sample->pdf, sample->pdf * error);
          if (testing::Test::HasFailure()) FAIL() << "at " << i << " of " << count;
        }
      }
    }
  });
}

TEST_P(ShapeBlocks, HaveTheDensitiesOfPoints) {
  for_shapes([](const ShapeCase& c, const Shape& shape) {
    Random random(4);
    for (const size_t count : kRanges) {
      HitBlock block(c, shape, count, random);
      shape.interaction_block(block.rays.data(), block.points);
      const Columns3 p = block.memory.three();
      float* const pdf = block.memory.one();
      for (size_t i = 0; i < count; ++i) p.set(i, random_viewer(c, shape, random));
      shape.pdf_solid_angle_block(p, block.points, pdf);
      for (size_t i = 0; i < count; ++i) {
        SurfaceInteraction si;
        si.p = block.points.p.at(i);
        si.p_error = block.points.p_error[i];
        si.n = block.points.n.at(i);
        const float expected = shape.pdf_solid_angle(p.at(i), si);
        const Vec3 to = si.p - p.at(i);
        // The cosine is a sum that may cancel.
        const float cosine = std::abs(glm::dot(si.n, to)) / glm::length(to);
        if (!(cosine > 1e-5f)) continue;
        EXPECT_NEAR(pdf[i], expected, expected * kRounding * (1 + 1 / cosine)) << i;
      }
    }
  });
}

TEST_P(ShapeBlocks, AreSampledByAreaAsOneByOne) {
  for_shapes([](const ShapeCase& c, const Shape& shape) {
    Random random(5);
    for (const size_t count : kRanges) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        HitBlock block(c, shape, count, random);
        const Columns2 u = block.memory.two();
        for (size_t i = 0; i < count; ++i) {
          u.set(i, {random.unit(), random.unit()});
          if (i % 16 == 5) u.set(i, {0, 0});
          if (i % 16 == 7) u.set(i, {kOneMinusEpsilon, kOneMinusEpsilon});
        }
        shape.sample_surface_block(u, block.points);
        for (size_t i = 0; i < count; ++i) {
          const SurfaceInteraction si = shape.sample_surface(u.at(i));
          if (c.primitives > 0) {
            expect_same(si, block.points, i);
          } else {
            // Positions depend on sines, which are exact to one or two ulps.
            const SurfaceBlock& points = block.points;
            EXPECT_LE(largest_difference(points.p.at(i), si.p), kRounding * c.size + si.p_error);
            EXPECT_NEAR(points.p_error[i], si.p_error, 1e-5f * si.p_error);
            EXPECT_LE(largest_difference(points.n.at(i), si.n), 2 * kRounding);
            EXPECT_LE(largest_difference(points.sn.at(i), si.frame.n), 2 * kRounding);
            EXPECT_EQ(points.primitive[i], si.primitive);
          }
          if (testing::Test::HasFailure()) {
            FAIL() << "at " << i << " of " << count << ", u " << u.x[i] << ' ' << u.y[i];
          }
        }
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Sets, ShapeBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace
}  // namespace kinome::test::shape_block_test
