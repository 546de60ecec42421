// Tests each kind of strata alone, with wrong visibilities. Control terms plus shadow rays must
// equal the light that the points reflect. Nothing occludes the light.
#include <gtest/gtest.h>

#include "clustered/product/strata/diffuse_strata.h"
#include "clustered/product/paths/eye_rays.h"
#include "clustered/product/paths/mirrored_direction.h"
#include "clustered/product/strata/glossy_strata.h"
#include "clustered/product/strata/local_strata.h"
#include "stage_tile.h"

namespace kinome::test::strata_stages_test {
namespace {

constexpr float kCandidates = 192;

TEST(DiffuseStrata, AddUpToTheReflectedSky) {
  for (const std::string& material :
       {kGrey, std::string(R"(<bsdf type="plastic"/>)"), asked_xml(kGrey)}) {
    SCOPED_TRACE(material);
    StageTile tile(floor_xml(material) + sky_xml());
    tile.guess_visibility();
    const GroupView group = tile.view(0);
    std::unique_ptr<CellLight> light;
    std::unique_ptr<DiffuseStrata> stage;
    MeanRgb with_horizon, without;
    const MeanRgb mean = estimate(
        tile,
        [&](uint64_t seed, Strata& strata) {
          light = std::make_unique<CellLight>(tile.light(seed));
          stage = std::make_unique<DiffuseStrata>(*light);
          light->horizon_terms = seed % 2 == 0;
          stage->begin_tile(tile.patches().size(), seed);
          stage->begin_unit();
          EXPECT_TRUE(stage->applies(group));
          const Rgb control = stage->add(group, strata);
          (light->horizon_terms ? with_horizon : without).add(control);
          return control;
        },
        [&](uint64_t seed, const SegmentHits& hits, const Answers& answers, ShadowRays& rays) {
          stage->shoot(group, hits, random_bits(seed, 78), answers, rays);
        });
    mean.expect(tile.reflected_sky(group, Lobe::kDiffuse), "diffuse");
    EXPECT_GT(mean_of(with_horizon.mean()), 1.01f * mean_of(without.mean()));
  }
}

/// Cells that are known to be visible need no rays. Cells at the horizon are estimated from some of
/// their points; all others are exact.
TEST(DiffuseStrata, FindVisibleLightWithoutRays) {
  StageTile tile(floor_xml(kGrey) + sky_xml());
  const GroupView group = tile.view(0);
  for (float& v : tile.visibility()[group.group.patch].v) v = 1;
  const Rgb all = tile.reflected_sky(group, Lobe::kDiffuse);
  const auto control_of = [&](const CellLight& light, uint64_t seed, Strata& strata) {
    DiffuseStrata stage(light);
    stage.begin_tile(tile.patches().size(), seed);
    stage.begin_unit();
    return stage.add(group, strata);
  };
  MeanRgb mean;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Strata strata;
    mean.add(control_of(tile.light(seed), seed, strata));
  }
  mean.expect(all, "with cells at the horizon");
  CellLight light = tile.light(1);
  light.horizon_terms = false;
  Strata strata;
  const Rgb control = control_of(light, 0, strata);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(control[k], 0.99f * all[k]);
    EXPECT_GT(control[k], 0.8f * all[k]);
  }
  DiffuseStrata stage(light);
  // The plan has the same values for one point that reflects as much as the group.
  const DiffuseStrata::PatchPlan plan =
      stage.plan(group.patch, tile.visibility()[group.group.patch]);
  for (int k = 0; k < 3; ++k) {
    double reflected = 0;
    for (int axis = 0; axis < 3; ++axis) {
      reflected += double{plan.control[3 * k + axis]} * group.group.albedo_normal[k][axis];
    }
    EXPECT_NEAR(reflected * kInvPi, control[k], 0.01 * control[k]);
  }
  EXPECT_NEAR(plan.uncertainty * static_cast<float>(group.group.count), strata.total(),
              0.02 * strata.total());
}

