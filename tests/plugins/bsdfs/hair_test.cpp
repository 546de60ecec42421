/// Tests of known properties of hair. bsdf_reference_test.cpp compares its values with Mitsuba's.
#include <gtest/gtest.h>

#include "support/bsdf_cases.h"
#include "support/statistics.h"

namespace kinome::test::hair_test {
namespace {

std::shared_ptr<Bsdf> hair(const std::string& children) {
  return make<Bsdf>("<bsdf type='hair'>" + children + "</bsdf>");
}

/// White hair under uniform light reflects all of it (Chiang et al. 2016, 4.2).
TEST(Hair, WithoutPigmentReflectsAll) {
  const auto white = hair(
      "<float name='eumelanin' value='0'/><float name='pheomelanin' value='0'/>"
      "<float name='longitudinal_roughness' value='0.4'/>");
  RandomDirections random(3);
  for (int i = 0; i < 40; ++i) {
    const SurfaceInteraction si = seen_from(random.sphere());
    EXPECT_NEAR(white->reflectance(si).glossy.x, 1, 1e-4f);
    for (int k = 0; k < 100; ++k) {
      const float u1 = random.unit();
      const auto s = white->sample(si, Lobe::kAll, u1, random.unit2());
      ASSERT_TRUE(s);
      // Density and value have the same lobes, all white.
      EXPECT_NEAR(s->weight.x, 1, 1e-3f);
      EXPECT_NEAR(s->weight.z, 1, 1e-3f);
    }
  }
}

/// The mean of the value over directions, sampled with a density independent of hair.
TEST(Hair, ValuesIntegrateToTheAlbedo) {
  for (const char* const children :
       {"", "<float name='longitudinal_roughness' value='0.7'/>"
            "<float name='azimuthal_roughness' value='0.8'/>"}) {
    const auto bsdf = hair(children);
    for (const auto& [theta, phi] : {std::pair(20.f, 0.f), std::pair(60.f, 80.f)}) {
      const SurfaceInteraction si = seen_at(theta, phi);
      Moments value[3];
      RandomDirections random(9);
      for (int i = 0; i < 200000; ++i) {
        const Rgb f = bsdf->eval_pdf(si, Lobe::kAll, random.sphere()).f;
        for (int c = 0; c < 3; ++c) value[c].add(f[c] * 4 * kPi);
      }
      std::vector<Estimate> estimated, expected;
      for (int c = 0; c < 3; ++c) {
        estimated.push_back({value[c].mean(), value[c].variance_of_mean()});
        expected.push_back({bsdf->reflectance(si).glossy[c], 0});
      }
      const Verdict verdict = z_test(estimated, expected, 1e-5);
      EXPECT_TRUE(verdict.passed) << children << theta << ": " << verdict.text;
    }
  }
}

TEST(Hair, PigmentsAreAbsorption) {
  const SurfaceInteraction si = seen_at(30, 10);
  const Vec3 wo = seen_at(50, 200).wi;
  const Rgb pigments = hair("<float name='eumelanin' value='0.5'/>"
                            "<float name='pheomelanin' value='2'/>")
                           ->eval_pdf(si, Lobe::kAll, wo)
                           .f;
  // 0.5 (.419 .697 1.37) + 2 (.187 .4 1.05), divided by 2.
  const Rgb absorption = hair("<rgb name='sigma_a' value='0.29175 0.57425 1.3925'/>"
                              "<float name='scale' value='2'/>")
                             ->eval_pdf(si, Lobe::kAll, wo)
                             .f;
  EXPECT_LT(glm::distance(pigments, absorption), 1e-5f * pigments.x);
  EXPECT_GT(pigments.x, pigments.z);
}

}  // namespace
}  // namespace kinome::test::hair_test
