#include <gtest/gtest.h>

#include "support/bsdf_cases.h"
#include "support/statistics.h"

/// Tests that sample() matches eval_pdf()'s density: chi² over the sphere, and the map's Jacobian.
namespace kinome::test::bsdf_chi2_test {
namespace {

// About 350 tests use this level. Together they raise a false alarm for one in 1000 sets of seeds.
constexpr double kAlpha = 1e-3 / 350;

class BsdfSampling : public testing::TestWithParam<BsdfCase> {};

TEST_P(BsdfSampling, DensityMatchesSamples) {
  const auto bsdf = GetParam().make();
  uint64_t seed = 0;
  for (const auto& [theta, phi] :
       {std::pair(5.f, 10.f), std::pair(40.f, 200.f), std::pair(75.f, -50.f),
        std::pair(89.f, 100.f), std::pair(130.f, 30.f)}) {
    const SurfaceInteraction si = seen_at(theta, phi);
    for (const Lobe mask : masks_of(*bsdf)) {
      SphereChi2 test;
      test.sample = [&](float u1, Vec2 u2) -> std::optional<Vec3> {
        const auto s = bsdf->sample(si, mask, u1, u2);
        if (!s || any(s->lobe & Lobe::kDelta)) return std::nullopt;
        return s->wo;
      };
      test.pdf = [&](const Vec3& wo) { return bsdf->eval_pdf(si, mask, wo).pdf; };
      test.samples = 100000;
      test.subdivide = 4;
      test.seed = ++seed;
      const Verdict verdict = sphere_chi2_test(test, kAlpha);
      EXPECT_TRUE(verdict.passed) << "theta " << theta << ", mask " << static_cast<int>(mask)
                                  << ": " << verdict.text;
    }
  }
}

// For a fixed u1 and a mask of one lobe, sample() is one smooth map from u2 to directions. BSDFs
// that make a choice within a lobe have their own tests.
class BsdfLobeSampling : public testing::TestWithParam<BsdfCase> {};
TEST_P(BsdfLobeSampling, DensityIsTheInverseJacobian) {
  const auto bsdf = GetParam().make();
  int tested = 0;
  RandomDirections random(1);
  for (const auto& [theta, phi] :
       {std::pair(30.f, 70.f), std::pair(70.f, 5.f), std::pair(80.f, -20.f)}) {
    const SurfaceInteraction si = seen_at(theta, phi);
    for (const Lobe mask : masks_of(*bsdf)) {
      if (mask == Lobe::kAll) continue;
      const auto sample = [&](Vec2 u2) -> std::optional<Vec3> {
        const auto s = bsdf->sample(si, mask, 0.5f, u2);
        return s ? std::optional(s->wo) : std::nullopt;
      };
      // A steep normal map sends whole lobes below the horizon.
      int accepted = 0;
      for (int i = 0; i < 64; ++i) accepted += sample(random.unit2()).has_value();
      if (accepted < 4) continue;
      ++tested;
      const auto verdict = jacobian_test(
          sample, [&](const Vec3& wo) { return bsdf->eval_pdf(si, mask, wo).pdf; }, 2000,
          // Directions and densities are floats: an error of 1e-7 in a direction over a step of
          // 1/512, times the slope of D of the narrowest lobe here (alpha = .02).
          2e-3);
      EXPECT_TRUE(verdict.passed) << "theta " << theta << ", mask " << static_cast<int>(mask)
                                  << ": " << verdict.text;
    }
  }
  EXPECT_GT(tested, 0);
}

INSTANTIATE_TEST_SUITE_P(All, BsdfSampling, testing::ValuesIn(bsdf_cases()), case_name);

std::vector<BsdfCase> smooth_cases() {
  std::vector<BsdfCase> cases = bsdf_cases();
  std::erase_if(cases, [](const BsdfCase& c) { return c.chooses_within_lobe; });
  return cases;
}
INSTANTIATE_TEST_SUITE_P(All, BsdfLobeSampling, testing::ValuesIn(smooth_cases()), case_name);

}  // namespace
}  // namespace kinome::test::bsdf_chi2_test
