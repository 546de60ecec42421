// Compares values of BSDFs for directions at members of a group: kernels and scalar functions.
#include "clustered/product/choice/lobe_values.h"

#include "clustered/product/choice/candidates.h"
#include "stage_tile.h"

namespace kinome::test::lobe_values_test {
namespace {

constexpr size_t kCount = 256;

/// Returns random directions of the upper hemisphere at random members.
Candidates random_candidates(const GroupView& group, unsigned seed) {
  Random random(seed);
  Candidates c;
  c.resize(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    c.member[i] = static_cast<uint32_t>(random.between(0, group.group.count));
    Vec3 d = random.direction();
    if (i % 8 != 0 && glm::dot(d, group.normal(c.member[i])) < 0) d = -d;
    c.dx[i] = d.x;
    c.dy[i] = d.y;
    c.dz[i] = d.z;
  }
  return c;
}

std::vector<std::string> materials() {
  return {kGrey, rough_xml("roughconductor", 0.1), rough_xml("roughconductor", 0.4),
          rough_xml("roughplastic", 0.15),
          normal_map_xml({0.6f, 0.45f, 0.98f}, rough_xml("roughplastic", 0.2))};
}

/// The formulas have some tens of operations, which are rounded differently. Errors add up to at
/// most some hundreds of ulp.
void expect_near(const Candidates& a, const Candidates& b) {
  for (size_t i = 0; i < kCount; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(a.f[k][i], b.f[k][i], 5e-5 * std::abs(b.f[k][i]) + 1e-6) << i;
    }
    EXPECT_NEAR(a.lobe_density[i], b.lobe_density[i], 5e-5 * b.lobe_density[i] + 1e-6) << i;
  }
}

TEST(LobeValues, OfKernelsMatchTheBsdf) {
  for (const std::string& material : materials()) {
    SCOPED_TRACE(material);
    StageTile tile(ball_xml(material) + sky_xml());
    LobeValues values;
    for (uint32_t g = 0; g < tile.groups().size(); ++g) {
      const GroupView group = tile.view(g);
      ASSERT_TRUE(group.patch.is_described);
      Patch scalar_patch = group.patch;
      scalar_patch.is_described = false;
      const GroupView scalar{group.group,     group.index,   scalar_patch,   group.visibility,
                             group.primaries, group.members, group.point_ids};
      Candidates a = random_candidates(group, g), b = random_candidates(group, g);
      values.all(group, a.directions(0), a.lobe_columns(0));
      values.all(scalar, b.directions(0), b.lobe_columns(0));
      expect_near(a, b);
      if (!group.has(Lobe::kGlossy)) continue;
      values.glossy(group, a.directions(0), a.lobe_columns(0));
      values.glossy(scalar, b.directions(0), b.lobe_columns(0));
      expect_near(a, b);
    }
  }
}

TEST(LobeValues, RequestedInAnyOrder) {
  StageTile tile(floor_xml(rough_xml("roughplastic", 0.2)) + sky_xml());
  const GroupView group = tile.view(0);
  ASSERT_GT(group.group.count, 4u);
  Candidates c = random_candidates(group, 2);
  LobeValues values;
  values.ask(group, Lobe::kDiffuse | Lobe::kGlossy, c.directions(0), c.lobe_columns(0).f);
  for (size_t i = 0; i < kCount; ++i) {
    const SurfaceInteraction& si = group.interaction(c.member[i]);
    const BsdfValue value = si.shape->bsdf().eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy,
                                                      si.frame.to_local(c.direction(i)));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(c.f[k][i], value.f[k], 1e-5 * value.f[k]) << i;
  }
}

/// A fraction of the rays is sampled by the cosine and the others by the lobe. If there is only one
/// lobe, it gets all rays.
TEST(LobeValues, DensityIsTheMixtureOfBothLobes) {
  for (const std::string& material : materials()) {
    SCOPED_TRACE(material);
    StageTile tile(ball_xml(material) + sky_xml());
    const GroupView group = tile.view(0);
    const float share = diffuse_share(group.patch);
    EXPECT_EQ(share == 1, !group.has(Lobe::kGlossy));
    EXPECT_EQ(share == 0, !group.has(Lobe::kDiffuse));
    Candidates all = random_candidates(group, 3), glossy = random_candidates(group, 3);
    LobeValues values;
    values.all(group, all.directions(0), all.lobe_columns(0));
    if (share < 1) values.glossy(group, glossy.directions(0), glossy.lobe_columns(0));
    for (size_t i = 0; i < kCount; ++i) {
      const float cosine = std::max(0.f, glm::dot(group.normal(all.member[i]), all.direction(i)));
      const float of_lobe = share < 1 ? glossy.lobe_density[i] : 0.f;
      EXPECT_NEAR(all.lobe_density[i], share * kInvPi * cosine + (1 - share) * of_lobe,
                  1e-6 * (1 + of_lobe));
    }
  }
}

}  // namespace
}  // namespace kinome::test::lobe_values_test
