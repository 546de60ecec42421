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

/// Tests the default block functions of shapes.
namespace kinome::test::default_shape_blocks_test {
namespace {

using namespace default_blocks;

class PointShape final : public Shape {
 public:
  PointShape() : Shape(Properties(Category::kShape, "point_shape", Location())) {}
  Aabb bounds() const override { return {}; }
  float area() const override { return 2; }
  bool intersect(const Ray& ray, float& t, Hit& hit) const override {
    t = 3 * mixed(ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z);
    hit.ng = mixed_vector(t);
    hit.u = mixed(4, t), hit.v = mixed(5, t);
    hit.primitive = static_cast<uint32_t>(100 * mixed(6, t));
    return ray.d.x > 0.2f;
  }
  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override {
    return point(
        mixed(ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.tmax, hit.u, hit.v, hit.ng.x, hit.primitive));
  }
  SurfaceInteraction sample_surface(const Vec2& u) const override { return point(mixed(u.x, u.y)); }
  std::optional<SurfaceSample> sample_solid_angle(const Vec3& p, const Vec2& u) const override {
    if (u.x < 0.3f) return std::nullopt;
    return SurfaceSample{point(mixed(p.x, p.y, p.z, u.x, u.y)), mixed(p.y)};
  }
  float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const override {
    return mixed(p.x, p.y, p.z, si.p.x, si.n.y, si.uv.y);
  }

 private:
  static SurfaceInteraction point(float seed) {
    SurfaceInteraction si;
    si.p = mixed_vector(seed, 1), si.n = mixed_vector(seed, 2);
    si.frame = {mixed_vector(seed, 3), mixed_vector(seed, 4), mixed_vector(seed, 5)};
    si.dp_du = mixed_vector(seed, 6), si.dp_dv = mixed_vector(seed, 7);
    si.wi = mixed_vector(seed, 8), si.uv = Vec2(mixed(seed, 9), mixed(seed, 10));
    si.p_error = mixed(seed, 11), si.primitive = static_cast<uint32_t>(1000 * seed);
    return si;
  }
};

void expect_same(const SurfaceInteraction& a, const SurfaceInteraction& b) {
  EXPECT_EQ(a.p, b.p);
  EXPECT_EQ(a.n, b.n);
  EXPECT_EQ(a.frame.s, b.frame.s);
  EXPECT_EQ(a.frame.t, b.frame.t);
  EXPECT_EQ(a.frame.n, b.frame.n);
  EXPECT_EQ(a.dp_du, b.dp_du);
  EXPECT_EQ(a.dp_dv, b.dp_dv);
  EXPECT_EQ(a.uv, b.uv);
  EXPECT_EQ(a.p_error, b.p_error);
  EXPECT_EQ(a.primitive, b.primitive);
}

/// Returns random rays in blocks. Unused lanes are NaN.
std::vector<RayHit16> given_rays(size_t count) {
  std::vector<RayHit16> rays(padded(count) / 16);
  for (RayHit16& block : rays) {
    std::fill_n(reinterpret_cast<float*>(&block), sizeof block / sizeof(float), kNan);
  }
  for (size_t i = 0; i < count; ++i) {
    RayHit16& block = rays[i / 16];
    const size_t lane = i % 16;
    Columns3{block.ray.ox, block.ray.oy, block.ray.oz}.set(lane, mixed_vector(i, 1));
    Columns3{block.ray.dx, block.ray.dy, block.ray.dz}.set(lane, mixed_vector(i, 2));
    Columns3{block.ngx, block.ngy, block.ngz}.set(lane, mixed_vector(i, 3));
    block.ray.tmin[lane] = 0.5f * mixed(i, 4), block.ray.tmax[lane] = 1 + mixed(i, 5);
    block.u[lane] = mixed(i, 6), block.v[lane] = mixed(i, 7);
    block.primitive[lane] = static_cast<uint32_t>(i);
  }
  return rays;
}

TEST(DefaultBlocks, OfAShapesPoints) {
  const PointShape shape;
  for (const size_t count : kRanges) {
    Given given(count), sampled(count);
    const std::vector<RayHit16> rays = given_rays(count);
    const SurfaceBlock met = given.points(), chosen = sampled.points();
    const Columns2 u = given.two();
    shape.interaction_block(rays.data(), met);
    shape.sample_surface_block(u, chosen);
    for (size_t i = 0; i < count; ++i) {
      const RayHit hit = ray_hit_of(rays.data(), met.ray[i]);
      const SurfaceInteraction expected = shape.interaction(hit.ray, hit.hit);
      expect_same(interaction_of(met, i), expected);
      EXPECT_EQ(met.wi.at(i), expected.wi);
      expect_same(interaction_of(chosen, i), shape.sample_surface(u.at(i)));
    }
  }
}

TEST(DefaultBlocks, OfAShapeSeenFromPoints) {
  const PointShape shape;
  for (const size_t count : kRanges) {
    Given given(count);
    const Columns3 p = given.three();
    const Columns2 u = given.two();
    const SurfaceBlock points = given.points();
    BlockMemory memory(count);
    const SurfaceSampleBlock out{memory.three(), memory.three(), memory.two(), memory.one()};
    float* const pdf = memory.one();
    shape.sample_solid_angle_block(p, u, count, out);
    shape.pdf_solid_angle_block(p, points, pdf);
    for (size_t i = 0; i < count; ++i) {
      EXPECT_EQ(pdf[i], shape.pdf_solid_angle(p.at(i), interaction_of(points, i)));
      const auto expected = shape.sample_solid_angle(p.at(i), u.at(i));
      EXPECT_EQ(out.pdf[i], expected ? expected->pdf : 0.f);
      if (!expected) continue;
      EXPECT_EQ(out.p.at(i), expected->si.p);
      EXPECT_EQ(out.sn.at(i), expected->si.frame.n);
      EXPECT_EQ(out.uv.at(i), expected->si.uv);
    }
  }
}

TEST(DefaultBlocks, OfAShapesHits) {
  const PointShape shape;
  const std::vector<RayHit16> rays = given_rays(64);
  size_t hits = 0;
  for (size_t block = 0; block < rays.size(); ++block) {
    int valid[16];
    for (int i = 0; i < 16; ++i) valid[i] = i % 3 == 0 ? 0 : -1;
    ShapeHit16 out;
    shape.intersect_block(rays[block].ray, valid, out);
    for (size_t i = 0; i < 16; ++i) {
      const Ray ray = ray_of(&rays[block].ray, i);
      float t = 0;
      Hit hit;
      const bool is_hit =
          valid[i] != 0 && shape.intersect(ray, t, hit) && t >= ray.tmin && t <= ray.tmax;
      ASSERT_EQ(out.t[i], is_hit ? t : kInfinity);
      if (!is_hit) continue;
      ++hits;
      EXPECT_EQ(Vec3(out.ngx[i], out.ngy[i], out.ngz[i]), hit.ng);
      EXPECT_EQ(out.u[i], hit.u);
      EXPECT_EQ(out.v[i], hit.v);
      EXPECT_EQ(out.primitive[i], hit.primitive);
    }
  }
  EXPECT_GT(hits, 5u);
}

}  // namespace
}  // namespace kinome::test::default_shape_blocks_test
