// Tests how the points of a tile are divided into groups.
#include "clustered/product/tiles/groups.h"

#include <set>

#include "stage_tile.h"

namespace kinome::test::groups_test {
namespace {

TEST(Groups, HoldEachPointThatReflectsOnce) {
  // A light in part of the image, whose surface reflects nothing.
  StageTile tile(ball_xml(kGrey) + sky_xml() +
                     R"(<shape type="rectangle"><transform name="to_world"><scale value=".1"/>
                              <rotate x="1" angle="-90"/><translate y=".6"/></transform>
                              <emitter type="area"/></shape>)",
                 8);
  const TilePrimaries& primaries = tile.primaries();
  Groups groups;
  const auto size = static_cast<uint32_t>(primaries.size());
  for (const auto& [first, end] : {std::pair(0u, size), {5u, size / 2}, {7u, 7u}}) {
    groups.divide(primaries, tile.patches(), first, end);
    std::set<uint32_t> expected, found;
    for (uint32_t i = first; i < end; ++i) {
      if (primaries.patch(i) >= 0) expected.insert(i);
    }
    uint32_t next = 0;
    for (uint32_t g = 0; g < groups.size(); ++g) {
      const Group& group = groups[g];
      EXPECT_EQ(group.first, next);
      next += group.count;
      ASSERT_GT(group.count, 0u);
      const uint32_t* const members = groups.members(group);
      EXPECT_TRUE(std::is_sorted(members, members + group.count));
      for (uint32_t k = 0; k < group.count; ++k) {
        EXPECT_TRUE(found.insert(members[k]).second);
        EXPECT_EQ(primaries.patch(members[k]), group.patch);
      }
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(groups.order().size(), expected.size());
    EXPECT_EQ(groups.empty(), expected.empty());
  }
}

TEST(Groups, StoreTheCommonValuesOfTheirPoints) {
  StageTile tile(ball_xml(kGrey) + sky_xml());
  for (uint32_t g = 0; g < tile.groups().size(); ++g) {
    const GroupView view = tile.view(g);
    const Group& group = view.group;
    EXPECT_NEAR(glm::length(group.normal), 1, 1e-6);
    EXPECT_NEAR(glm::length(group.viewer), 1, 1e-6);
    float min_cosine = 1;
    double albedo = 0;
    Vec3 red(0.f);
    for (uint32_t k = 0; k < group.count; ++k) {
      min_cosine = std::min(min_cosine, glm::dot(group.normal, view.normal(k)));
      const Rgb diffuse = tile.primaries().diffuse(view.primary(k));
      albedo += (diffuse.x + diffuse.y + diffuse.z) / 3;
      red += diffuse.x * view.normal(k);
    }
    EXPECT_EQ(group.cosine, min_cosine);
    EXPECT_NEAR(group.albedo, albedo, 1e-5 * albedo);
    EXPECT_LT(glm::length(group.albedo_normal[0] - red), 1e-5f * group.albedo);
  }
}

/// On a ball, each point of a mirror-like lobe reflects another direction. Wide lobes need few
/// groups.
TEST(Groups, AreManyWhereLobesAreSharp) {
  const auto number_of = [](const std::string& material) {
    StageTile tile(ball_xml(material) + sky_xml());
    const size_t patches = tile.patches().size(), groups = tile.groups().size();
    for (uint32_t g = 0; g < groups; ++g) {
      const GroupView view = tile.view(g);
      if (!is_sharp(view.patch)) continue;
      // Twice the spread, because the mean moves when points are added.
      EXPECT_GT(view.group.cosine, 1 - 2 * view.patch.alpha2());
    }
    return std::pair(patches, groups);
  };
  const auto [wide_patches, wide] = number_of(rough_xml("roughconductor", 0.3));
  EXPECT_EQ(wide, wide_patches);
  const auto [sharp_patches, sharp] = number_of(rough_xml("roughconductor", 0.08));
  EXPECT_GT(sharp, 2 * sharp_patches);
  EXPECT_LE(sharp, 64u);
}

}  // namespace
}  // namespace kinome::test::groups_test
