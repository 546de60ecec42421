#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <regex>

#include "support/bsdf_cases.h"

/// Compares BSDFs with Mitsuba 3.9.1. BSDFs that it lacks (phong, ward) are compared with their
/// formulas in double precision.
namespace kinome::test::bsdf_reference_test {
namespace {

struct ReferenceValue {
  int bsdf;
  float wi_x, wi_y, wi_z, wo_x, wo_y, wo_z;
  float r, g, b, pdf;
};

#include "bsdf_reference.inc"

struct Tolerance {
  float f;
  float pdf;
};

/// Relative tolerance. Floats that went through other operations differ by about 1e-5 at these
/// roughnesses. Larger differences:
/// - The table of rough plastic's transmittance uses another quadrature. Mitsuba's, with 32
///   nodes for GGX, is off by up to 5e-4, and the lobe probability magnifies that at grazing
///   angles.
/// - Mitsuba's density for Beckmann's visible normals uses an approximate G1, off by up to .35 %.
Tolerance tolerance(const std::string& xml) {
  const bool ggx = xml.find("ggx") != std::string::npos;
  const bool visible = xml.find("sample_visible") == std::string::npos;
  if (xml.find("roughplastic") != std::string::npos) {
    return ggx ? Tolerance{2e-3f, 5e-3f} : Tolerance{2e-4f, 4e-3f};
  }
  const bool rough = xml.find("rough") != std::string::npos;
  // Mitsuba's Bessel function is a truncated series, up to .55 % too small.
  if (xml.find("hair") != std::string::npos) return {6e-3f, 6e-3f};
  // Bump maps compute slopes of a texture from differences of heights.
  if (xml.find("bumpmap") != std::string::npos) return {3e-4f, rough && !ggx ? 4e-3f : 3e-4f};
  return {5e-5f, rough && !ggx && visible ? 4e-3f : 5e-5f};
}

TEST(BsdfReference, MatchesMitsuba) {
  std::map<int, std::shared_ptr<Bsdf>> bsdfs;
  for (const ReferenceValue& v : kReferenceValues) {
    const std::string xml =
        std::regex_replace(kReferenceBsdfs[v.bsdf], std::regex(R"(\{source\})"), KINOME_TEST_SOURCE);
    auto& bsdf = bsdfs[v.bsdf];
    if (!bsdf) bsdf = make<Bsdf>(xml);
    SurfaceInteraction si = seen_at(0, 0);
    si.wi = Vec3(v.wi_x, v.wi_y, v.wi_z);
    const BsdfValue got = bsdf->eval_pdf(si, Lobe::kAll, Vec3(v.wo_x, v.wo_y, v.wo_z));
    const Tolerance t = tolerance(xml);
    const Rgb wanted(v.r, v.g, v.b);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(got.f[c], wanted[c], t.f * wanted[c] + 1e-9f)
          << xml << " wi " << v.wi_x << ' ' << v.wi_y << ' ' << v.wi_z;
    }
    EXPECT_NEAR(got.pdf, v.pdf, t.pdf * v.pdf + 1e-9f) << xml;
  }
  EXPECT_EQ(bsdfs.size(), std::size(kReferenceBsdfs));
}

TEST(BsdfReference, PhongFollowsItsFormula) {
  constexpr double kPiD = std::numbers::pi;
  RandomDirections random(1);
  for (const double n : {0., 1., 30., 5000.}) {
    const auto bsdf = make<Bsdf>(
        "<bsdf type='phong'><float name='diffuse_reflectance' value='.4'/>"
        "<float name='specular_reflectance' value='.1'/>"
        "<float name='exponent' value='" +
        std::to_string(n) + "'/></bsdf>");
    for (int i = 0; i < 300; ++i) {
      Vec3 wi = random.sphere();
      wi.z = std::abs(wi.z);
      Vec3 wo = random.sphere();
      if (i % 2) wo = glm::normalize(Vec3(-wi.x, -wi.y, wi.z) + 0.02f * wo);
      // Computes in double precision, from directions of exactly unit length.
      const glm::dvec3 a = glm::normalize(glm::dvec3(wi));
      const glm::dvec3 b = glm::normalize(glm::dvec3(wo));
      const double cos_alpha = glm::dot(glm::dvec3(-a.x, -a.y, a.z), b);
      const double lobe = cos_alpha > 0 ? std::pow(cos_alpha, n) : 0.;
      const double f = b.z > 0 ? (0.4 / kPiD + 0.1 * (n + 2) / (2 * kPiD) * lobe) * b.z : 0.;
      const double pdf = b.z > 0 ? 0.8 * b.z / kPiD + 0.2 * (n + 1) / (2 * kPiD) * lobe : 0.;
      const BsdfValue got = bsdf->eval_pdf(seen_from(wi), Lobe::kAll, wo);
      // Tolerance: n times the rounding of alpha², about 1e-6 of .0004.
      EXPECT_NEAR(got.f.x, f, 2e-4 * f + 1e-7);
      EXPECT_NEAR(got.pdf, pdf, 2e-4 * pdf + 1e-7);
    }
  }
}

TEST(BsdfReference, WardFollowsItsFormulas) {
  constexpr double kPiD = std::numbers::pi;
  constexpr double kAu = 0.15, kAv = 0.4;
  RandomDirections random(2);
  for (const std::string variant : {"balanced", "ward", "ward-duer"}) {
    const auto bsdf = make<Bsdf>("<bsdf type='ward'><string name='variant' value='" + variant +
                                 "'/><float name='diffuse_reflectance' value='.3'/>"
                                 "<float name='specular_reflectance' value='.6'/>"
                                 "<float name='alpha_u' value='.15'/>"
                                 "<float name='alpha_v' value='.4'/></bsdf>");
    for (int i = 0; i < 300; ++i) {
      Vec3 wi = random.sphere();
      Vec3 wo = random.sphere();
      wi.z = std::abs(wi.z);
      wo.z = std::abs(wo.z);
      const glm::dvec3 h = glm::dvec3(wi) + glm::dvec3(wo);
      const glm::dvec3 m = glm::normalize(h);
      const double e = std::exp(-(std::pow(h.x / kAu, 2) + std::pow(h.y / kAv, 2)) / (h.z * h.z));
      double c = glm::dot(h, h) / (kPiD * kAu * kAv * std::pow(h.z, 4));
      if (variant == "ward") c = 1 / (4 * kPiD * kAu * kAv * std::sqrt(double{wi.z} * wo.z));
      if (variant == "ward-duer") c = 1 / (4 * kPiD * kAu * kAv * wi.z * wo.z);
      const double f = (0.3 / kPiD + (c * e > 1e-10 ? 0.6 * c * e : 0)) * wo.z;
      const double lobe =
          e / (4 * kPiD * kAu * kAv * glm::dot(m, glm::dvec3(wi)) * std::pow(m.z, 3));
      const double pdf = wo.z / kPiD / 3 + lobe * 2 / 3;
      const BsdfValue got = bsdf->eval_pdf(seen_from(wi), Lobe::kAll, wo);
      EXPECT_NEAR(got.f.x, f, 1e-4 * f) << variant;
      EXPECT_NEAR(got.pdf, pdf, 1e-4 * pdf) << variant;
    }
  }
}

// In Mitsuba 0.6, both are scaled by .99 / max(kd + ks) if kd + ks exceeds 1 in any channel.
TEST(BsdfReference, EnergyIsConservedByScaling) {
  const std::string colors =
      "<rgb name='diffuse_reflectance' value='.9 .5 .1'/>"
      "<rgb name='specular_reflectance' value='.3 .9 .1'/>";
  for (const std::string plugin : {"phong", "ward"}) {
    const SurfaceInteraction si = seen_at(20, 0);
    const auto scaled = make<Bsdf>("<bsdf type='" + plugin + "'>" + colors + "</bsdf>");
    const float scale = 0.99f / 1.4f;
    EXPECT_NEAR(scaled->reflectance(si).diffuse.x, 0.9f * scale, 1e-6f);
    EXPECT_NEAR(scaled->reflectance(si).glossy.y, 0.9f * scale, 1e-6f);
    const auto raw =
        make<Bsdf>("<bsdf type='" + plugin + "'>" + colors +
                   "<boolean name='ensure_energy_conservation' value='false'/></bsdf>");
    EXPECT_FLOAT_EQ(raw->reflectance(si).diffuse.x, 0.9f);
    // The sums are tested by channel: .9 + .1 and .1 + .9 need no scaling.
    const auto apart = make<Bsdf>("<bsdf type='" + plugin +
                                  "'>"
                                  "<rgb name='diffuse_reflectance' value='.9 .1 .1'/>"
                                  "<rgb name='specular_reflectance' value='.1 .9 .1'/></bsdf>");
    EXPECT_FLOAT_EQ(apart->reflectance(si).diffuse.x, 0.9f);
  }
}

TEST(BsdfReference, ConductorPresetsReflectLikeTheirMetals) {
  // Reflectance of gold in red and blue at normal incidence: ((eta - 1)² + k²) / ((eta + 1)² + k²).
  const auto gold =
      make<Bsdf>("<bsdf type='conductor'><string name='material' value='Au'/></bsdf>");
  const auto s = gold->sample(seen_at(0, 0), Lobe::kAll, 0.5f, Vec2(0.5f));
  ASSERT_TRUE(s);
  const auto reflectance = [](double eta, double k) {
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
  };
  EXPECT_NEAR(s->weight.x, reflectance(0.143036, 3.983), 1e-5);
  EXPECT_NEAR(s->weight.z, reflectance(1.44205, 1.60336), 1e-5);
  const auto mirror =
      make<Bsdf>("<bsdf type='conductor'/>")->sample(seen_at(70, 0), Lobe::kAll, 0.5f, Vec2(0.5f));
  ASSERT_TRUE(mirror);
  EXPECT_NEAR(mirror->weight.x, 1, 1e-6f);
  EXPECT_LT(glm::length(mirror->wo - seen_at(70, 180).wi), 1e-6f);
}

}  // namespace
}  // namespace kinome::test::bsdf_reference_test