TEST(GlossyStrata, AddUpToTheReflectedSky) {
  for (const std::string& material :
       {rough_xml("roughconductor", 0.25), rough_xml("roughplastic", 0.3),
        asked_xml(rough_xml("roughconductor", 0.3))}) {
    SCOPED_TRACE(material);
    StageTile tile(floor_xml(material) + sky_xml());
    tile.guess_visibility();
    const GroupView group = tile.view(0);
    std::unique_ptr<CellLight> light;
    std::unique_ptr<GlossyStrata> stage;
    const MeanRgb mean = estimate(
        tile,
        [&](uint64_t seed, Strata& strata) {
          light = std::make_unique<CellLight>(tile.light(seed));
          stage = std::make_unique<GlossyStrata>(*light);
          EXPECT_TRUE(stage->applies(group));
          return stage->add(group, GlossyStrata::counts(group.patch, kCandidates),
                            hash_words(seed, 79), strata);
        },
        [&](uint64_t, const SegmentHits& hits, const Answers& answers, ShadowRays& rays) {
          stage->shoot(group, hits, answers, rays);
        });
    mean.expect(tile.reflected_sky(group, Lobe::kGlossy), "glossy");
  }
}

TEST(GlossyStrata, DrawAboutAsManyAsAreWanted) {
  Patch patch;
  for (const float share : {0.05f, 0.5f, 0.95f}) {
    patch.cell_share = share;
    for (const float wanted : {100.f, 500.f, 1000.f}) {
      const GlossyStrata::Counts counts = GlossyStrata::counts(patch, wanted);
      EXPECT_NEAR(static_cast<float>(counts.from_cells), share * wanted, 1);
      // The number is a power of two within a factor of sqrt(2), except for the minimum.
      const auto from_lobe = static_cast<float>(1u << counts.lobe_log2);
      EXPECT_LE(from_lobe, std::max(16.f, 1.4143f * (1 - share) * wanted));
      EXPECT_GE(from_lobe, 0.7071f * (1 - share) * wanted);
    }
  }
}

TEST(GlossyStrata, ReportTheMeanAndItsShareToThePlan) {
  StageTile tile(floor_xml(rough_xml("roughconductor", 0.25)) + sky_xml());
  const GroupView group = tile.view(0);
  const double count = group.group.count;
  MeanRgb unshadowed;
  for (uint64_t seed = 0; seed < kDraws; ++seed) {
    const CellLight light = tile.light(seed);
    GlossyStrata stage(light);
    Strata strata;
    stage.add(group, GlossyStrata::pilot_counts(group.patch), seed, strata);
    std::vector<PointPlan> points(tile.primaries().size());
    Patch patch = group.patch;
    patch.glossy = 0;
    stage.plan(group, patch, points);
    const PointPlan& point = points[group.primary(0)];
    EXPECT_GT(point.glossy_variance, 0);
    EXPECT_GT(patch.cell_share, 0);
    EXPECT_LT(patch.cell_share, 1);
    EXPECT_NEAR(patch.glossy * static_cast<float>(patch.count), point.glossy * count,
                1e-4 * patch.glossy * static_cast<float>(patch.count));
    unshadowed.add(Rgb(point.glossy * static_cast<float>(count)));
  }
  unshadowed.expect(Rgb(mean_of(tile.reflected_sky(group, Lobe::kGlossy))), "mean");
}

/// A bright square above, and a lamp.
const std::string kLamps = R"(
    <shape type="rectangle"><transform name="to_world"><scale value=".6"/>
      <rotate x="1" angle="90"/><translate x=".5" y="1"/></transform>
      <emitter type="area"><rgb name="radiance" value="3 2 1"/></emitter></shape>
    <emitter type="point"><point name="position" x="-1" y="1.5" z=".5"/>
      <rgb name="intensity" value="1 2 3"/></emitter>)";

/// Estimates the light of all emitters that the group reflects, with many samples of each.
MeanRgb reflected_lamps(const StageTile& tile, const GroupView& group, Lobe lobes) {
  MeanRgb mean;
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    Rgb sum(0.f);
    for (uint32_t k = 0; k < group.group.count; ++k) {
      const SurfaceInteraction& si = group.interaction(k);
      for (const auto& emitter : tile.scene().emitters()) {
        const auto light = emitter->sample_direct(si.p, {random.unit(), random.unit()});
        if (!light || !(light->pdf > 0)) continue;
        const BsdfValue value = si.shape->bsdf().eval_pdf(si, lobes, si.frame.to_local(light->d));
        sum += value.f * light->radiance / light->pdf;
      }
    }
    mean.add(sum);
  }
  return mean;
}

