// Values of BSDFs for directions at members of a group: by kernels, and by asking.
#include "clustered/product/lobe_values.h"

#include "clustered/product/candidates.h"
#include "stage_tile.h"

namespace kinome::test {
namespace {

constexpr size_t kCount = 256;

/// Random directions of the upper half at random members.
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

/// Formulas of some tens of operations that are rounded otherwise: errors add up to some hundreds
/// of ulp at most.
void expect_near(const Candidates& a, const Candidates& b) {
  for (size_t i = 0; i < kCount; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(a.f[k][i], b.f[k][i], 5e-5 * std::abs(b.f[k][i]) + 1e-6) << i;
    }
    EXPECT_NEAR(a.lobe_density[i], b.lobe_density[i], 5e-5 * b.lobe_density[i] + 1e-6) << i;
  }
}

TEST(LobeValues, OfKernelsAreThoseOfTheBsdf) {
  for (const std::string& material : materials()) {
    SCOPED_TRACE(material);
    StageTile tile(ball_xml(material) + sky_xml());
    LobeValues values;
    for (uint32_t g = 0; g < tile.groups().size(); ++g) {
      const GroupView group = tile.view(g);
      ASSERT_TRUE(group.patch.is_described);
      Patch asked_patch = group.patch;
      asked_patch.is_described = false;
      const GroupView asked{group.group,     group.index,   asked_patch,    group.visibility,
                            group.primaries, group.members, group.point_ids};
      Candidates a = random_candidates(group, g), b = random_candidates(group, g);
      values.all(group, a.directions(0), a.lobe_columns(0));
      values.all(asked, b.directions(0), b.lobe_columns(0));
      expect_near(a, b);
      if (!group.has(Lobe::kGlossy)) continue;
      values.glossy(group, a.directions(0), a.lobe_columns(0));
      values.glossy(asked, b.directions(0), b.lobe_columns(0));
      expect_near(a, b);
    }
  }
}

TEST(LobeValues, AskedInWhateverOrder) {
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

/// Rays go by the cosine and by the lobe, in shares; a lobe alone has all of them.
TEST(LobeValues, DensityIsThatOfBothLobes) {
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
}  // namespace kinome::test
