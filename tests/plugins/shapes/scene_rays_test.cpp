// Tests rays in a whole scene: nearest hits and occlusion, single rays and batches.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "support/shape_helpers.h"

namespace kinome::test::scene_rays_test {
namespace {

/// All kinds of geometry: two meshes and three analytic shapes, some overlapping.
const char* const kMixedScene = R"(
  <shape type="rectangle"><transform name="to_world"><scale value="6"/></transform></shape>
  <shape type="cube"><transform name="to_world"><rotate z="1" angle="30"/>
    <translate x="2" z="1.2"/></transform></shape>
  <shape type="sphere"><point name="center" x="-2" y="0.5" z="1.2"/></shape>
  <shape type="cylinder"><point name="p0" x="0" y="-3" z="0"/><point name="p1" x="0" y="3" z="2"/>
    <float name="radius" value="0.4"/></shape>
  <shape type="disk"><transform name="to_world"><scale value="2"/>
    <translate z="3"/></transform></shape>)";

std::vector<RayHit> random_rays(size_t count, uint64_t seed) {
  Random random(seed);
  std::vector<RayHit> rays;
  for (size_t i = 0; i < count; ++i) {
    const Vec3 target(random.between(-5, 5), random.between(-5, 5), random.between(0, 3));
    const Vec3 o = target + random.direction() * random.between(0.5f, 12);
    rays.push_back(ray_hit(o, (target - o) * random.between(0.1f, 3)));
  }
  return rays;
}

std::vector<RayHit> singly(const Scene& scene, std::vector<RayHit> rays) {
  RenderCounters counters;
  for (RayHit& ray : rays) scene.intersect({&ray, 1}, Coherence::kIncoherent, counters);
  return rays;
}

/// Embree builds with assertions abort for such rays.
TEST(SceneRays, NonFiniteOnesHitNothingAndDontAffectOthers) {
  const auto scene = scene_from(kMixedScene);
  const std::vector<RayHit> good = random_rays(64, 3);
  const float bad[] = {NAN, kInfinity, -kInfinity, 1e30f, -3e38f};
  for (const Coherence coherence : {Coherence::kCoherent, Coherence::kIncoherent}) {
    for (int place = 0; place < 8; ++place) {
      for (const float value : bad) {
        if (place >= 6 && !std::isnan(value)) continue;  // tmin and tmax may be infinite
        std::vector<RayHit> rays = good;
        Ray& ray = rays[17].ray;
        float* const values[] = {&ray.o.x, &ray.o.y, &ray.o.z,  &ray.d.x,
                                 &ray.d.y, &ray.d.z, &ray.tmin, &ray.tmax};
        *values[place] = value;
        std::vector<Ray> shadow;
        for (const RayHit& r : rays) shadow.push_back(r.ray);
        std::vector<RayHit> expected = good;
        RenderCounters counters;
        scene->intersect(rays, coherence, counters);
        scene->intersect(expected, coherence, counters);
        scene->occluded(shadow, coherence, counters);
        for (size_t i = 0; i < rays.size(); ++i) {
          if (i == 17) {
            EXPECT_FALSE(rays[i].hit.valid());
            EXPECT_FALSE(shadow[i].is_occluded());
            continue;
          }
          EXPECT_EQ(rays[i].hit.shape, expected[i].hit.shape);
          EXPECT_EQ(rays[i].ray.tmax, expected[i].ray.tmax);
          EXPECT_EQ(shadow[i].is_occluded(), expected[i].hit.valid());
        }
        // The invalid value is unchanged.
        const float left = *values[place];
        EXPECT_TRUE(left == value || (std::isnan(left) && std::isnan(value)));
      }
    }
  }
}

TEST(SceneRays, BatchesOfAnySizeAgreeWithSingleRays) {
  const auto scene = scene_from(kMixedScene);
  const std::vector<RayHit> rays = random_rays(20000, 1);
  const std::vector<RayHit> expected = singly(*scene, rays);
  std::array<size_t, 5> hits_of{};
  for (const RayHit& ray : expected) {
    if (ray.hit.valid()) ++hits_of.at(ray.hit.shape);
  }
  for (const size_t hits : hits_of) EXPECT_GT(hits, 100u);  // each shape is hit

  RenderCounters counters;
  for (const Coherence coherence : {Coherence::kCoherent, Coherence::kIncoherent}) {
    for (const size_t size : {1u, 3u, 16u, 17u, 500u, 20000u}) {
      std::vector<RayHit> batch = rays;
      for (size_t first = 0; first < batch.size(); first += size) {
        scene->intersect({&batch[first], std::min(size, batch.size() - first)}, coherence,
                         counters);
      }
      for (size_t i = 0; i < batch.size(); ++i) {
        ASSERT_EQ(batch[i].hit.shape, expected[i].hit.shape) << "ray " << i << ", size " << size;
        if (!expected[i].hit.valid()) {
          ASSERT_EQ(batch[i].ray.tmax, kInfinity);
          continue;
        }
        // Embree's packet and single-ray kernels add in different orders. The error is some ulps of
        // the coordinates (at most 20), divided by the length of the direction (at least 0.05).
        ASSERT_NEAR(batch[i].ray.tmax, expected[i].ray.tmax, 3e-4f) << "ray " << i;
        ASSERT_EQ(batch[i].hit.primitive, expected[i].hit.primitive) << "ray " << i;
      }
    }
  }
  EXPECT_GT(counters.embree_seconds, 0);
}

TEST(SceneRays, OccludedIfTheNearestHitIsOnTheSegment) {
  const auto scene = scene_from(kMixedScene);
  std::vector<RayHit> nearest = random_rays(20000, 2);
  std::vector<Ray> segments;
  Random random(3);
  for (RayHit& ray : nearest) {
    ray.ray.tmin = random.unit();
    segments.push_back(ray.ray);
    segments.back().tmax = ray.ray.tmin + random.between(0, 5);
  }
  nearest = singly(*scene, nearest);
  RenderCounters counters;
  for (const Coherence coherence : {Coherence::kCoherent, Coherence::kIncoherent}) {
    for (const size_t size : {1u, 19u, 2000u}) {
      std::vector<Ray> batch = segments;
      for (size_t first = 0; first < batch.size(); first += size) {
        scene->occluded({&batch[first], std::min(size, batch.size() - first)}, coherence, counters);
      }
      size_t occluded = 0;
      for (size_t i = 0; i < batch.size(); ++i) {
        const float t = nearest[i].ray.tmax;
        if (std::abs(t - segments[i].tmax) < 1e-3f) continue;  // rounding may decide
        ASSERT_EQ(batch[i].is_occluded(), t < segments[i].tmax) << "ray " << i << ", size " << size;
        occluded += batch[i].is_occluded();
        if (!batch[i].is_occluded()) {
          ASSERT_EQ(batch[i].tmax, segments[i].tmax);
        } else {
          ASSERT_EQ(batch[i].tmax, -kInfinity);
        }
      }
      EXPECT_GT(occluded, 2000u);
      EXPECT_LT(occluded, 18000u);
    }
  }
}

TEST(SceneRays, NeverBeforeTminNorBeyondTmax) {
  const auto scene = scene_from(kMixedScene);
  std::vector<RayHit> rays = random_rays(20000, 4);
  Random random(5);
  for (RayHit& ray : rays) {
    ray.ray.tmin = random.between(0, 3);
    ray.ray.tmax = ray.ray.tmin + random.between(0, 3);
  }
  const std::vector<RayHit> before = rays;
  RenderCounters counters;
  scene->intersect(rays, Coherence::kCoherent, counters);
  size_t hits = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!rays[i].hit.valid()) continue;
    ++hits;
    ASSERT_GE(rays[i].ray.tmax, before[i].ray.tmin);
    ASSERT_LE(rays[i].ray.tmax, before[i].ray.tmax);
  }
  EXPECT_GT(hits, 1000u);
}