/// Light points and eye rays both find the square; their weights sum to one.
TEST(LocalStrata, AndEyeRaysShareTheLight) {
  for (const std::string& material :
       {kGrey, rough_xml("roughconductor", 0.3), rough_xml("roughplastic", 0.3),
        asked_xml(rough_xml("roughplastic", 0.3))}) {
    SCOPED_TRACE(material);
    StageTile tile(floor_xml(material) + kLamps);
    tile.guess_visibility();
    const GroupView group = tile.view(0);
    constexpr float kEyeRays = 0.5f;
    std::unique_ptr<CellLight> light;
    LocalChoice choice;
    std::unique_ptr<LocalStrata> stage;
    MeanRgb mean;
    StageTimes times;
    ShadowRays rays(times);
    rays.begin(tile.scene(), tile.counters());
    RayComb comb;
    EXPECT_TRUE(LocalStrata::applies(group));
    for (uint64_t seed = 0; seed < 4 * kDraws; ++seed) {
      light = std::make_unique<CellLight>(tile.light(seed));
      choice.choose(*light->local, light->local_points, tile.patches(), tile.visibility(),
                    light->first_local(), tile.primaries().size(), hash_words(seed, 80));
      stage = std::make_unique<LocalStrata>(*light, choice);
      Strata strata;
      const LocalStrata::Numbers numbers{random_bits(seed, 81), hash_words(seed, 82)};
      Rgb sum = stage->add(group, kEyeRays, numbers, strata);
      comb.walk(strata, kRays, random_float(seed, 77), [&](const SegmentHits& hits) {
        stage->shoot(group, hits, Answers{{&sum}}, rays);
      });
      EyeRays eye_rays(*light);
      eye_rays.begin_tile(tile.scene(), choice, hash_words(seed, 84), tile.counters());
      EXPECT_TRUE(eye_rays.applies(group));
      eye_rays.send(group, kEyeRays, hash_words(seed, 83), {&sum});
      EXPECT_FALSE(eye_rays.empty());
      eye_rays.trace(rays);
      EXPECT_TRUE(eye_rays.empty());
      rays.trace();
      mean.add(sum);
    }
    mean.expect(reflected_lamps(tile, group, Lobe::kDiffuse | Lobe::kGlossy), "local");
  }
}

/// The local strata of a tile's first group, and their plan.
struct PlannedLocal {
  GroupView group;
  CellLight light;
  LocalChoice choice;
  LocalStrata stage{light, choice};
  Strata strata;
  std::vector<PointPlan> points;
  std::vector<float> lit;  ///< visible light of each point's lamps
  Patch patch;

  explicit PlannedLocal(StageTile& tile)
      : group(tile.view(0)),
        light(tile.light(3)),
        points(tile.primaries().size()),
        lit(points.size()),
        patch(group.patch) {
    choice.choose(*light.local, light.local_points, tile.patches(), tile.visibility(),
                  light.first_local(), points.size(), 1);
    stage.add(group, 1, {1, 2}, strata);
    for (size_t i = 0; i < points.size(); ++i) points[i].lit = &lit[i];
    patch.eye_rays = patch.glossy = 0;
    stage.plan(group, patch, points);
  }
};

