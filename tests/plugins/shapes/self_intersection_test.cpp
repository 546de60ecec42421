#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <sstream>

#include "kinome/emitter.h"
#include "support/shape_helpers.h"

/// Rays that leave a convex surface must not hit it again, for any size and position. No ray may
/// pass through a closed mesh.
namespace kinome::test::self_intersection_test {
namespace {

/// Returns a subdivided icosahedron of radius 1 whose faces point outward.
std::string icosphere_obj(int subdivisions) {
  const float g = (1 + std::sqrt(5.f)) / 2;
  std::vector<Vec3> points = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                              {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                              {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<size_t, 3>> faces = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<size_t, size_t>, size_t> middles;
    const auto middle = [&](size_t a, size_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), points.size());
      if (is_new) points.push_back(0.5f * (glm::normalize(points[a]) + glm::normalize(points[b])));
      return found->second;
    };
    std::vector<std::array<size_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const size_t ab = middle(a, b);
      const size_t bc = middle(b, c);
      const size_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    faces = finer;
  }
  std::ostringstream out;
  out.precision(9);
  for (const Vec3& p : points) {
    const Vec3 q = glm::normalize(p);
    out << "v " << q.x << ' ' << q.y << ' ' << q.z << '\n';
  }
  for (const auto& [a, b, c] : faces) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  return out.str();
}

struct Placement {
  float scale;
  Vec3 offset;
};

std::string place(const Placement& placement) {
  std::ostringstream out;
  out << "<transform name='to_world'><rotate x='.3' y='.5' z='.81' angle='50'/><scale value='"
      << placement.scale << "'/><translate x='" << placement.offset.x << "' y='"
      << placement.offset.y << "' z='" << placement.offset.z << "'/></transform>";
  return out.str();
}

/// Traces rays to random points. From each, traces rays away from the surface on the same side,
/// most of them at grazing angles. Returns the number of these rays and of their hits. Checks that
/// the offset stays small.
struct Count {
  int rays = 0;
  int hits = 0;
};
Count leaving_rays(const Scene& scene, const Placement& placement, int points, bool outside_only) {
  Random random(11);
  Count count;
  RenderCounters counters;
  std::vector<RayHit> batch;
  for (int i = 0; i < points; ++i) {
    const Vec3 o = placement.offset + placement.scale * 4.f * random.direction();
    const Vec3 target = placement.offset + placement.scale * random.unit() * random.direction();
    const RayHit hit = trace(scene, o, glm::normalize(target - o));
    if (!hit.hit.valid()) continue;
    const SurfaceInteraction si = scene.interaction(hit);
    const float magnitude = max_component(glm::abs(placement.offset)) + 2 * placement.scale;
    // For small objects far away, the limit is a few times the rounding of positions.
    EXPECT_LT(si.p_error, 0x1p-24f * (26.1f * magnitude + 112 * placement.scale));
    EXPECT_GT(si.p_error, 0);
    const float side = glm::dot(si.n, o - si.p) > 0 ? 1.f : -1.f;
    if (outside_only && side < 0) continue;
    for (int k = 0; k < 4; ++k) {
      const Vec3 d = grazing_direction(random, si.n * side, -5);
      // Rounding may have turned a direction with cosine 1e-5 into the surface.
      if (glm::dot(glm::dvec3(d), glm::dvec3(si.n * side)) <= 1e-6) continue;
      batch.push_back(ray_hit(si.ray_origin(d), d));
    }
  }
  std::vector<Ray> shadow;
  for (const RayHit& ray : batch) shadow.push_back(ray.ray);
  scene.occluded(shadow, Coherence::kIncoherent, counters);
  scene.intersect(batch, Coherence::kIncoherent, counters);
  for (size_t i = 0; i < batch.size(); ++i) {
    ++count.rays;
    count.hits += batch[i].hit.valid() || shadow[i].is_occluded();
  }
  return count;
}

class SelfIntersection : public testing::TestWithParam<std::string> {
 protected:
  void check(const std::string& attributes, const std::string& type, bool outside_only) {
    const std::vector<Placement> placements = {
        {1e-6f, Vec3(0.f)},      {1.f, Vec3(0.f)},
        {1e6f, Vec3(0.f)},       {1.f, Vec3(1e5f, -1e5f, 1e5f)},
        {1.f, Vec3(1e5f, 0, 0)}, {1e-3f, Vec3(1, 2, 3)}};
    for (const Placement& placement : placements) {
      const auto scene =
          scene_from("<shape type='" + type + "'>" + attributes + place(placement) + "</shape>");
      const Count count = leaving_rays(*scene, placement, 20000, outside_only);
      EXPECT_GT(count.rays, 20000);
      EXPECT_EQ(count.hits, 0) << "scale " << placement.scale << ", offset " << placement.offset.x;
    }
  }
};

TEST_P(SelfIntersection, NoneOnAConvexShape) {
  // Rays inside a cylinder hit its opposite side.
  check("", GetParam(), GetParam() == "cylinder");
}
INSTANTIATE_TEST_SUITE_P(All, SelfIntersection,
                         testing::Values("sphere", "disk", "rectangle", "cube", "cylinder"),
                         [](const auto& test) { return test.param; });

TEST_F(SelfIntersection, NoneOnALargeSphereSeenFromNearby) {
  // A ground of radius 1e6 touches the origin: p is small there, but the shape is not.
  const auto scene = scene_from(
      "<shape type='sphere'><point name='center' x='0' y='0' z='-1000000'/>"
      "<float name='radius' value='1000000'/></shape>");
  Random random(12);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 o(random.between(-2, 2), random.between(-2, 2), 1);
    const RayHit hit = trace(*scene, o, {0, 0, -1});
    ASSERT_TRUE(hit.hit.valid());
    const SurfaceInteraction si = scene->interaction(hit);
    ASSERT_LT(si.p_error, 1e-5f);
    const Vec3 d = glm::normalize(Vec3(random.between(-1, 1), random.between(-1, 1), 0.001f));
    ASSERT_FALSE(trace(*scene, si.ray_origin(d), d).hit.valid());
  }
}