TEST(SceneRays, EmptySceneAndEmptyBatches) {
  const Scene scene({}, 1);
  EXPECT_TRUE(scene.bounds().empty());
  EXPECT_EQ(scene.environment(), nullptr);
  EXPECT_FALSE(scene.has_surface_emitters());
  RenderCounters counters;
  scene.intersect({}, Coherence::kCoherent, counters);
  scene.occluded({}, Coherence::kIncoherent, counters);
  std::vector<RayHit> rays = random_rays(100, 6);
  scene.intersect(rays, Coherence::kCoherent, counters);
  std::vector<Ray> segments;
  for (const RayHit& ray : rays) {
    EXPECT_FALSE(ray.hit.valid());
    segments.push_back(ray.ray);
  }
  scene.occluded(segments, Coherence::kIncoherent, counters);
  for (const Ray& ray : segments) EXPECT_EQ(ray.tmax, kInfinity);
}

/// A shape and an emitter whose behaviour tests can set.
class TestShape : public Shape {
 public:
  explicit TestShape(std::shared_ptr<Object> emitter = nullptr) : Shape(properties(emitter)) {}
  Aabb box{Vec3(-1), Vec3(1)};
  Aabb bounds() const override { return box; }
  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 1; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 private:
  static Properties properties(const std::shared_ptr<Object>& emitter) {
    Properties props(Category::kShape, "test", {});
    if (emitter) props.set("emitter", emitter, {});
    return props;
  }
};

