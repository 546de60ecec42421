// Compares the light that surface points receive from light points: blocks with single points.

#include <gtest/gtest.h>

#include <cmath>

#include "clustered/points/light_pairs.h"
#include "clustered/points/lobe_samples.h"
#include "kinome/block_points.h"
#include "support/render.h"
#include "transport/camera/camera.h"

namespace kinome::test::lit_points_test {
namespace {

constexpr float kRounding = 8 * 0x1p-24f;

/// Two materials, one of which has a glossy lobe, below a light that the camera doesn't see.
constexpr const char* kTwoFloors = R"(
  <integrator type="direct"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0,-3,3" target="0,0,0" up="0,0,1"/></transform>
    <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="6"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
  </sensor>
  <shape type="rectangle">
    <transform name="to_world"><translate x="-1"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value=".8 .5 .2"/></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><translate x="1"/></transform>
    <bsdf type="roughplastic"><float name="alpha" value=".3"/></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><scale value=".2"/><translate z="1"/></transform>
    <bsdf type="conductor"/>
  </shape>)";

/// A block of camera rays and their hits.
class Seen {
 public:
  Seen()
      : scene(scene_from(kTwoFloors)),
        table(*scene),
        camera(table, *scene->sensors()[0], 48 * 4, false) {
    for (uint32_t y = 0; y < 6; ++y) {
      for (uint32_t k = 0; k < 8; ++k) x_.push_back(k), y_.push_back(y);
    }
    samples = {x_.data(), y_.data(), x_.size(), 0, 4, 3};
    camera.trace(samples, counters);
  }
  LitPoints points() const {
    return {samples, camera.surfaces(), camera.surfaces().points().ray, 9};
  }

  std::unique_ptr<Scene> scene;
  transport::SceneTable table;
  transport::Camera camera;
  PixelSamples samples{};
  RenderCounters counters;

 private:
  std::vector<uint32_t> x_, y_;
};

TEST(LobeSamples, MatchSinglePoints) {
  Seen seen;
  const LitPoints points = seen.points();
  ASSERT_GT(seen.camera.surfaces().scattering(), 64u);
  for (const uint32_t count : {1u, 15u, 16u, 17u, 33u, 3000u}) {
    const auto sampler = seen.scene->sensors()[0]->sampler().with_sample_count(count);
    LobeSamples lobes(*sampler);
    std::vector<size_t> waiting;
    size_t drawn = 0, found = 0;
    const auto check = [&] {
      lobes.draw();
      for (size_t number = 0; number < waiting.size(); ++number) {
        const size_t i = waiting[number];
        const SurfaceInteraction si = interaction_of(points.surfaces.points(), i);
        SampleKey key = transport::key_of(seen.samples, points.owner[i]);
        const uint32_t first = key.sample * sampler->sample_count();
        const LobeDirections directions = lobes.directions(number);
        size_t k = 0;
        for (uint32_t s = 0; s < sampler->sample_count(); ++s) {
          key.sample = first + s;
          const auto expected =
              si.shape->bsdf().sample(si, Lobe::kGlossy, sampler->value_1d(key, 11),
                                      sampler->value_2d(key, 9));
          if (!expected) continue;
          ASSERT_LT(k, directions.count);
          const Vec3 d(directions.x[k], directions.y[k], directions.z[k]);
          ASSERT_LE(glm::length(d - si.frame.to_world(expected->wo)), 1e-5f) << i << " " << s;
          ++k;
        }
        EXPECT_EQ(k, directions.count);
        found += k;
      }
      drawn += waiting.size();
      waiting.clear();
      lobes.clear();
    };
    size_t all = 0;
    points.for_each([&](size_t i, const Bsdf& bsdf) {
      ++all;
      if (!lobes.has_room()) check();
      EXPECT_EQ(lobes.add(points, i, bsdf), waiting.size());
      waiting.push_back(i);
    });
    check();
    EXPECT_EQ(drawn, all);
    EXPECT_GT(found, 0u);
  }
}

LightPoints some_lights(LightPoints::Kind kind) {
  LightPoints lights;
  lights.kind = kind;
  for (int i = 0; i < 400; ++i) {
    const float a = 0.1f * static_cast<float>(i), b = std::fmod(0.618f * static_cast<float>(i), 1.f);
    const Vec3 d = glm::normalize(Vec3(std::cos(a), std::sin(a), 2 * b - 0.3f));
    const bool is_local = kind == LightPoints::Kind::kLocal;
    lights.position.push_back(is_local ? 3.f * d : d);
    // Some normals point away from the origin. One light point is in the plane of the floor.
    if (is_local) lights.normal.push_back(i % 7 == 3 ? d : -d);
    if (is_local && i == 11) lights.position.back() = Vec3(5, 0, 0);
    lights.power.push_back(i % 5 == 4 ? Rgb(0.f) : Rgb(b, 1 - b, 0.5f));
    lights.extent.push_back(1);
  }
  return lights;
}

/// Returns the radiance that point si reflects of a light point which is chosen once.
Rgb reflected(const Seen& seen, const SurfaceInteraction& si, const LightPoints& lights, uint32_t i,
              float max_term) {
  Vec3 d = lights.position[i];
  float distance = kInfinity;
  Rgb light = lights.power[i];
  if (lights.kind == LightPoints::Kind::kLocal) {
    const Vec3 to = d - si.p;
    distance = glm::length(to);
    d = to / distance;
    if (!(std::abs(glm::dot(si.n, to)) > si.p_error)) return Rgb(0.f);
    const float cosine = std::max(0.f, -glm::dot(lights.normal[i], d));
    const float term = std::abs(glm::dot(si.frame.n, d)) * cosine / sqr(distance);
    light *= cosine / sqr(distance) * (max_term > 0 && term > max_term ? max_term / term : 1);
  }
  const BsdfValue value =
      si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy, si.frame.to_local(d));
  Ray ray = si.shadow_ray(d, distance);
  RenderCounters counters;
  seen.scene->occluded({&ray, 1}, Coherence::kIncoherent, counters);
  return ray.is_occluded() ? Rgb(0.f) : value.f * light;
}

