/// Tests of smooth dielectric boundaries.
#include <gtest/gtest.h>

#include <cmath>

#include "support/bsdf_cases.h"
#include "transport/light_paths/adjoint.h"

namespace kinome::test::dielectric_test {
namespace {

constexpr float kIndices[] = {0.6f, 1.f, 1.3f, 1.5046f, 2.419f};

std::shared_ptr<Bsdf> dielectric(const char* type, float eta) {
  return make<Bsdf>("<bsdf type='" + std::string(type) + "'><float name='int_ior' value='" +
                    std::to_string(eta) + "'/><float name='ext_ior' value='1'/></bsdf>");
}

/// Returns the reflectance by Fresnel's formulas in double precision; 1 for total reflection.
double fresnel(double cos_i, double n_i, double n_t) {
  const double sin_t = std::sqrt(1 - cos_i * cos_i) * n_i / n_t;
  if (sin_t >= 1) return 1;
  const double cos_t = std::sqrt(1 - sin_t * sin_t);
  const double s = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t);
  const double p = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t);
  return (s * s + p * p) / 2;
}

std::vector<SurfaceInteraction> views() {
  std::vector<SurfaceInteraction> all;
  for (const float theta : {0.f, 1.f, 30.f, 55.f, 80.f, 89.5f, 91.f, 120.f, 140.f, 179.f, 180.f}) {
    all.push_back(seen_at(theta, 70));
  }
  return all;
}

TEST(Dielectric, ReflectsByFresnelAndRefractsBySnell) {
  for (const float eta : kIndices) {
    const auto bsdf = dielectric("dielectric", eta);
    EXPECT_FLOAT_EQ(bsdf->relative_index(), eta);
    for (const SurfaceInteraction& si : views()) {
      const bool outside = si.wi.z > 0;
      const double n_i = outside ? 1. : static_cast<double>(eta);
      const double n_t = outside ? static_cast<double>(eta) : 1.;
      const double expected = fresnel(std::abs(static_cast<double>(si.wi.z)), n_i, n_t);
      constexpr int kCount = 4096;
      int mirrored = 0;
      for (int i = 0; i < kCount; ++i) {
        const float u1 = (static_cast<float>(i) + 0.5f) / kCount;
        const auto sample = bsdf->sample(si, Lobe::kAll, u1, Vec2(0.3f));
        ASSERT_TRUE(sample) << eta << ", " << si.wi.z;
        EXPECT_EQ(sample->lobe, Lobe::kDelta);
        EXPECT_EQ(sample->pdf, 1);
        EXPECT_NEAR(glm::length(sample->wo), 1, 1e-5f);
        if (sample->wo.z * si.wi.z > 0) {
          ++mirrored;
          EXPECT_LT(glm::distance(sample->wo, Vec3(-si.wi.x, -si.wi.y, si.wi.z)), 1e-6f);
          EXPECT_EQ(sample->weight, Rgb(1.f));
          continue;
        }
        // Snell's law, and the change of radiance as the beam becomes narrower.
        const auto ratio = static_cast<float>(n_i / n_t);
        EXPECT_NEAR(sample->wo.x, -si.wi.x * ratio, 1e-5f);
        EXPECT_NEAR(sample->wo.y, -si.wi.y * ratio, 1e-5f);
        EXPECT_NEAR(sample->weight.x, ratio * ratio, 1e-5f * ratio * ratio);
      }
      // Tolerance: one of the evenly spaced samples, and the formula's rounding in single
      // precision.
      EXPECT_NEAR(mirrored, kCount * expected, 1.5 + 1e-3 * kCount * expected)
          << eta << ", " << si.wi.z;
    }
  }
}

/// A transmitted beam returns the same way, and both sides transmit equally.
TEST(Dielectric, TransmissionIsReversible) {
  for (const char* const type : {"dielectric", "thindielectric"}) {
    for (const float eta : kIndices) {
      const auto bsdf = dielectric(type, eta);
      for (const SurfaceInteraction& si : views()) {
        const auto there = bsdf->sample(si, Lobe::kAll, 0.999f, Vec2(0.5f));
        ASSERT_TRUE(there);
        if (there->wo.z * si.wi.z > 0) continue;
        SurfaceInteraction other = si;
        other.wi = there->wo;
        const auto back = bsdf->sample(other, Lobe::kAll, 0.999f, Vec2(0.5f));
        ASSERT_TRUE(back);
        EXPECT_LT(glm::distance(back->wo, si.wi), 1e-3f) << type << eta << ", " << si.wi.z;
        EXPECT_NEAR(there->weight.x * back->weight.x, 1, 1e-5f);
        // Power is conserved: cross-section and solid angle compensate the change of radiance.
        const float eta_of = bsdf->relative_index();
        const float cosines = std::abs(there->wo.z / si.wi.z);
        EXPECT_NEAR(there->weight.x * cosines *
                        transport::power_over_radiance(si.wi.z, there->wo.z, eta_of),
                    1, 1e-5f);
      }
    }
  }
}