/// A triangle in a buffer without padding.
class TightTriangle : public TestShape {
 public:
  TightTriangle() {
    mesh_.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh_.positions.shrink_to_fit();
    mesh_.triangles = {{0, 1, 2}};
  }
  const TriangleMesh* mesh() const override { return &mesh_; }

 private:
  TriangleMesh mesh_;
};

class TestEmitter : public Emitter {
 public:
  enum Kind { kPoint, kEnvironment, kSurface, kIndirect };
  explicit TestEmitter(Kind kind, std::vector<std::shared_ptr<Emitter>> children = {})
      : kind_(kind), children_(std::move(children)) {}
  bool is_environment() const override { return kind_ == kEnvironment; }
  bool is_surface() const override { return kind_ == kSurface; }
  bool is_indirect() const override { return kind_ == kIndirect; }
  std::vector<std::shared_ptr<Emitter>> children() const override { return children_; }
  void prepare(const Aabb& bounds) override {
    ++prepared;
    prepared_for = bounds;
  }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override {
    return std::nullopt;
  }
  int prepared = 0;
  Aabb prepared_for;

 private:
  Kind kind_;
  std::vector<std::shared_ptr<Emitter>> children_;
};

class SceneContents : public testing::Test {
 protected:
  std::shared_ptr<TestShape> add(std::shared_ptr<TestShape> shape) {
    shape->set_bsdf(make<Bsdf>("<bsdf type='diffuse'/>"));
    contents_.shapes.push_back(shape);
    return shape;
  }
  std::string error() {
    return error_of([&] { const Scene scene(contents_, 1); });
  }
  Scene::Contents contents_;
};

TEST_F(SceneContents, GathersEmittersAndPreparesEachOnceWithTheWholeBounds) {
  const auto lamp = std::make_shared<TestEmitter>(TestEmitter::kPoint);
  const auto glow = std::make_shared<TestEmitter>(TestEmitter::kSurface);
  const auto sky = std::make_shared<TestEmitter>(TestEmitter::kEnvironment);
  const auto bounce = std::make_shared<TestEmitter>(TestEmitter::kIndirect,
                                                    std::vector<std::shared_ptr<Emitter>>{lamp});
  const auto shape = add(std::make_shared<TestShape>(glow));
  add(std::make_shared<TestShape>())->box = {Vec3(0, 0, 0), Vec3(5, 6, 7)};
  contents_.emitters = {bounce, sky};
  const Scene scene(contents_, 1);
  EXPECT_EQ(scene.emitters(), (std::vector<const Emitter*>{lamp.get(), sky.get(), glow.get()}));
  EXPECT_EQ(scene.indirect_emitters(), (std::vector<const Emitter*>{bounce.get()}));
  EXPECT_EQ(scene.environment(), sky.get());
  EXPECT_TRUE(scene.has_surface_emitters());
  EXPECT_EQ(glow->shape(), shape.get());
  for (const auto& emitter : {lamp, glow, sky, bounce}) {
    EXPECT_EQ(emitter->prepared, 1);
    EXPECT_EQ(emitter->prepared_for.lo, Vec3(-1));
    EXPECT_EQ(emitter->prepared_for.hi, Vec3(5, 6, 7));
  }
}

