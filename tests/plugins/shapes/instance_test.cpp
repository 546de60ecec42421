// Tests that instances equal moved copies of their group's shapes.

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>

#include "kinome/block_points.h"
#include "kinome/texture.h"
#include "plugins/shapes/instances.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"
#include "support/shape_helpers.h"

namespace kinome::test::instance_test {
namespace {

using namespace instances;

void expect_near(const SurfaceInteraction& a, const SurfaceInteraction& b) {
  const auto near = [](const Vec3& x, const Vec3& y) {
    EXPECT_LT(glm::length(x - y), 5e-5f * std::max(1.f, glm::length(y)));
  };
  EXPECT_NEAR(a.t, b.t, 1e-5f * b.t);
  near(a.p, b.p), near(a.n, b.n), near(a.dp_du, b.dp_du), near(a.dp_dv, b.dp_dv);
  near(a.frame.n, b.frame.n), near(a.frame.s, b.frame.s), near(a.frame.t, b.frame.t);
  near(a.wi, b.wi), near(Vec3(a.uv, 0), Vec3(b.uv, 0));
  EXPECT_EQ(a.primitive, b.primitive);
}

/// Under non-uniform scaling, the normals of an instance and of a moved mesh differ. Those of an
/// instance are interpolated before they are transformed, as in Mitsuba.
TEST_F(Instances, MatchTheMovedShape) {
  const std::pair<const char*, const char*> cases[] = {
      {"sphere", kSimilar},   {"cylinder", kSimilar}, {"cube", kAffine},      {"disk", kAffine},
      {"rectangle", kAffine}, {"obj", kSimilar},      {"obj", kTurnedMirror},
  };
  for (const auto& [type, operations] : cases) {
    SCOPED_TRACE(std::string(type) + operations);
    const auto plain = scene_from(shape(type, moved(operations)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(operations));
    ASSERT_EQ(scene->shapes().size(), 1u);
    EXPECT_EQ(scene->shapes()[0]->mesh(), nullptr);
    EXPECT_LE(scene->bounds().lo.x, plain->bounds().lo.x + 1e-4f);
    EXPECT_GE(scene->bounds().hi.z, plain->bounds().hi.z - 1e-4f);
    Random random(1);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 target = Vec3(3, -2, .5f) + 2.f * random.unit() * random.direction();
      const Vec3 o = Vec3(3, -2, .5f) + 9.f * random.direction();
      const RayHit expected = trace(*plain, o, target - o), hit = trace(*scene, o, target - o);
      // At edges, rounding decides which primitive is hit.
      if (!expected.hit.valid() || !hit.hit.valid()) continue;
      if (std::abs(expected.ray.tmax - hit.ray.tmax) > 1e-3f) continue;
      if (expected.hit.primitive != hit.hit.primitive) continue;
      ++hits;
      EXPECT_EQ(hit.hit.shape, 0u);
      const SurfaceInteraction si = plain->interaction(expected);
      // Near its centre, the direction of a disk's frame is numerically unstable.
      if (std::string(type) == "disk" && si.uv.x < 0.2f) continue;
      expect_near(scene->interaction(hit), si);
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(hits, 500);
  }
}

TEST_F(Instances, AreMetAsOftenAsTheMovedShape) {
  for (const char* type : {"cube", "obj", "disk"}) {
    const auto plain = scene_from(shape(type, moved(kAffine)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(kAffine));
    Random random(2);
    std::vector<RayHit> a, b;
    std::vector<Ray> shadow_a, shadow_b;
    for (int i = 0; i < 5000; ++i) {
      const Vec3 o = Vec3(3, -2, .5f) + 9.f * random.direction();
      a.push_back(ray_hit(o, Vec3(3, -2, .5f) + 3.f * random.direction() - o));
      shadow_a.push_back(a.back().ray);
    }
    b = a, shadow_b = shadow_a;
    RenderCounters counters;
    for (const Coherence coherence : {Coherence::kCoherent, Coherence::kIncoherent}) {
      auto hits_a = a, hits_b = b;
      plain->intersect(hits_a, coherence, counters);
      scene->intersect(hits_b, coherence, counters);
      auto dark_a = shadow_a, dark_b = shadow_b;
      plain->occluded(dark_a, coherence, counters);
      scene->occluded(dark_b, coherence, counters);
      int differ = 0, hits = 0;
      for (size_t i = 0; i < a.size(); ++i) {
        hits += hits_a[i].hit.valid();
        differ += hits_a[i].hit.valid() != hits_b[i].hit.valid();
        differ += dark_a[i].is_occluded() != dark_b[i].is_occluded();
        EXPECT_EQ(hits_b[i].hit.valid(), dark_b[i].is_occluded());
      }
      EXPECT_GT(hits, 100);
      EXPECT_LE(differ, 4);  // at edges
    }
  }
}

/// Traces two instances of a group of two shapes, and shapes around them. The shape index of a hit
/// must be its index in Scene::shapes() for all ways to trace.
TEST_F(Instances, ReportThePartThatWasHit) {
  const std::string near = shape("disk", ""), far = shape("cube", moved("<translate x='5'/>"));
  const auto scene =
      scene_from(shape("sphere", moved("<translate y='30'/>")) + group_of(near + far) +
                 instance("<translate y='10'/>") + instance("<translate y='20'/>") +
                 shape("disk", moved("<translate y='40'/>")));
  ASSERT_EQ(scene->shapes().size(), 6u);
  const Vec3 targets[] = {{0, 30, 0}, {0, 10, 0}, {5, 10, 0}, {0, 20, 0}, {5, 20, 0}, {0, 40, 0}};
  RayHit16 packet{};
  reset(packet.ray);
  std::fill_n(packet.shape, 16, kNoHit), std::fill_n(packet.instance, 16, kNoHit);
  std::fill_n(packet.ray.tmax, 16, -1.f);
  std::vector<RayHit> stream;
  for (uint32_t i = 0; i < 6; ++i) {
    const Vec3 o = targets[i] + Vec3(.1f, .2f, 7), d(0, 0, -1);
    EXPECT_EQ(trace(*scene, o, d).hit.shape, i);
    EXPECT_EQ(scene->interaction(trace(*scene, o, d)).shape, scene->shapes()[i].get());
    stream.push_back(ray_hit(o, d));
    Columns3{packet.ray.ox, packet.ray.oy, packet.ray.oz}.set(i, o);
    Columns3{packet.ray.dx, packet.ray.dy, packet.ray.dz}.set(i, d);
    packet.ray.tmax[i] = kInfinity;
  }
  RenderCounters counters;
  scene->intersect(stream, Coherence::kCoherent, counters);
  scene->intersect(&packet, 1, Coherence::kIncoherent, counters);
  for (uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(stream[i].hit.shape, i);
    EXPECT_EQ(packet.shape[i], i);
  }
  EXPECT_EQ(packet.shape[6], kNoHit);
}

TEST_F(Instances, HaveTheMaterialsOfTheirGroup) {
  const auto scene =
      scene_from(group_of(shape("disk", "<bsdf type='diffuse' id='grey'/>") + shape("sphere", "")) +
                 instance("") + instance("<scale value='2'/>"));
  ASSERT_EQ(scene->shapes().size(), 4u);
  EXPECT_EQ(scene->shapes()[0]->bsdf_pointer(), scene->shapes()[2]->bsdf_pointer());
  EXPECT_EQ(scene->shapes()[0]->bsdf().id(), "grey");
  EXPECT_NE(scene->shapes()[0]->bsdf_pointer(), scene->shapes()[1]->bsdf_pointer());
}

/// Also under non-uniform scaling, and far from the origin.
TEST_F(Instances, AreNotMetByRaysThatLeaveThem) {
  const char* const maps[] = {
      kSimilar,
      kAffine,
      kMirrored,
      "<scale value='1e-4'/>",
      "<scale value='1e4'/>",
      "<scale x='20' y='1' z='.05'/>",
      "<scale x='3' y='1' z='2'/><rotate x='.36' y='.48' z='.8' angle='50'/>"
      "<translate x='1e5' y='-1e5' z='1e4'/>"};
  for (const char* type : {"sphere", "cube", "disk"}) {
    for (const char* operations : maps) {
      SCOPED_TRACE(std::string(type) + operations);
      const auto scene = scene_from(group_of(shape(type, "")) + instance(operations));
      const Vec3 centre = scene->bounds().centre();
      const Vec3 reach = 0.5f * scene->bounds().extent();
      Random random(3);
      std::vector<RayHit> leaving;
      for (int i = 0; i < 5000; ++i) {
        const Vec3 target = centre + reach * 0.7f * random.direction();
        const Vec3 o = centre + 3 * max_component(reach) * random.direction();
        const RayHit hit = trace(*scene, o, glm::normalize(target - o));
        if (!hit.hit.valid()) continue;
        const SurfaceInteraction si = scene->interaction(hit);
        const float side = glm::dot(si.n, o - si.p) > 0 ? 1.f : -1.f;
        const Vec3 d = grazing_direction(random, si.n * side, -3);
        leaving.push_back(ray_hit(si.ray_origin(d), d));
      }
      EXPECT_GT(leaving.size(), 500u);
      EXPECT_EQ(count_hits(*scene, leaving), 0);
    }
  }
}

TEST_F(Instances, HaveTheAreaOfTheMovedShapeAndAreSampledEvenly) {
  Random random(4);
  for (const char* type : {"obj", "cube", "disk"}) {
    SCOPED_TRACE(type);
    const auto plain = scene_from(shape(type, moved(kAffine)));
    const auto scene = scene_from(group_of(shape(type, "")) + instance(kAffine));
    const Shape& a = *plain->shapes()[0];
    const Shape& b = *scene->shapes()[0];
    EXPECT_NEAR(b.area(), a.area(), 1e-5f * a.area());
    // Compares the means of the position and of its squares: six tests at 5 standard deviations.
    glm::dvec3 mean_a(0), mean_b(0), squares(0), more_a(0), more_b(0), fourths(0);
    constexpr int kCount = 40000;
    for (int i = 0; i < kCount; ++i) {
      Vec2 u;
      u.x = random.unit(), u.y = random.unit();
      const glm::dvec3 p(a.sample_surface(u).p - Vec3(3, -2, .5f));
      const SurfaceInteraction si = b.sample_surface(u);
      const glm::dvec3 q(si.p - Vec3(3, -2, .5f));
      EXPECT_EQ(si.shape, &b);
      mean_a += p, mean_b += q, squares += p * p, more_a += p * p, more_b += q * q;
      fourths += p * p * p * p;
    }
    for (int k = 0; k < 3; ++k) {
      const double error = std::sqrt(2 * squares[k]);
      EXPECT_NEAR(mean_a[k], mean_b[k], 5 * error);
      EXPECT_NEAR(more_a[k], more_b[k], 5 * std::sqrt(2 * fourths[k]));
    }
  }
  // An oblate spheroid: 2 pi a² (1 + (1 - e²) / e artanh e), e² = 1 - c² / a².
  const auto scene =
      scene_from(group_of(shape("sphere", "")) + instance("<scale x='2' y='2' z='.7'/>"));
  const double e = std::sqrt(1 - .7 * .7 / 4);
  EXPECT_NEAR(scene->shapes()[0]->area(),
              8 * std::numbers::pi * (1 + (1 - e * e) / e * std::atanh(e)), 1e-2);
}

TEST_F(Instances, MergesAreTheirShapes) {
  const auto scene =
      scene_from(group_of("<shape type='merge'><shape type='disk'/><shape type='cube'/></shape>") +
                 "<shape type='merge'><shape type='sphere'/>"
                 "<shape type='cube'><emitter type='area'/></shape>" +
                 instance("<translate x='9'/>") + "</shape>");
  ASSERT_EQ(scene->shapes().size(), 4u);
  EXPECT_EQ(trace(*scene, {9, 0, 9}, {0, 0, -1}).hit.shape, 3u);
  EXPECT_TRUE(scene->shapes()[1]->emitter());
  EXPECT_EQ(scene->emitters().size(), 1u);
}

}  // namespace
}  // namespace kinome::test::instance_test
