#include <gtest/gtest.h>

#include "support/bsdf_cases.h"
#include "support/statistics.h"

/// Tests of BSDFs: albedos, reciprocity, weights, and finite values at all extremes.
namespace kinome::test::bsdf_energy_test {
namespace {

class BsdfEnergy : public testing::TestWithParam<BsdfCase> {};

/// Integral of f cos over the sphere, by the midpoint rule on (u, v). The nodes gather at the
/// mirror direction, where glossy lobes are narrow: wo = R(t), with t in polar coordinates around
/// that direction and a polar angle that grows with the fourth power of v.
glm::dvec3 albedo_by_quadrature(const Bsdf& bsdf, const SurfaceInteraction& si, Lobe mask) {
  constexpr int kRows = 600;
  constexpr int kColumns = 300;
  const Frame around = Frame::from_normal(Vec3(-si.wi.x, -si.wi.y, si.wi.z));
  glm::dvec3 sum(0.);
  for (int i = 0; i < kRows; ++i) {
    const double v = (i + 0.5) / kRows;
    const double theta = std::numbers::pi * v * v * v;
    const double weight =
        std::sin(theta) * 3 * std::numbers::pi * v * v / kRows * 2 * std::numbers::pi / kColumns;
    for (int j = 0; j < kColumns; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / kColumns;
      const Vec3 local(static_cast<float>(std::sin(theta) * std::cos(phi)),
                       static_cast<float>(std::sin(theta) * std::sin(phi)),
                       static_cast<float>(std::cos(theta)));
      sum += weight * glm::dvec3(bsdf.eval_pdf(si, mask, around.to_world(local)).f);
    }
  }
  return sum;
}

// Furnace test: under uniform radiance of 1, the reflected light is the albedo. The mean of sample
// weights estimates the same integral as the grid; rejected samples have weight 0.
TEST_P(BsdfEnergy, MeanWeightIsTheAlbedo) {
  const auto bsdf = GetParam().make();
  const Lobe smooth = Lobe::kDiffuse | Lobe::kGlossy;
  std::vector<Estimate> by_grid, by_samples;
  RandomDirections random(5);
  for (const auto& [theta, phi] :
       {std::pair(2.f, 10.f), std::pair(45.f, 200.f), std::pair(85.f, -50.f)}) {
    const SurfaceInteraction si = seen_at(theta, phi);
    const glm::dvec3 albedo = albedo_by_quadrature(*bsdf, si, smooth);
    Moments moments[3];
    for (int i = 0; i < 60000; ++i) {
      const float u1 = random.unit();
      const auto s = bsdf->sample(si, smooth, u1, random.unit2());
      for (int c = 0; c < 3; ++c) moments[c].add(s ? s->weight[c] : 0);
    }
    for (int c = 0; c < 3; ++c) {
      // The grid's own error at kinks and narrow lobes is below 2e-4, measured by doubling the
      // grid.
      by_grid.push_back({albedo[c], std::pow(2e-4 * albedo[c], 2)});
      by_samples.push_back({moments[c].mean(), moments[c].variance_of_mean()});
      if (GetParam().conserves_energy) {
        EXPECT_LE(albedo[c], 1 + 1e-3) << "theta " << theta;
      }
    }
  }
  // There are 24 BSDFs: a false alarm for one in 1000 sets of seeds.
  const Verdict verdict = z_test(by_grid, by_samples, 1e-3 / 24);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

class BsdfReciprocity : public BsdfEnergy {};

TEST_P(BsdfReciprocity, IsReciprocal) {
  const auto bsdf = GetParam().make();
  RandomDirections random(11);
  for (int i = 0; i < 2000; ++i) {
    Vec3 a = random.sphere();
    Vec3 b = random.sphere();
    a.z = std::abs(a.z);
    b.z = std::abs(b.z);
    // Half of the directions are close to the mirror direction; otherwise they would miss narrow
    // lobes.
    if (i % 2) b = glm::normalize(Vec3(-a.x, -a.y, a.z) + 0.02f * b);
    const Rgb forth = bsdf->eval_pdf(seen_from(a), Lobe::kAll, b).f * a.z;
    const Rgb back = bsdf->eval_pdf(seen_from(b), Lobe::kAll, a).f * b.z;
    for (int c = 0; c < 3; ++c) {
      // Rounding of the half vector (1e-7) times the slope of the narrowest lobe, h / alpha² = 2500
      // h.
      EXPECT_NEAR(forth[c], back[c], 1e-3f * std::max(forth[c], back[c]) + 1e-12f)
          << a.x << ' ' << a.y << ' ' << a.z << " / " << b.x << ' ' << b.y << ' ' << b.z;
    }
  }
}

TEST_P(BsdfEnergy, WeightsAreValuesOverDensities) {
  const auto bsdf = GetParam().make();
  RandomDirections random(3);
  for (int i = 0; i < 2000; ++i) {
    const SurfaceInteraction si = seen_from(random.sphere());
    for (const Lobe mask : masks_of(*bsdf)) {
      const float u1 = random.unit();
      const auto s = bsdf->sample(si, mask, u1, random.unit2());
      if (!s) continue;
      EXPECT_NEAR(glm::length(s->wo), 1, 1e-5f);
      EXPECT_TRUE(any(s->lobe & mask)) << "a lobe that was not requested";
      EXPECT_TRUE(any(s->lobe & bsdf->lobes()));
      if (any(s->lobe & Lobe::kDelta)) {
        EXPECT_EQ(s->pdf, 1);
        continue;
      }
      const BsdfValue v = bsdf->eval_pdf(si, mask, s->wo);
      // A normal map transforms wo to its own frame and back; the half vector is rounded as above.
      EXPECT_NEAR(s->pdf, v.pdf, 2e-3f * v.pdf);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(s->weight[c] * s->pdf, v.f[c], 2e-3f * v.f[c] + 1e-12f);
      }
    }
  }
}

/// BSDFs without transmission: transmission has no such bound.
class BsdfReflectionFrame : public testing::TestWithParam<BsdfCase> {};
TEST_P(BsdfReflectionFrame, BoundsTheReflection) {
  const auto bsdf = GetParam().make();
  RandomDirections random(13);
  for (int i = 0; i < 300; ++i) {
    const SurfaceInteraction si = seen_from(random.sphere());
    const Vec3 n = bsdf->reflection_frame(si).n;
    EXPECT_NEAR(glm::length(n), 1, 1e-5f);
    for (int k = 0; k < 30; ++k) {
      const Vec3 wo = random.sphere();
      if (glm::dot(n, wo) > 0) continue;
      EXPECT_TRUE(is_black(bsdf->eval_pdf(si, Lobe::kAll, wo).f));
    }
  }
}

TEST_P(BsdfEnergy, ReflectanceIsZeroOnlyWhereLobesAre) {
  const auto bsdf = GetParam().make();
  RandomDirections random(17);
  for (int i = 0; i < 300; ++i) {
    const SurfaceInteraction si = seen_from(random.sphere());
    const LobeReflectance albedo = bsdf->reflectance(si);
    for (const Rgb& c : {albedo.diffuse, albedo.glossy}) {
      EXPECT_TRUE(is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0);
      EXPECT_LE(max_component(c), 1.001f);
    }
    const Vec3 wo = random.sphere();
    for (const auto& [lobe, c] :
         {std::pair(Lobe::kDiffuse, albedo.diffuse), std::pair(Lobe::kGlossy, albedo.glossy)}) {
      if (is_black(c)) {
        EXPECT_TRUE(is_black(bsdf->eval_pdf(si, lobe, wo).f));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, BsdfEnergy, testing::ValuesIn(bsdf_cases()), case_name);

std::vector<BsdfCase> one_sided_cases() {
  std::vector<BsdfCase> cases = bsdf_cases();
  std::erase_if(cases, [](const BsdfCase& c) { return c.has_rough_transmission; });
  return cases;
}
INSTANTIATE_TEST_SUITE_P(All, BsdfReflectionFrame, testing::ValuesIn(one_sided_cases()), case_name);

/// Perturbed frames are not reciprocal.
std::vector<BsdfCase> reciprocal_cases() {
  std::vector<BsdfCase> cases = bsdf_cases();
  std::erase_if(cases, [](const BsdfCase& c) { return !c.reciprocal; });
  return cases;
}
INSTANTIATE_TEST_SUITE_P(All, BsdfReciprocity, testing::ValuesIn(reciprocal_cases()), case_name);

TEST(BsdfFurnace, DiffuseReflectsItsReflectanceExactly) {
  const auto bsdf =
      make<Bsdf>("<bsdf type='diffuse'><rgb name='reflectance' value='0 .3 1'/></bsdf>");
  RandomDirections random(1);
  for (int i = 0; i < 100; ++i) {
    const auto s = bsdf->sample(seen_at(50, 0), Lobe::kAll, random.unit(), random.unit2());
    ASSERT_TRUE(s);
    EXPECT_EQ(s->weight, Rgb(0, 0.3f, 1));
  }
}

// Two samples, mirror and base, share the albedo of smooth plastic: F + (1 - F) base.
TEST(BsdfFurnace, PlasticMirrorsItsFresnelShare) {
  const auto bsdf = make<Bsdf>(
      "<bsdf type='plastic'><float name='int_ior' value='1.5'/>"
      "<float name='ext_ior' value='1'/></bsdf>");
  const SurfaceInteraction si = seen_at(0, 0);
  const auto mirror = bsdf->sample(si, Lobe::kDelta, 0.7f, Vec2(0.5f));
  ASSERT_TRUE(mirror);
  EXPECT_EQ(mirror->lobe, Lobe::kDelta);
  EXPECT_NEAR(mirror->weight.x, 0.04f, 1e-6f);
  // Among all lobes the mirror has probability p and weight F / p, so that its mean is F.
  Moments moments;
  RandomDirections random(2);
  for (int i = 0; i < 100000; ++i) {
    const float u1 = random.unit();
    const auto s = bsdf->sample(si, Lobe::kAll, u1, random.unit2());
    moments.add(s && any(s->lobe & Lobe::kDelta) ? s->weight.x : 0);
  }
  const Verdict verdict = z_test({{moments.mean(), moments.variance_of_mean()}}, {{0.04, 0}}, 1e-4);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

}  // namespace
}  // namespace kinome::test::bsdf_energy_test
