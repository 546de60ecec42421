// Tests candidates that pixels of a tile share: which points share them, and that estimates equal
// the light that the points reflect.
#include "clustered/product/choice/shared_candidates.h"

#include <gtest/gtest.h>

#include "clustered/product/strata/glossy_strata.h"
#include "stage_tile.h"

namespace kinome::test::shared_candidates_test {
namespace {

constexpr uint16_t kRaysOfPixel = 3;
constexpr float kWanted = 96;

/// Returns the 16 pixels of a tile.
std::vector<Unit> units_of(const StageTile& tile, float candidates = kWanted) {
  std::vector<Unit> units(16);
  for (uint32_t k = 0; k < 16; ++k) {
    units[k].first = tile.primaries().first(k);
    units[k].end = tile.primaries().first(k + 1);
    units[k].candidates = candidates;
  }
  return units;
}
GroupView group_of(StageTile& tile, const Unit& unit) {
  tile.groups().divide(tile.primaries(), tile.patches(), unit.first, unit.end);
  return tile.view(0);
}

TEST(PointNodes, AFloorIsOne) {
  StageTile tile(floor_xml(rough_xml("roughconductor", 0.2)) + sky_xml(), kRaysOfPixel);
  PointNodes nodes;
  nodes.divide(tile.primaries(), tile.patches(), units_of(tile));
  ASSERT_EQ(nodes.nodes().size(), 1u);
  const PointNode& node = nodes.nodes()[0];
  EXPECT_EQ(node.pixels, 16u);
  EXPECT_EQ(node.points, tile.primaries().size());
  EXPECT_NEAR(node.wanted, 16 * kWanted, 1e-2);
  EXPECT_NEAR(glm::dot(node.normal, Vec3(0, 1, 0)), 1, 1e-5);
  EXPECT_NEAR(glm::dot(node.normal, node.tangent), 0, 1e-5);
  for (uint32_t i = 0; i < tile.primaries().size(); ++i) EXPECT_EQ(nodes.of(i), 0);
  EXPECT_EQ(nodes.of(node.points), -1);
}

/// Points of a curved ball reflect differently. Sharper lobes need more nodes.
TEST(PointNodes, ABallIsSeveral) {
  size_t before = 0;
  for (const double alpha : {0.6, 0.3, 0.1}) {
    StageTile tile(ball_xml(rough_xml("roughconductor", alpha)) + sky_xml(), kRaysOfPixel);
    PointNodes nodes;
    nodes.divide(tile.primaries(), tile.patches(), units_of(tile));
    EXPECT_GT(nodes.nodes().size(), before) << alpha;
    before = nodes.nodes().size();
    std::vector<uint32_t> points(before);
    std::vector<double> squares(before);
    for (uint32_t i = 0; i < tile.primaries().size(); ++i) {
      if (tile.primaries().patch(i) < 0) {
        EXPECT_EQ(nodes.of(i), -1);
        continue;
      }
      ASSERT_GE(nodes.of(i), 0);
      const PointNode& node = nodes.nodes()[nodes.of(i)];
      EXPECT_EQ(node.patch, tile.primaries().patch(i));
      const Vec3 n = tile.primaries().normal(i);
      EXPECT_GE(glm::dot(node.normal, n), node.cosine - 1e-6f);
      const Vec3 offset = node.offset(n, tile.primaries().viewer(i));
      squares[nodes.of(i)] += glm::dot(offset, offset);
      ++points[nodes.of(i)];
    }
    for (size_t k = 0; k < before; ++k) {
      const PointNode& node = nodes.nodes()[k];
      EXPECT_EQ(node.points, points[k]);
      // Offsets omit changes along the normal, which are of higher order.
      EXPECT_NEAR(node.spread2, squares[k] / points[k], 0.05 * node.spread2 + 1e-6);
    }
  }
}

TEST(PointNodes, WithoutAMicrofacetLobeThereAreNone) {
  for (const std::string& material :
       {kGrey, std::string(R"(<bsdf type="phong"/>)"), asked_xml(rough_xml("roughplastic", 0.2))}) {
    StageTile tile(floor_xml(material) + sky_xml(), kRaysOfPixel);
    PointNodes nodes;
    nodes.divide(tile.primaries(), tile.patches(), units_of(tile));
    EXPECT_TRUE(nodes.nodes().empty()) << material;
  }
}

/// The mean of each pixel over draws is the light that its own points reflect. Candidates are drawn
/// for the mean of all pixels, and visibilities are wrong.
TEST(SharedCandidates, AddUpToTheLightOfEachPixel) {
  struct Case {
    const char* name;
    std::string shape;
    float wanted;
  };
  const std::string map = normal_map_xml({0.55f, 0.48f, 1}, rough_xml("roughplastic", 0.25));
  for (const Case& c : {Case{"floor", floor_xml(rough_xml("roughconductor", 0.25)), kWanted},
                        Case{"many", floor_xml(rough_xml("roughplastic", 0.3)), 600},
                        Case{"few", floor_xml(rough_xml("roughplastic", 0.3)), 20},
                        Case{"turned", floor_xml(map), kWanted},
                        Case{"ball", ball_xml(rough_xml("roughconductor", 0.6)), kWanted}}) {
    SCOPED_TRACE(c.name);
    StageTile tile(c.shape + sky_xml(), kRaysOfPixel);
    tile.guess_visibility();
    const std::vector<Unit> units = units_of(tile, c.wanted);
    for (const size_t pixel : {size_t{2}, size_t{12}}) {
      const GroupView group = group_of(tile, units[pixel]);
      std::unique_ptr<CellLight> light;
      std::unique_ptr<GlossyStrata> stage;
      const MeanRgb mean = estimate(
          tile,
          [&](uint64_t seed, Strata& strata) {
            light = std::make_unique<CellLight>(tile.light(seed));
            stage = std::make_unique<GlossyStrata>(*light);
            stage->begin_tile(tile.primaries(), tile.patches(), tile.visibility(), units,
                              hash_words(seed, 78));
            stage->begin_unit();
            return stage->add(group, c.wanted, hash_words(seed, 79, pixel), strata);
          },
          [&](uint64_t, const SegmentHits& hits, const Answers& answers, ShadowRays& rays) {
            stage->shoot(group, hits, answers, rays);
          });
      SharedCandidates shared(*light);
      shared.begin_tile(tile.primaries(), tile.patches(), tile.visibility(), units, 0);
      ASSERT_NE(shared.find(group), nullptr);
      mean.expect(tile.reflected_sky(group, Lobe::kGlossy), pixel == 2 ? "second" : "twelfth");
    }
  }
}

/// Candidates aren't shared if points differ by more than the lobe's width, or by too few pixels.
TEST(SharedCandidates, AreForPointsThatAreAlike) {
  const auto is_shared = [](const std::string& shapes, size_t pixels) {
    StageTile tile(shapes + sky_xml(), kRaysOfPixel);
    const CellLight light = tile.light(1);
    SharedCandidates shared(light);
    const std::vector<Unit> units = units_of(tile);
    shared.begin_tile(tile.primaries(), tile.patches(), tile.visibility(),
                      std::span(units).first(pixels), 1);
    return shared.find(group_of(tile, units[1])) != nullptr;
  };
  const std::string metal = rough_xml("roughconductor", 0.3);
  EXPECT_TRUE(is_shared(floor_xml(metal), 16));
  EXPECT_TRUE(is_shared(floor_xml(metal), 3));
  EXPECT_FALSE(is_shared(floor_xml(metal), 2));
  EXPECT_FALSE(is_shared(ball_xml(rough_xml("roughconductor", 0.02)), 16));
}

/// The number of blocks increases with the requested candidates, up to those of the set.
TEST(SharedCandidates, BlocksMatchTheRequestedCells) {
  StageTile tile(floor_xml(rough_xml("roughconductor", 0.3)) + sky_xml(), kRaysOfPixel);
  const CellLight light = tile.light(1);
  SharedCandidates shared(light);
  for (const float wanted : {16.f, 96.f, 900.f, 3500.f}) {
    const std::vector<Unit> units = units_of(tile, wanted);
    shared.begin_tile(tile.primaries(), tile.patches(), tile.visibility(), units, 1);
    const SharedCandidates::Set* const set = shared.find(group_of(tile, units[5]));
    ASSERT_NE(set, nullptr);
    uint32_t before = 1;
    for (const float factor : {0.1f, 0.5f, 1.f, 2.f, 10.f}) {
      const uint32_t blocks = SharedCandidates::blocks_for(*set, factor * wanted);
      EXPECT_GE(blocks, before);
      EXPECT_LE(blocks, set->blocks);
      before = blocks;
    }
    EXPECT_EQ(before, set->blocks);
    EXPECT_EQ(set->size % kBlockLanes, 0u);
    EXPECT_GE(set->size, set->from_lobe + set->from_cells);
  }
}

}  // namespace
}  // namespace kinome::test::shared_candidates_test