TEST_F(SceneContents, RejectsTwoEnvironments) {
  const auto inner = std::make_shared<TestEmitter>(TestEmitter::kEnvironment);
  contents_.emitters = {std::make_shared<TestEmitter>(TestEmitter::kEnvironment),
                        std::make_shared<TestEmitter>(
                            TestEmitter::kIndirect, std::vector<std::shared_ptr<Emitter>>{inner})};
  EXPECT_NE(error().find("one environment emitter"), std::string::npos) << error();
}

TEST_F(SceneContents, RejectsASurfaceEmitterWithoutAShape) {
  contents_.emitters = {std::make_shared<TestEmitter>(TestEmitter::kSurface)};
  EXPECT_NE(error().find("must be part of a shape"), std::string::npos) << error();
}

TEST_F(SceneContents, RejectsEmittersOnShapesThatAreNotTheirSurfaces) {
  for (const auto kind : {TestEmitter::kEnvironment, TestEmitter::kPoint}) {
    const std::string message =
        error_of([&] { const TestShape shape(std::make_shared<TestEmitter>(kind)); });
    EXPECT_NE(message.find("use 'area'"), std::string::npos) << message;
  }
}

TEST_F(SceneContents, RejectsAnEmitterOfTwoShapes) {
  const auto glow = std::make_shared<TestEmitter>(TestEmitter::kSurface);
  const TestShape first(glow);
  const std::string message = error_of([&] { const TestShape second(glow); });
  EXPECT_NE(message.find("one shape only"), std::string::npos) << message;
}

TEST_F(SceneContents, RejectsAShapeWithoutBsdf) {
  contents_.shapes.push_back(std::make_shared<TestShape>());
  EXPECT_NE(error().find("shape 0 has no BSDF"), std::string::npos) << error();
}

TEST_F(SceneContents, RejectsBoundsThatAreNotFinite) {
  const auto shape = add(std::make_shared<TestShape>());
  for (const Aabb& box : {Aabb{Vec3(0), Vec3(kInfinity)}, Aabb{Vec3(0), Vec3(NAN)}}) {
    shape->box = box;
    EXPECT_NE(error().find("no finite bounds"), std::string::npos) << error();
  }
}

TEST_F(SceneContents, RejectsShapesTooFarForTheRayTracer) {
  const auto shape = add(std::make_shared<TestShape>());
  shape->box = Aabb{Vec3(-1), Vec3(1, 2e18f, 1)};
  EXPECT_NE(error().find("shape 0 extends beyond 1e18"), std::string::npos) << error();
  shape->box = Aabb{Vec3(-9e17f), Vec3(9e17f)};
  EXPECT_EQ(error(), "");
}

TEST_F(SceneContents, CopiesVerticesThatEmbreeCantReadDirectly) {
  add(std::make_shared<TightTriangle>());
  const Scene scene(contents_, 1);
  EXPECT_TRUE(trace(scene, {0.2f, 0.2f, 1}, {0, 0, -1}).hit.valid());
  EXPECT_FALSE(trace(scene, {0.7f, 0.7f, 1}, {0, 0, -1}).hit.valid());
}

}  // namespace
}  // namespace kinome::test::scene_rays_test
