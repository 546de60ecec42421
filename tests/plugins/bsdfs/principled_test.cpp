/// Compares Disney's materials with Mitsuba 3.9.1, and tests their known properties.
#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "support/bsdf_cases.h"

namespace kinome::test::principled_test {
namespace {

struct PrincipledValue {
  int bsdf;
  float wi_x, wi_y, wi_z, wo_x, wo_y, wo_z;
  float r, g, b, pdf;
};

#include "principled_reference.inc"

std::string text(const Vec3& v) {
  return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z);
}

TEST(Principled, MatchesMitsuba) {
  std::map<int, std::shared_ptr<Bsdf>> bsdfs;
  int reflected = 0, through = 0;
  for (const PrincipledValue& v : kPrincipledValues) {
    auto& bsdf = bsdfs[v.bsdf];
    if (!bsdf) bsdf = make<Bsdf>(kPrincipledBsdfs[v.bsdf]);
    const Vec3 wi(v.wi_x, v.wi_y, v.wi_z), wo(v.wo_x, v.wo_y, v.wo_z);
    SurfaceInteraction si = seen_at(0, 0);
    si.wi = wi;
    const BsdfValue got = bsdf->eval_pdf(si, Lobe::kAll, wo);
    const Rgb wanted(v.r, v.g, v.b);
    // Tolerance: rounding of half vectors, magnified by the slopes of lobes with roughness .15.
    constexpr float kRelative = 1e-3f, kAbsolute = 1e-7f;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(got.f[c], wanted[c], kRelative * wanted[c] + kAbsolute)
          << kPrincipledBsdfs[v.bsdf] << " wi " << text(wi) << " wo " << text(wo);
    }
    // The density is arbitrary if nothing is reflected.
    if (!is_black(wanted)) {
      EXPECT_NEAR(got.pdf, v.pdf, kRelative * v.pdf + kAbsolute)
          << kPrincipledBsdfs[v.bsdf] << " wi " << text(wi) << " wo " << text(wo);
      ++(wi.z * wo.z > 0 ? reflected : through);
    }
  }
  EXPECT_EQ(bsdfs.size(), std::size(kPrincipledBsdfs));
  EXPECT_GT(reflected, 100);
  EXPECT_GT(through, 40);
}

BsdfValue value(const std::string& plugin, const std::string& children, const Vec3& wi,
                const Vec3& wo) {
  return make<Bsdf>("<bsdf type='" + plugin + "'>" + children + "</bsdf>")
      ->eval_pdf(seen_from(wi), Lobe::kAll, glm::normalize(wo));
}

TEST(Principled, DefaultsAreMitsubas) {
  const Vec3 wi(0.3f, -0.2f, 0.9f), wo(-0.4f, 0.5f, 0.6f);
  for (const std::string plugin : {"principled", "principledthin"}) {
    std::string all = "<float name='base_color' value='0.5'/><float name='roughness' value='0.5'/>";
    for (const char* const name :
         {"anisotropic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"}) {
      all += "<float name='" + std::string(name) + "' value='0'/>";
    }
    all += plugin == "principled" ? "<float name='specular' value='0.5'/>"
                                  : "<float name='eta' value='1.5'/>";
    const BsdfValue expected = value(plugin, all, wi, wo), got = value(plugin, "", wi, wo);
    EXPECT_GT(got.f.x, 0);
    EXPECT_EQ(got.f, expected.f);
    EXPECT_EQ(got.pdf, expected.pdf);
  }
  // `specular` is an alternative parameter for `eta`.
  const float eta = 2 / (1 - std::sqrt(0.08f * 0.3f)) - 1;
  EXPECT_NEAR(value("principled", "<float name='specular' value='0.3'/>", wi, wo).f.x,
              value("principled", "<float name='eta' value='" + std::to_string(eta) + "'/>", wi, wo)
                  .f.x,
              1e-6f);
}

TEST(Principled, ReportsTransmittedLight) {
  const auto make_with = [](const std::string& plugin, const std::string& children) {
    return make<Bsdf>("<bsdf type='" + plugin + "'>" + children + "</bsdf>");
  };
  const auto opaque = make_with("principled", "");
  EXPECT_FALSE(opaque->transmits());
  EXPECT_EQ(opaque->relative_index(), 1);
  const auto glass = make_with("principled", "<float name='spec_trans' value='1'/>"
                                             "<float name='eta' value='1.4'/>");
  EXPECT_TRUE(glass->transmits());
  EXPECT_FLOAT_EQ(glass->relative_index(), 1.4f);
  const auto metal = make_with("principled", "<float name='spec_trans' value='1'/>"
                                             "<float name='metallic' value='1'/>");
  EXPECT_FALSE(metal->transmits());
  EXPECT_EQ(metal->lobes(), Lobe::kGlossy);
  const auto leaf = make_with("principledthin", "<float name='diff_trans' value='1'/>");
  EXPECT_TRUE(leaf->transmits());
  EXPECT_EQ(leaf->relative_index(), 1);
  EXPECT_EQ(leaf->lobes(), Lobe::kDiffuse);
  // Seen from behind, the opaque material is black, so that `twosided` may replace its back.
  EXPECT_TRUE(is_black(opaque->eval_pdf(seen_at(150, 0), Lobe::kAll, seen_at(140, 0).wi).f));
  make_with("twosided", "<bsdf type='principled'/>");
  EXPECT_THROW(make_with("twosided", "<bsdf type='principledthin'><float name='spec_trans' "
                                     "value='.1'/></bsdf>"),
               Error);
}

/// A metal reflects its base colour at normal incidence, and white at grazing angles.
TEST(Principled, MetalHasTheColourOfItsBase) {
  const std::string gold = "<rgb name='base_color' value='0.9 0.6 0.2'/>"
                           "<float name='metallic' value='1'/><float name='roughness' value='0.2'/>";
  const Rgb straight = value("principled", gold, Vec3(0, 0, 1), Vec3(0, 0, 1)).f;
  EXPECT_NEAR(straight.y / straight.x, 0.6f / 0.9f, 1e-5f);
  EXPECT_NEAR(straight.z / straight.x, 0.2f / 0.9f, 1e-5f);
  const Rgb grazing = value("principled", gold, Vec3(1, 0, 0.02f), Vec3(-1, 0, 0.02f)).f;
  EXPECT_NEAR(grazing.z / grazing.x, 1, 0.1f);
}

}  // namespace
}  // namespace kinome::test::principled_test
