/// Tests of rough dielectric boundaries.
#include <gtest/gtest.h>

#include <cmath>

#include "support/bsdf_cases.h"
#include "support/statistics.h"

namespace kinome::test::roughdielectric_test {
namespace {

constexpr float kIndices[] = {0.6f, 1.2f, 1.5046f, 2.419f};

std::shared_ptr<Bsdf> glass(float eta, const std::string& more) {
  return make<Bsdf>("<bsdf type='roughdielectric'><float name='int_ior' value='" +
                    std::to_string(eta) + "'/><float name='ext_ior' value='1'/>" + more +
                    "</bsdf>");
}
const std::string kGgx = "<string name='distribution' value='ggx'/>";

float index_at(const Vec3& direction, float eta) {
  return direction.z > 0 ? 1 : eta;
}

/// Returns the Fresnel reflectance of the microfacet that leads from wi to wo, in double precision.
double reflectance(const Vec3& wi, const Vec3& wo, float eta) {
  const double n_i = double{index_at(wi, eta)}, n_o = double{index_at(wo, eta)};
  const glm::dvec3 i(wi), o(wo);
  const glm::dvec3 h = glm::normalize(wi.z * wo.z > 0 ? i + o : n_i * i + n_o * o);
  const double n_t = wi.z > 0 ? double{eta} : 1;
  const double cos_i = std::abs(glm::dot(i, h));
  const double sin_t = std::sqrt(1 - cos_i * cos_i) * n_i / n_t;
  if (sin_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin_t * sin_t);
  const double s = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t);
  const double p = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t);
  return (s * s + p * p) / 2;
}

/// f |cos| / cos is symmetric, except for the squared indices of both sides (Veach 1997, 5.2).
TEST(RoughDielectric, IsReciprocalButForTheIndices) {
  for (const float eta : kIndices) {
    for (const std::string& type : {std::string(), kGgx}) {
      const auto bsdf =
          glass(eta, type + "<float name='alpha_u' value='.3'/><float name='alpha_v' value='.6'/>");
      RandomDirections random(7);
      int through = 0, mirrored = 0;
      for (int i = 0; i < 20000; ++i) {
        const Vec3 a = random.sphere(), b = random.sphere();
        if (std::abs(a.z) < 1e-3f || std::abs(b.z) < 1e-3f) continue;
        // At the critical angle the slope of the Fresnel reflectance is infinite.
        const double share = reflectance(a, b, eta);
        if (share > 0.5 && share < 1) continue;
        const float forth = bsdf->eval_pdf(seen_from(a), Lobe::kAll, b).f.x /
                            (std::abs(b.z) * sqr(index_at(a, eta)));
        const float back = bsdf->eval_pdf(seen_from(b), Lobe::kAll, a).f.x /
                           (std::abs(a.z) * sqr(index_at(b, eta)));
        // Tolerance: rounding of the half vector, magnified in the tails of D.
        EXPECT_NEAR(forth, back, 2e-3f * std::max(forth, back) + 1e-9f)
            << eta << type << ' ' << a.x << ' ' << a.y << ' ' << a.z << " / " << b.x << ' ' << b.y
            << ' ' << b.z;
        (a.z * b.z > 0 ? mirrored : through) += forth > 1e-3f;
      }
      EXPECT_GT(mirrored, 1000);
      EXPECT_GT(through, 300);
    }
  }
}

