// Tests that the light points that each pass draws have finite values.
#include <gtest/gtest.h>

#include <cmath>

#include "clustered/product/lights/light_point_draw.h"
#include "support/render.h"

namespace kinome::test::light_points_test {
namespace {

/// In a spot whose angle is near the precision of floats, many sampled rays leave beyond its rim,
/// where their density is 0. Light of such points is left to eye rays alone. The points' eye_ratio
/// must be finite, so that its product with a density of 0 isn't NaN.
TEST(LightPoints, OfANarrowSpotHaveFiniteRatios) {
  size_t eye_rays = 0;
  for (const char* const angle : {"20", ".2", ".02", ".005"}) {
    const auto scene = scene_from(std::string(R"(<scene version="3.0.0"><emitter type="spot">
        <float name="cutoff_angle" value=")") +
                                  angle + R"("/><float name="beam_width" value=")" + angle + R"("/>
        <transform name="to_world"><lookat origin="1,2,3" target="0,0,.1" up="0,1,0"/></transform>
        </emitter><shape type="rectangle"><transform name="to_world"><scale value="9"/></transform></shape></scene>)");
    size_t count = 0;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      RenderContext context({.threads = 1, .seed = seed});
      const LocalLight light(*scene, {.length = {3, 5}}, {}, seed, context);
      for (const LightPoint& p : light.draw(seed, context).points) {
        ++count;
        EXPECT_TRUE(std::isfinite(p.eye_ratio) && std::isfinite(p.eye_ratio * 0.f)) << angle;
        EXPECT_GE(p.eye_ratio, 0) << angle;
        eye_rays += p.eye_ratio > 1e20f;
      }
    }
    EXPECT_GT(count, 1000) << angle;
  }
  EXPECT_GT(eye_rays, 0) << "no ray left beyond the rim, so that nothing was tested";
}

/// A spot that lights nothing but the sky: no draw finds light after a bounce. Such light is
/// unknown, not absent, and is left to paths from the eye.
TEST(LightPoints, LeaveUnknownLightToPaths) {
  const auto scene = scene_from(R"(<scene version="3.0.0"><emitter type="spot">
      <transform name="to_world"><lookat origin="0,0,1" target="0,0,2" up="0,1,0"/></transform>
      </emitter><shape type="rectangle"/></scene>)");
  RenderContext context({.threads = 1, .seed = 1});
  const LocalLight light(*scene, {.length = {6, 5}}, {}, 1, context);
  ASSERT_TRUE(light.has_bounce());
  RayHit hit{};
  hit.ray.o = Vec3(0, 0, .5f);
  hit.ray.d = Vec3(0, 0, -1);
  RenderCounters counters;
  scene->intersect({&hit, 1}, Coherence::kIncoherent, counters);
  ASSERT_TRUE(hit.hit.valid());
  const SurfaceInteraction si = scene->interaction(hit);
  EXPECT_GT(light.deep_place(si, .5f).eye_ratio, 1e9f);
  EXPECT_GT(light.third_place(si).eye_ratio, 1e9f);
}

/// The choice between eye rays and light points for a lobe must not depend on the directions of
/// view and light. Both ends of a path must make the same choice.
TEST(LightPoints, LobeWidthDependsOnlyOnTheSide) {
  const std::pair<const char*, LobeWidth> kBsdfs[] = {
      {R"(<bsdf type="diffuse"/>)", LobeWidth::kWide},
      {R"(<bsdf type="conductor"/>)", LobeWidth::kWide},
      {R"(<bsdf type="roughconductor"><float name="alpha" value=".3"/></bsdf>)", LobeWidth::kWide},
      {R"(<bsdf type="roughconductor"><float name="alpha" value=".25"/></bsdf>)",
       LobeWidth::kNarrow},
      {R"(<bsdf type="roughconductor"><float name="alpha" value=".014"/></bsdf>)",
       LobeWidth::kNarrow},
      {R"(<bsdf type="roughconductor"><float name="alpha" value=".012"/></bsdf>)",
       LobeWidth::kMirroring},
      {R"(<bsdf type="roughconductor"><float name="alpha" value="0"/></bsdf>)",
       LobeWidth::kMirroring},
      {R"(<bsdf type="phong"><float name="exponent" value="3"/></bsdf>)", LobeWidth::kWide},
      {R"(<bsdf type="phong"><float name="exponent" value="100"/></bsdf>)", LobeWidth::kNarrow},
      {R"(<bsdf type="phong"><float name="exponent" value="100000"/></bsdf>)",
       LobeWidth::kMirroring},
      {R"(<bsdf type="twosided"><bsdf type="roughplastic"><float name="alpha" value=".03"/></bsdf>
          <bsdf type="roughplastic"><float name="alpha" value=".3"/></bsdf></bsdf>)",
       LobeWidth::kNarrow},
  };
  for (const auto& [bsdf, width] : kBsdfs) {
    const auto scene =
        scene_from(std::string(R"(<scene version="3.0.0"><shape type="rectangle">)") + bsdf +
                   "</shape></scene>");
    SurfaceInteraction si = scene->shapes()[0]->sample_surface(Vec2(0.3f, 0.6f));
    for (const float z : {1.f, 0.5f, 1e-3f}) {
      si.wi = Vec3(std::sqrt(1 - z * z), 0, z);
      EXPECT_EQ(lobe_width(si), width) << bsdf << " at a cosine of " << z;
    }
    if (std::string(bsdf).find("twosided") != std::string::npos) {
      si.wi = Vec3(0, 0, -1);
      EXPECT_EQ(lobe_width(si), LobeWidth::kWide) << "other side";
    }
  }
}