/// Returns the fraction of an emitter's light that the emitter itself occludes. The receiver is a
/// wall that sees it at grazing angles.
double occluded_share(const std::string& lamp, const Placement& placement) {
  const std::string to_world = place(placement);
  const std::string name = "<transform name='to_world'>";
  const std::string wall = name + "<scale value='.8'/><rotate y='1' angle='-90'/>" +
                           "<translate x='1.1' z='.9'/>" + to_world.substr(name.size());
  const auto scene =
      scene_from("<shape type='" + lamp + "'>" + to_world +
                 "<emitter type='area'/></shape><shape type='rectangle'>" + wall + "</shape>");
  const Emitter& emitter = *scene->emitters().at(0);
  Random random(15);
  RenderCounters counters;
  double all = 0, occluded = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 o = placement.offset + placement.scale * 8.f * random.direction();
    const Vec3 target =
        placement.offset + placement.scale * 2.f * random.unit() * random.direction();
    const RayHit hit = trace(*scene, o, glm::normalize(target - o));
    if (!hit.hit.valid() || hit.hit.shape != 1) continue;
    const SurfaceInteraction si = scene->interaction(hit);
    Vec2 u;
    u.x = random.unit();
    u.y = random.unit();
    const auto light = emitter.sample_direct(si.p, u);
    if (!light || !(light->pdf > 0)) continue;
    const double light_of_sample =
        double{light->radiance.x} * std::abs(glm::dot(si.n, light->d)) / light->pdf;
    std::array<Ray, 1> shadow = {si.shadow_ray(light->d, light->distance)};
    scene->occluded(shadow, Coherence::kIncoherent, counters);
    all += light_of_sample;
    if (shadow[0].is_occluded()) occluded += light_of_sample;
  }
  EXPECT_GT(all, 0);
  return occluded / all;
}

TEST(SelfIntersectionOfLamps, NoneWhereTheirLightComesFrom) {
  const std::vector<Placement> placements = {{1e-6f, Vec3(0.f)},
                                             {1.f, Vec3(0.f)},
                                             {1e6f, Vec3(0.f)},
                                             {1.f, Vec3(-358, 875, 5327)},
                                             {1.f, Vec3(1e4f, -1e4f, 1e4f)}};
  for (const std::string lamp : {"rectangle", "disk"}) {
    for (const Placement& placement : placements) {
      EXPECT_LT(occluded_share(lamp, placement), 0.01)
          << lamp << " of " << placement.scale << " at " << placement.offset.z;
    }
  }
}

TEST(SelfIntersectionOfMeshes, NoneOnAnIcosphere) {
  // Vertices at 1e5 are rounded to a grid that is coarse for the fine mesh. That case uses an
  // icosahedron of size 100, whose faces meet at 42 degrees and stay convex.
  const TemporaryFolder folder;
  const std::string fine = folder.write("fine.obj", icosphere_obj(4));
  const std::string coarse = folder.write("coarse.obj", icosphere_obj(0));
  struct Case {
    std::string file;
    Placement placement;
  };
  const std::vector<Case> cases = {{fine, {1.f, Vec3(0.f)}},
                                   {fine, {1e-6f, Vec3(0.f)}},
                                   {fine, {1e6f, Vec3(0.f)}},
                                   {coarse, {100.f, Vec3(1e5f, -1e5f, 1e5f)}}};
  for (const Case& c : cases) {
    const auto scene = scene_from("<shape type='obj'><string name='filename' value='" + c.file +
                                  "'/>" + place(c.placement) + "</shape>");
    const Count count = leaving_rays(*scene, c.placement, 20000, false);
    EXPECT_GT(count.rays, 20000);
    EXPECT_EQ(count.hits, 0) << c.file << " at scale " << c.placement.scale;
  }
}