/// Tests the mapping from u2 to directions, for reflection and for transmission. Divides the
/// density by the probability of the choice between the two.
TEST(RoughDielectric, DensityIsTheInverseJacobianOnBothSides) {
  for (const float eta : kIndices) {
    for (const std::string& type :
         {std::string(), kGgx, "<boolean name='sample_visible' value='false'/>" + kGgx}) {
      const auto bsdf = glass(eta, type + "<float name='alpha' value='.3'/>");
      for (const float theta : {30.f, 75.f, 120.f, 170.f}) {
        const SurfaceInteraction si = seen_at(theta, 40);
        for (const bool goes_through : {false, true}) {
          const auto sample = [&](Vec2 u2) -> std::optional<Vec3> {
            const auto s =
                bsdf->sample(si, Lobe::kAll, goes_through ? kOneMinusEpsilon : 0.f, u2);
            if (!s || (s->wo.z * si.wi.z < 0) != goes_through) return std::nullopt;
            return s->wo;
          };
          const auto pdf = [&](const Vec3& wo) {
            const double mirrored = reflectance(si.wi, wo, eta);
            const double share = goes_through ? 1 - mirrored : mirrored;
            return static_cast<float>(double{bsdf->eval_pdf(si, Lobe::kAll, wo).pdf} / share);
          };
          int accepted = 0;
          RandomDirections random(2);
          for (int i = 0; i < 64; ++i) accepted += sample(random.unit2()).has_value();
          if (accepted < 16) continue;
          const auto verdict = jacobian_test(sample, pdf, 1000, 2e-3);
          EXPECT_TRUE(verdict.passed) << eta << type << ", " << theta << (goes_through ? " through" : "")
                                      << ": " << verdict.text;
        }
      }
    }
  }
}

/// Tests conservation of power: radiance through the surface scales with the squared index.
/// Microfacets lose some power to one another; a smooth surface loses none.
TEST(RoughDielectric, LosesLittleAndMakesNothing) {
  for (const float eta : kIndices) {
    for (const float alpha : {0.002f, 0.1f, 0.4f}) {
      const auto bsdf =
          glass(eta, kGgx + "<float name='alpha' value='" + std::to_string(alpha) + "'/>");
      for (const float theta : {10.f, 50.f, 130.f, 160.f}) {
        const SurfaceInteraction si = seen_at(theta, 0);
        const float n_i = index_at(si.wi, eta);
        Moments sum, mirrored;
        RandomDirections random(3);
        for (int i = 0; i < 20000; ++i) {
          const float u1 = random.unit();
          const auto s = bsdf->sample(si, Lobe::kAll, u1, random.unit2());
          const float power = s ? s->weight.x * sqr(index_at(s->wo, eta) / n_i) : 0.f;
          sum.add(power);
          mirrored.add(s && s->wo.z * si.wi.z > 0 ? power : 0.f);
          EXPECT_LT(power, 1 + 1e-3f);
        }
        EXPECT_GT(sum.mean(), alpha < 0.01f ? 1 - 1e-3 : 0.7) << eta << ' ' << alpha << ' ' << theta;
        if (alpha > 0.01f) continue;
        const Vec3 mirror(-si.wi.x, -si.wi.y, si.wi.z);
        const Verdict verdict =
            z_test({{mirrored.mean(), mirrored.variance_of_mean() + 1e-6}},
                   {{reflectance(si.wi, mirror, eta), 0}}, 1e-5);
        EXPECT_TRUE(verdict.passed) << eta << ' ' << theta << ": " << verdict.text;
      }
    }
  }
}

TEST(RoughDielectric, ColoursEachSide) {
  const auto white = glass(1.5f, "<float name='alpha' value='.3'/>");
  const auto coloured = glass(1.5f, "<float name='alpha' value='.3'/>"
                                    "<rgb name='specular_reflectance' value='.1 .2 .3'/>"
                                    "<rgb name='specular_transmittance' value='.4 .5 .6'/>");
  for (const float theta : {20.f, 160.f}) {
    const SurfaceInteraction si = seen_at(theta, 10);
    const Vec3 mirror(-si.wi.x, -si.wi.y, si.wi.z);
    const Rgb reflected = white->eval_pdf(si, Lobe::kAll, mirror).f;
    const Rgb through = white->eval_pdf(si, Lobe::kAll, -si.wi).f;
    EXPECT_GT(reflected.x, 0);
    EXPECT_GT(through.x, 0);
    EXPECT_LT(glm::distance(coloured->eval_pdf(si, Lobe::kAll, mirror).f / reflected,
                            Rgb(0.1f, 0.2f, 0.3f)), 1e-5f);
    EXPECT_LT(glm::distance(coloured->eval_pdf(si, Lobe::kAll, -si.wi).f / through,
                            Rgb(0.4f, 0.5f, 0.6f)), 1e-5f);
  }
  EXPECT_TRUE(white->transmits());
  EXPECT_FLOAT_EQ(white->relative_index(), 1.5f);
}

}  // namespace
}  // namespace kinome::test::roughdielectric_test