TEST(LocalStrata, ReportLampsAndOtherLightToThePlan) {
  StageTile tile(floor_xml(kGrey) + kLamps);
  PlannedLocal planned(tile);
  const GroupView& group = planned.group;
  std::vector<PointPlan>& points = planned.points;
  const Patch& patch = planned.patch;
  EXPECT_GE(patch.eye_rays, 0);
  EXPECT_LE(patch.eye_rays, 1);
  EXPECT_GT(patch.glossy, 0);
  std::vector<float> of_lamp;
  for (uint32_t k = 0; k < group.group.count; ++k) {
    // The lamps' unoccluded light is exact.
    const PointPlan& point = points[group.primary(k)];
    const SurfaceInteraction& si = group.interaction(k);
    const Vec3 to = Vec3(-1, 1.5f, 0.5f) - si.p;
    const float cosine = glm::dot(glm::normalize(to), si.n);
    const float expected = kInvPi * cosine / glm::dot(to, to) * (.6f + 2 * .5f + 3 * .4f) / 3;
    EXPECT_NEAR(point.lamps, expected, 1e-4f * expected);
    EXPECT_GT(point.glossy, 0);
    of_lamp.push_back(point.lamps);
  }
  // After a ray has been traced to the lamp, its planned light is 0, and the result is in `lit`.
  StageTimes times;
  ShadowRays rays(times);
  rays.begin(tile.scene(), tile.counters());
  std::vector<std::vector<VisibilityRecord>> records(tile.patches().size());
  const Answers answers{{}, records.data(), points.data()};
  RayComb().walk(planned.strata, 1u << 12, 0.3,
                 [&](const SegmentHits& hits) { planned.stage.shoot(group, hits, answers, rays); });
  rays.trace();
  for (uint32_t k = 0; k < group.group.count; ++k) {
    EXPECT_NEAR(points[group.primary(k)].lamps, 0, 1e-6f);
    EXPECT_NEAR(planned.lit[group.primary(k)], of_lamp[k], 1e-6f);
  }
  EXPECT_FALSE(records[group.group.patch].empty());
}

/// Eye rays hardly ever hit a square that is far away. Some are sent nevertheless, which bounds the
/// weight of light points.
TEST(LocalStrata, PlanADefensiveShareOfEyeRays) {
  StageTile tile(floor_xml(kGrey) + R"(<shape type="rectangle"><transform name="to_world">
      <rotate x="1" angle="90"/><translate y="400"/></transform>
      <emitter type="area"><rgb name="radiance" value="3e6 2e6 1e6"/></emitter></shape>)");
  const PlannedLocal planned(tile);
  const Patch& patch = planned.patch;
  EXPECT_GT(patch.glossy, 0);
  const float share =
      static_cast<float>(planned.group.group.count) / static_cast<float>(patch.count);
  EXPECT_NEAR(patch.eye_rays, share / 8, 1e-6f);
}

/// A mirror reflects the full radiance of the square.
TEST(EyeRays, OfMirrorsFindReflectedLight) {
  StageTile tile(floor_xml(R"(<bsdf type="conductor"/>)") +
                 R"(<shape type="rectangle"><transform name="to_world"><scale value="50"/>
                    <rotate x="1" angle="90"/><translate y="9"/></transform>
                    <emitter type="area"><rgb name="radiance" value="3 2 1"/></emitter></shape>)");
  const GroupView group = tile.view(0);
  const CellLight light = tile.light(1);
  LocalChoice choice;
  choice.choose(*light.local, light.local_points, tile.patches(), tile.visibility(),
                light.first_local(), tile.primaries().size(), 1);
  EyeRays eye_rays(light);
  eye_rays.begin_tile(tile.scene(), choice, 1, tile.counters());
  EXPECT_FALSE(eye_rays.applies(group)) << "there is no lobe to sample";
  StageTimes times;
  ShadowRays rays(times);
  rays.begin(tile.scene(), tile.counters());
  for (uint32_t k = 0; k < group.group.count; ++k) {
    const SurfaceInteraction& si = group.interaction(k);
    Rgb sum(0.f);
    eye_rays.send_mirrored(si, group.primary(k), 7, sum);
    EXPECT_EQ(sum, Rgb(0.f)) << "rays are queued";
    eye_rays.trace(rays);
    rays.trace();
    const auto mirrored = mirrored_direction(si, 0, 1);
    ASSERT_TRUE(mirrored);
    EXPECT_LT(glm::length(mirrored->d - glm::reflect(-si.frame.to_world(si.wi), si.n)), 1e-5f);
    EXPECT_EQ(sum, mirrored->weight * Rgb(3, 2, 1));
  }
}

}  // namespace
}  // namespace kinome::test::strata_stages_test