TEST(LightPairs, MatchSinglePoints) {
  const Seen seen;
  const LitPoints points = seen.points();
  for (const auto kind : {LightPoints::Kind::kDistant, LightPoints::Kind::kLocal}) {
    const LightPoints lights = some_lights(kind);
    for (const float max_term : {0.f, 0.05f}) {
      for (const size_t count : {0u, 1u, 15u, 16u, 17u, 400u}) {
        PointSelection chosen;
        for (size_t k = 0; k < count; ++k) {
          chosen.points.push_back(static_cast<uint32_t>((7 * k + count) % lights.size()));
          chosen.weights.push_back(1 + 0.25f * static_cast<float>(k % 3));
        }
        transport::Arena arena(seen.samples.count());
        const Columns3 radiance = arena.three();
        LightPairs pairs(*seen.scene, max_term);
        RenderCounters counters;
        points.for_each([&](size_t i, const Bsdf& bsdf) {
          pairs.add(points.surfaces.points(), i, bsdf, points.owner[i], Rgb(2, 1, 0.5f), lights,
                    chosen, radiance, counters);
        });
        pairs.finish(radiance, counters);
        size_t all = 0;
        points.for_each([&](size_t i, const Bsdf&) {
          const SurfaceInteraction si = interaction_of(points.surfaces.points(), i);
          Rgb sum(0.f);
          for (size_t k = 0; k < count; ++k) {
            sum += reflected(seen, si, lights, chosen.points[k], max_term) * chosen.weights[k];
          }
          sum *= Rgb(2, 1, 0.5f);
          const Rgb got = radiance.at(points.owner[i]);
          for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(got[c], sum[c], 20 * kRounding * (1 + sum[c])) << i << " of " << count;
          }
          all += count;
        });
        EXPECT_EQ(counters[RayKind::kShadow] + counters.skipped_shadow_rays, all);
      }
    }
  }
}

}  // namespace
}  // namespace kinome::test::lit_points_test