TEST(SelfIntersectionOfMeshes, AThinGapStaysOpen) {
  // A gap of 3e-5 between two unit squares is more than twice the offset, so that rays in it find
  // light.
  const auto scene = scene_from(
      "<shape type='rectangle'/><shape type='rectangle'><transform name='to_world'>"
      "<translate z='3e-5'/></transform></shape>");
  Random random(13);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 o(random.between(-0.9f, 0.9f), random.between(-0.9f, 0.9f), -1);
    const RayHit hit = trace(*scene, o, {0, 0, 1});
    ASSERT_EQ(hit.hit.shape, 0u);
    const Vec3 d(0, 0.1f, 1);
    const RayHit next = trace(*scene, scene->interaction(hit).ray_origin(d), d);
    ASSERT_TRUE(next.hit.valid());
    ASSERT_EQ(next.hit.shape, 1u);
  }
}

/// Counts rays that miss, in nearest-hit queries of both modes and in occlusion queries.
size_t count_leaks(const Scene& scene, std::vector<RayHit> rays) {
  RenderCounters counters;
  std::vector<Ray> shadow;
  for (const RayHit& ray : rays) shadow.push_back(ray.ray);
  std::vector<RayHit> coherent = rays;
  scene.intersect(rays, Coherence::kIncoherent, counters);
  scene.intersect(coherent, Coherence::kCoherent, counters);
  scene.occluded(shadow, Coherence::kIncoherent, counters);
  size_t leaks = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    leaks += !rays[i].hit.valid() || !coherent[i].hit.valid() || !shadow[i].is_occluded();
  }
  return leaks;
}

class Watertight : public testing::Test {
 protected:
  /// Returns a sphere of triangles; `parameter` is added to the scene.
  std::unique_ptr<Scene> sphere(const std::string& parameter = "") const {
    return scene_from(parameter + "<shape type='obj'><string name='filename' value='" + file_ +
                      "'/></shape>");
  }

 private:
  TemporaryFolder folder_;
  std::string file_ = folder_.write("sphere.obj", icosphere_obj(4));
};

TEST_F(Watertight, RaysLeakAtEdgesOnlyOnRequest) {
  const auto leaks = [&](const std::string& value) {
    const auto scene =
        sphere("<boolean name='embree_use_robust_intersections' value='" + value + "'/>");
    const TriangleMesh& mesh = *scene->shapes()[0]->mesh();
    Random random(15);
    std::vector<RayHit> rays;
    for (const glm::uvec3& t : mesh.triangles) {
      const Vec3 a = mesh.positions[t[0]];
      const Vec3 o = 0.9f * random.unit() * random.direction();
      rays.push_back(ray_hit(o, a + random.unit() * (mesh.positions[t[1]] - a) - o));
    }
    return count_leaks(*scene, rays);
  };
  EXPECT_EQ(leaks("true"), 0u);
  EXPECT_GT(leaks("false"), 0u);
}

TEST_F(Watertight, RaysFromInsideAClosedMeshAllHitIt) {
  const auto scene = sphere();
  const TriangleMesh& mesh = *scene->shapes()[0]->mesh();
  Random random(14);
  const Vec3 inside(0.01f, -0.02f, 0.03f);
  const auto aim = [&](std::vector<RayHit>& rays, const Vec3& target) {
    rays.push_back(ray_hit(inside, target - inside));
    const Vec3 o = 0.9f * random.unit() * random.direction();
    rays.push_back(ray_hit(o, target - o));
  };
  std::vector<RayHit> anywhere;
  std::vector<RayHit> at_edges;
  std::vector<RayHit> at_vertices;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = mesh.positions[t[i]];
      const Vec3 b = mesh.positions[t[(i + 1) % 3]];
      aim(at_vertices, a);
      for (int k = 0; k < 4; ++k) {
        aim(at_edges, a + random.between(0.02f, 0.98f) * (b - a));
        anywhere.push_back(ray_hit(0.9f * random.unit() * random.direction(), random.direction()));
      }
    }
  }
  EXPECT_EQ(count_leaks(*scene, anywhere), 0u) << "of " << anywhere.size();
  EXPECT_EQ(count_leaks(*scene, at_edges), 0u) << "of " << at_edges.size();
  // Embree's robust test is consistent for both triangles of an edge, but not for all edges at a
  // vertex. It lost 0.3 % of the rays that were aimed exactly at a vertex, which no renderer
  // samples.
  EXPECT_LT(count_leaks(*scene, at_vertices), at_vertices.size() / 100);
}

}  // namespace
}  // namespace kinome::test::self_intersection_test