/// A share of the points of a pass has the same share of the power; callers divide by it.
TEST(LightPoints, PowerIsProportionalToTheShareOfPoints) {
  const auto scene = scene_from(R"(<scene version="3.0.0">
      <shape type="sphere"><point name="center" x="0" y="0" z="1"/><float name="radius" value=".2"/>
        <emitter type="area"/></shape>
      <emitter type="point"><point name="position" x="1" y="0" z="1"/></emitter>
      <shape type="rectangle"><transform name="to_world"><scale value="4"/></transform></shape>
      <shape type="cube"><transform name="to_world"><scale value="5"/></transform></shape></scene>)");
  constexpr float kShare = 0.25f;
  constexpr int kRounds = 16;
  double power[2] = {0, 0};
  size_t count[2] = {0, 0};
  for (uint64_t seed = 1; seed <= kRounds; ++seed) {
    RenderContext context({.threads = 2, .seed = seed});
    const LocalLight light(*scene, {.length = {5, 5}}, {}, 1, context);
    for (int i = 0; i < 2; ++i) {
      const LocalPoints points = light.draw(seed, context, i == 0 ? 1.f : kShare);
      EXPECT_EQ(points.share, i == 0 ? 1.f : kShare);
      EXPECT_EQ(points.first.back(), points.points.size());
      EXPECT_EQ(points.rows.size(), points.points.size());
      count[i] += points.points.size();
      for (const LightPoint& p : points.points) {
        power[i] += static_cast<double>(p.power.x + p.power.y + p.power.z);
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(count[1]) / static_cast<double>(count[0]), kShare, 0.01 * kShare);
  EXPECT_NEAR(power[1] / power[0], kShare, 0.02 * kShare);
}

/// Points of a cell are adjacent, in the order of the cells.
TEST(LightPoints, AreSortedByCell) {
  const auto scene = scene_from(R"(<scene version="3.0.0"><emitter type="constant"/>
      <shape type="rectangle"/><shape type="sphere"><float name="radius" value=".5"/></shape>
      </scene>)");
  RenderContext context({.threads = 2});
  const LocalLight light(*scene, {.length = {5, 5}}, {}, 1, context);
  const LocalPoints points = light.draw(1, context);
  ASSERT_EQ(points.first.size(), light.size() + 1);
  for (uint32_t c = 0; c < light.size(); ++c) {
    for (uint32_t i = points.first[c]; i < points.first[c + 1]; ++i) {
      ASSERT_EQ(points.points[i].cell, c);
    }
  }
}

}  // namespace
}  // namespace kinome::test::light_points_test