TEST(ThinDielectric, SumsReflectionsBetweenItsFaces) {
  for (const float eta : kIndices) {
    const auto bsdf = dielectric("thindielectric", eta);
    EXPECT_EQ(bsdf->relative_index(), 1);
    for (const SurfaceInteraction& si : views()) {
      const double once =
          fresnel(std::abs(static_cast<double>(si.wi.z)), 1, static_cast<double>(eta));
      // R + T R T + T R R R T + …
      double expected = once, bounce = (1 - once) * (1 - once) * once;
      for (int i = 0; i < 2000; ++i, bounce *= once * once) expected += bounce;
      constexpr int kCount = 2048;
      int mirrored = 0;
      for (int i = 0; i < kCount; ++i) {
        const auto sample = bsdf->sample(si, Lobe::kAll, (static_cast<float>(i) + 0.5f) / kCount,
                                         Vec2(0.5f));
        ASSERT_TRUE(sample);
        EXPECT_EQ(sample->weight, Rgb(1.f));
        if (sample->wo.z * si.wi.z > 0) {
          ++mirrored;
        } else {
          EXPECT_EQ(sample->wo, -si.wi);
        }
      }
      if (once < 0.99) {
        EXPECT_NEAR(mirrored, kCount * expected, 1.5 + 1e-3 * kCount) << eta << ", " << si.wi.z;
      }
    }
  }
}

TEST(Null, TransmitsAllLight) {
  const auto bsdf = make<Bsdf>("<bsdf type='null'/>");
  for (const SurfaceInteraction& si : views()) {
    const auto sample = bsdf->sample(si, Lobe::kAll, 0.1f, Vec2(0.5f));
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->wo, -si.wi);
    EXPECT_EQ(sample->weight, Rgb(1.f));
    EXPECT_EQ(bsdf->eval_pdf(si, Lobe::kAll, -si.wi).pdf, 0);
  }
}

TEST(Dielectric, ColoursReflectedAndTransmittedLight) {
  const auto bsdf = make<Bsdf>(
      "<bsdf type='dielectric'><rgb name='specular_reflectance' value='0.1 0.2 0.3'/>"
      "<rgb name='specular_transmittance' value='0.4 0.5 0.6'/></bsdf>");
  const SurfaceInteraction si = seen_at(40, 10);
  const float eta = bsdf->relative_index();
  EXPECT_EQ(bsdf->sample(si, Lobe::kAll, 0, Vec2(0.5f))->weight, Rgb(0.1f, 0.2f, 0.3f));
  const Rgb through = bsdf->sample(si, Lobe::kAll, 0.9f, Vec2(0.5f))->weight * (eta * eta);
  EXPECT_LT(glm::distance(through, Rgb(0.4f, 0.5f, 0.6f)), 1e-6f);
}

TEST(Dielectric, IsRefusedInBsdfsThatOnlyReflect) {
  for (const char* const type : {"dielectric", "thindielectric", "null"}) {
    const std::string nested = "<bsdf type='" + std::string(type) + "'/>";
    EXPECT_TRUE(make<Bsdf>(nested)->transmits());
    EXPECT_THROW(make<Bsdf>("<bsdf type='twosided'>" + nested + "</bsdf>"), Error);
    EXPECT_THROW(make<Bsdf>("<bsdf type='normalmap'>" KINOME_TEST_NORMAL("0.5 0.5 1") + nested +
                            "</bsdf>"),
                 Error);
  }
  EXPECT_FALSE(make<Bsdf>("<bsdf type='conductor'/>")->transmits());
}

TEST(Dielectric, RefusesInvalidIndices) {
  for (const char* const value : {"0", "-1", "1e9", "nan"}) {
    EXPECT_THROW(make<Bsdf>("<bsdf type='dielectric'><float name='int_ior' value='" +
                            std::string(value) + "'/></bsdf>"),
                 Error)
        << value;
  }
}

}  // namespace
}  // namespace kinome::test::dielectric_test
