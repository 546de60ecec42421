#include <gtest/gtest.h>

#include "support/bsdf_cases.h"

/// Tests at extreme parameters and directions: all values are finite, and f != 0 implies a density.
namespace kinome::test::bsdf_extremes_test {
namespace {

std::vector<BsdfCase> extreme_cases() {
  std::vector<BsdfCase> cases = bsdf_cases();
  const std::vector<BsdfCase> more{
      {"phong_0", "<bsdf type='phong'><float name='exponent' value='0'/></bsdf>"},
      {"phong_1e6", "<bsdf type='phong'><float name='exponent' value='1e6'/></bsdf>"},
      {"black_phong",
       "<bsdf type='phong'><float name='diffuse_reflectance' value='0'/>"
       "<float name='specular_reflectance' value='0'/></bsdf>"},
      {"beckmann_0", "<bsdf type='roughconductor'><float name='alpha' value='0'/></bsdf>"},
      {"beckmann_1e4",
       "<bsdf type='roughconductor'><float name='alpha_u' value='0'/>"
       "<float name='alpha_v' value='1e4'/></bsdf>"},
      {"ggx_1e4",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<float name='alpha' value='0.0001'/></bsdf>"},
      {"ggx_aniso_0",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<boolean name='sample_visible' value='false'/>"
       "<float name='alpha_u' value='0'/><float name='alpha_v' value='1'/></bsdf>"},
      {"roughplastic_0", "<bsdf type='roughplastic'><float name='alpha' value='0'/></bsdf>"},
      {"roughplastic_no_boundary",
       "<bsdf type='roughplastic'><float name='int_ior' value='1.3'/>"
       "<float name='ext_ior' value='1.3'/></bsdf>"},
      {"roughplastic_inside_out",
       "<bsdf type='roughplastic'><string name='distribution' value='ggx'/>"
       "<float name='int_ior' value='1'/><float name='ext_ior' value='2'/></bsdf>"},
      {"roughplastic_densest",
       "<bsdf type='roughplastic'><float name='int_ior' value='1000'/>"
       "<float name='ext_ior' value='0.001'/></bsdf>"},
      {"roughdielectric_0", "<bsdf type='roughdielectric'><float name='alpha' value='0'/></bsdf>"},
      {"roughdielectric_0_all",
       "<bsdf type='roughdielectric'><float name='alpha_u' value='0'/>"
       "<float name='alpha_v' value='1'/><boolean name='sample_visible' value='false'/></bsdf>"},
      {"roughdielectric_hardly_a_boundary",
       "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/>"
       "<float name='int_ior' value='1.00011'/><float name='ext_ior' value='1'/></bsdf>"},
      {"roughdielectric_densest",
       "<bsdf type='roughdielectric'><float name='int_ior' value='1000'/>"
       "<float name='ext_ior' value='0.001'/></bsdf>"},
      {"principled_0",
       "<bsdf type='principled'><float name='roughness' value='0'/>"
       "<float name='anisotropic' value='1'/><float name='spec_trans' value='0.5'/>"
       "<float name='clearcoat' value='1'/><float name='clearcoat_gloss' value='1'/></bsdf>"},
      {"principled_no_boundary",
       "<bsdf type='principled'><float name='specular' value='0'/>"
       "<float name='metallic' value='0.5'/></bsdf>"},
      {"principled_no_boundary_of_glass",
       "<bsdf type='principled'><float name='eta' value='1'/>"
       "<float name='spec_trans' value='1'/><float name='sheen' value='1'/></bsdf>"},
      {"principled_never_sampled",
       "<bsdf type='principled'><float name='main_specular_sampling_rate' value='0'/>"
       "<float name='diffuse_reflectance_sampling_rate' value='0'/></bsdf>"},
      {"principledthin_0",
       "<bsdf type='principledthin'><float name='roughness' value='0'/>"
       "<float name='spec_trans' value='1'/><float name='eta' value='1'/></bsdf>"},
      {"principledthin_through",
       "<bsdf type='principledthin'><float name='diff_trans' value='2'/></bsdf>"},
      {"hair_0",
       "<bsdf type='hair'><float name='longitudinal_roughness' value='0'/>"
       "<float name='azimuthal_roughness' value='0'/></bsdf>"},
      {"hair_1",
       "<bsdf type='hair'><float name='longitudinal_roughness' value='1'/>"
       "<float name='azimuthal_roughness' value='1'/></bsdf>"},
      {"hair_white",
       "<bsdf type='hair'><float name='eumelanin' value='0'/><float name='pheomelanin' value='0'/>"
       "</bsdf>"},
      {"hair_black",
       "<bsdf type='hair'><float name='sigma_a' value='1e30'/><float name='scale' value='1e8'/>"
       "</bsdf>"},
      {"hair_inside_out",
       "<bsdf type='hair'><float name='int_ior' value='1'/><float name='ext_ior' value='2'/>"
       "</bsdf>"},
      {"ward_0", "<bsdf type='ward'><float name='alpha' value='0'/></bsdf>"},
      {"ward_duer_0",
       "<bsdf type='ward'><string name='variant' value='ward-duer'/>"
       "<float name='alpha_u' value='0'/><float name='alpha_v' value='100'/></bsdf>"},
      {"conductor", "<bsdf type='conductor'><string name='material' value='Al'/></bsdf>"},
      {"conductor_like_outside",
       "<bsdf type='roughconductor'><float name='eta' value='1'/><float name='k' "
       "value='0'/></bsdf>"},
      {"conductor_vast",
       "<bsdf type='roughconductor'><float name='eta' value='1e30'/><float name='k' "
       "value='1e11'/></bsdf>"},
      {"normalmap_zero",
       "<bsdf type='normalmap'>" KINOME_TEST_NORMAL("0.5 0.5 0.5") "<bsdf type='phong'/></bsdf>"},
      {"normalmap_flat",
       "<bsdf type='normalmap'>" KINOME_TEST_NORMAL("1 0.5 0.5") "<bsdf type='phong'/></bsdf>"},
      {"bumpmap_cliffs", "<bsdf type='bumpmap'>" KINOME_TEST_BUMPS
                         "<float name='scale' value='1e30'/><bsdf type='phong'/></bsdf>"},
      {"normalmap_inward", "<bsdf type='normalmap'>" KINOME_TEST_NORMAL(
                               "0.5 0.5 0") "<bsdf type='twosided'>"
                                            "<bsdf type='phong'/></bsdf></bsdf>"},
  };
  cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

class BsdfExtremes : public testing::TestWithParam<BsdfCase> {};

/// Directions at, near and beyond the horizon, and along the normal.
std::vector<Vec3> extreme_directions() {
  std::vector<Vec3> directions{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {-1, 0, 0}};
  for (const float z : {1e-38f, 1e-30f, 1e-20f, 1e-10f, 1e-6f, 1e-3f, 0.5f, 1 - 1e-7f}) {
    for (const float sign : {1.f, -1.f}) {
      const float r = safe_sqrt(1 - z * z);
      directions.push_back({r * sign, 0, z});
      directions.push_back({0, r * sign, z});
      directions.push_back({0.6f * r, 0.8f * r * sign, z});
      directions.push_back({0.6f * r, 0.8f * r * sign, -z});
    }
  }
  return directions;
}

void check_value(const BsdfValue& v, const Vec3& wi, const Vec3& wo) {
  const auto where = [&] {
    return testing::Message() << "wi " << wi.x << ' ' << wi.y << ' ' << wi.z << ", wo " << wo.x
                              << ' ' << wo.y << ' ' << wo.z << ": f " << v.f.x << " pdf " << v.pdf;
  };
  EXPECT_TRUE(is_finite(v.f) && std::isfinite(v.pdf)) << where();
  EXPECT_TRUE(v.f.x >= 0 && v.f.y >= 0 && v.f.z >= 0 && v.pdf >= 0) << where();
  EXPECT_TRUE(is_black(v.f) || v.pdf > 0) << where();
  EXPECT_TRUE(std::isfinite(v.pdf * v.pdf)) << where();
}

TEST_P(BsdfExtremes, ValuesAreFinite) {
  const auto bsdf = GetParam().make();
  const auto directions = extreme_directions();
  for (const Vec3& wi : directions) {
    SurfaceInteraction si = seen_from(wi);
    si.wi = wi;  // seen_from() normalises, which would lose the smallest
    for (const Vec3& wo : directions) {
      for (const Lobe mask : masks_of(*bsdf)) check_value(bsdf->eval_pdf(si, mask, wo), wi, wo);
    }
    const LobeReflectance albedo = bsdf->reflectance(si);
    EXPECT_TRUE(is_finite(albedo.diffuse) && is_finite(albedo.glossy));
    EXPECT_TRUE(is_finite(bsdf->reflection_frame(si).n));
  }
  RandomDirections random(1);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 wi = random.sphere();
    const Vec3 wo = i % 3 ? random.sphere()
                          : glm::normalize(Vec3(-wi.x, -wi.y, wi.z) + 1e-4f * random.sphere());
    for (const Lobe mask : masks_of(*bsdf)) {
      check_value(bsdf->eval_pdf(seen_from(wi), mask, wo), wi, wo);
    }
  }
}

TEST_P(BsdfExtremes, SamplesAreFinite) {
  const auto bsdf = GetParam().make();
  const float numbers[] = {0, 1e-30f, 0x1p-24f, 0.25f, 0.5f, 0.999f, kOneMinusEpsilon};
  for (const Vec3& wi : extreme_directions()) {
    SurfaceInteraction si = seen_from(wi);
    si.wi = wi;
    for (const Lobe mask : masks_of(*bsdf)) {
      for (const float u1 : {0.f, kOneMinusEpsilon}) {
        for (const float x : numbers) {
          for (const float y : numbers) {
            const auto s = bsdf->sample(si, mask, u1, Vec2(x, y));
            if (!s) continue;
            EXPECT_TRUE(is_finite(s->wo) && std::isfinite(s->pdf) && is_finite(s->weight))
                << "wi " << wi.x << ' ' << wi.y << ' ' << wi.z << ", u " << u1 << ' ' << x << ' ' << y
                << ": wo " << s->wo.x << ' ' << s->wo.y << ' ' << s->wo.z << ", pdf " << s->pdf
                << ", weight " << s->weight.x;
            EXPECT_GT(s->pdf, 0);
            EXPECT_NEAR(glm::length(s->wo), 1, 1e-4f);
          }
        }
      }
    }
  }
}

TEST_P(BsdfExtremes, MasksSelectLobes) {
  const auto bsdf = GetParam().make();
  RandomDirections random(4);
  for (int i = 0; i < 200; ++i) {
    const SurfaceInteraction si = seen_from(random.sphere());
    const Vec3 wo = random.sphere();
    const Rgb all = bsdf->eval_pdf(si, Lobe::kAll, wo).f;
    const Rgb parts =
        bsdf->eval_pdf(si, Lobe::kDiffuse, wo).f + bsdf->eval_pdf(si, Lobe::kGlossy, wo).f;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(all[c], parts[c], 1e-5f * all[c]);
    EXPECT_TRUE(is_black(bsdf->eval_pdf(si, Lobe::kDelta, wo).f));
    const Lobe absent = static_cast<Lobe>(7u & ~static_cast<uint32_t>(bsdf->lobes()));
    EXPECT_FALSE(bsdf->sample(si, absent, random.unit(), random.unit2()));
    EXPECT_EQ(bsdf->eval_pdf(si, absent, wo).pdf, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(All, BsdfExtremes, testing::ValuesIn(extreme_cases()), case_name);

}  // namespace
}  // namespace kinome::test::bsdf_extremes_test
