// Tests that BSDFs return the same values for blocks of points as for each point alone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "plugins/bsdfs/bsdf_block.h"
#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"
#include "support/plugin_sets.h"

namespace kinome::test::bsdf_block_test {
namespace {

using namespace bsdf_block;

/// Returns directions and random numbers at the ends of their ranges, in all relevant combinations.
std::vector<BsdfQuestion> extreme_questions() {
  std::vector<Vec3> directions{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {0.6f, 0.8f, 0}};
  for (const float z : {1e-38f, 1e-20f, 1e-6f, 1e-3f, 0.4f, 1 - 1e-7f}) {
    const float r = safe_sqrt(1 - z * z);
    directions.insert(directions.end(), {{r, 0, z}, {-r, 0, z}, {0.6f * r, -0.8f * r, z}});
    directions.push_back({0.6f * r, 0.8f * r, -z});
  }
  const float numbers[] = {0, 1e-30f, 0x1p-24f, 0.25f, 0.5f, 0.999f, kOneMinusEpsilon};
  std::vector<BsdfQuestion> questions;
  for (const Vec3& wi : directions) {
    size_t k = 0;
    for (const float x : numbers) {
      for (const float y : numbers) {
        BsdfQuestion q;
        q.si = seen_from(wi);
        q.si.wi = wi;
        q.wo = directions[k++ % directions.size()];
        q.u1 = k % 2 ? 0 : kOneMinusEpsilon;
        q.u2 = {x, y};
        questions.push_back(q);
      }
    }
  }
  return questions;
}

#define KINOME_TEST_CHECKERS(name, a, b)                                      \
  "<texture type='checkerboard' name='" name "'><rgb name='color0' value='" a \
  "'/><rgb name='color1' value='" b                                           \
  "'/><transform name='to_uv'><scale value='3'/></transform></texture>"

/// Returns BSDFs with textures for all parameters that permit them, and with extreme parameters.
std::vector<BsdfCase> block_cases() {
  std::vector<BsdfCase> cases = bsdf_cases();
  const std::vector<BsdfCase> more{
      {"diffuse_textured", "<bsdf type='diffuse'>" KINOME_TEST_CHECKERS(
                               "reflectance", "0.1 0.5 0.9", "0.8 0 0.2") "</bsdf>"},
      {"phong_textured",
       "<bsdf type='phong'>" KINOME_TEST_CHECKERS("diffuse_reflectance", "0.1 0.5 0.3", "0 0 0")
           KINOME_TEST_CHECKERS("specular_reflectance", "0.1 0.1 0.3", "0.2 0.6 0.2")
               KINOME_TEST_CHECKERS("exponent", "3 3 3", "200 200 200") "</bsdf>"},
      {"phong_0", "<bsdf type='phong'><float name='exponent' value='0'/></bsdf>"},
      {"black_phong",
       "<bsdf type='phong'><float name='diffuse_reflectance' value='0'/>"
       "<float name='specular_reflectance' value='0'/></bsdf>"},
      {"ward_textured",
       "<bsdf type='ward'>" KINOME_TEST_CHECKERS("diffuse_reflectance", "0.1 0.5 0.3", "0 0 0")
           KINOME_TEST_CHECKERS("alpha_u", "0.3 0.3 0.3", "0.1 0.1 0.1")
               KINOME_TEST_CHECKERS("alpha_v", "0.2 0.2 0.2", "0.5 0.5 0.5") "</bsdf>"},
      {"conductor", "<bsdf type='conductor'><string name='material' value='Al'/></bsdf>"},
      {"conductor_textured", "<bsdf type='roughconductor'>" KINOME_TEST_CHECKERS(
                                 "specular_reflectance", "1 0.5 0.3", "0.4 0.8 0.9")
                                 KINOME_TEST_CHECKERS("alpha", "0.3 0.3 0.3", "0.1 0.1 0.1")
                                     KINOME_TEST_CHECKERS("eta", "0.2 1 2", "3 1.5 0.1")
                                         KINOME_TEST_CHECKERS("k", "4 2 0", "1 3 2") "</bsdf>"},
      {"conductor_like_outside",
       "<bsdf type='roughconductor'><float name='eta' value='1'/>"
       "<float name='k' value='0'/></bsdf>"},
      {"conductor_vast",
       "<bsdf type='roughconductor'><float name='eta' value='1e30'/>"
       "<float name='k' value='1e11'/></bsdf>"},
      {"plastic_textured",
       "<bsdf type='plastic'>" KINOME_TEST_CHECKERS("diffuse_reflectance", "0.1 0.5 0.3", "1 0 1")
           KINOME_TEST_CHECKERS("specular_reflectance", "1 1 1", "0.3 0.5 0.7") "</bsdf>"},
      {"roughplastic_textured",
       "<bsdf type='roughplastic'><float name='alpha' value='0.3'/>" KINOME_TEST_CHECKERS(
           "diffuse_reflectance", "0.1 0.5 0.3", "1 0 1")
           KINOME_TEST_CHECKERS("specular_reflectance", "1 1 1", "0.3 0.5 0.7") "</bsdf>"},
      {"roughplastic_no_coat_reflection",
       "<bsdf type='roughplastic'><float name='specular_reflectance' value='0'/></bsdf>"},
      {"roughplastic_no_boundary",
       "<bsdf type='roughplastic'><float name='int_ior' value='1.3'/>"
       "<float name='ext_ior' value='1.3'/></bsdf>"},
      {"roughplastic_inside_out",
       "<bsdf type='roughplastic'><string name='distribution' value='ggx'/>"
       "<float name='int_ior' value='1'/><float name='ext_ior' value='2'/></bsdf>"},
      {"roughdielectric_textured",
       "<bsdf type='roughdielectric'>" KINOME_TEST_CHECKERS("alpha_u", "0.3 0.3 0.3", "0.1 0.1 0.1")
           KINOME_TEST_CHECKERS("alpha_v", "0.2 0.2 0.2", "0.5 0.5 0.5") KINOME_TEST_CHECKERS(
               "specular_transmittance", "0.1 0.5 0.3", "1 0 1") "</bsdf>"},
      {"principled_textured",
       "<bsdf type='principled'>" KINOME_TEST_CHECKERS("base_color", "0.1 0.5 0.3", "1 0 1")
           KINOME_TEST_CHECKERS("roughness", "0.3 0.3 0.3", "0.6 0.6 0.6")
               KINOME_TEST_CHECKERS("metallic", "0.2 0.2 0.2", "1 1 1")
                   KINOME_TEST_CHECKERS("spec_trans", "0.3 0.3 0.3", "0 0 0")
                       KINOME_TEST_CHECKERS("clearcoat", "1 1 1", "0 0 0") "</bsdf>"},
      {"principledthin_textured",
       "<bsdf type='principledthin'>" KINOME_TEST_CHECKERS("base_color", "0.1 0.5 0.3", "1 0 1")
           KINOME_TEST_CHECKERS("eta", "1.3 1.3 1.3", "0.8 0.8 0.8")
               KINOME_TEST_CHECKERS("diff_trans", "0 0 0", "2 2 2")
                   KINOME_TEST_CHECKERS("spec_trans", "0.3 0.3 0.3", "1 1 1") "</bsdf>"},
      {"hair_textured", "<bsdf type='hair'>" KINOME_TEST_CHECKERS("sigma_a", "0.1 0.5 0.3", "1 0 2")
                            "<float name='scale' value='2'/></bsdf>"},
      {"twosided_one", "<bsdf type='twosided'><bsdf type='roughplastic'/></bsdf>"},
      {"twosided_normalmap",
       "<bsdf type='twosided'><bsdf type='normalmap'>" KINOME_TEST_CHECKERS(
           "normalmap", "0.4 0.3 0.9", "0.75 0.6 0.9") "<bsdf type='roughconductor'>"
                                                       "<float name='alpha_u' value='0.2'/>"
                                                       "<float name='alpha_v' value='0.5'/>"
                                                       "</bsdf></bsdf></bsdf>"},
      {"bumpmap_mirrored_uv",
       "<bsdf type='bumpmap'><texture type='bitmap'><string name='filename' "
       "value='" KINOME_TEST_SOURCE "/tests/support/bumps.pfm'/><boolean name='raw' "
       "value='true'/><transform name='to_uv'><scale x='-2' y='1.5'/></transform></texture>"
       "<bsdf type='roughplastic'/></bsdf>"},
      {"bumpmap_flat",
       "<bsdf type='bumpmap'><texture type='checkerboard'/><bsdf type='phong'/></bsdf>"},
      {"normalmap_twosided",
       "<bsdf type='normalmap'>" KINOME_TEST_CHECKERS(
           "normalmap", "0.95 0.5 0.65", "0.5 0.5 0.5") "<bsdf type='twosided'>"
                                                        "<bsdf type='plastic'/></bsdf></bsdf>"},
  };
  cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

TEST_P(BsdfBlocks, HaveTheValuesOfPoints) {
  const auto bsdf = make();
  check_values(*bsdf, random_questions(4000, 1));
  check_values(*bsdf, extreme_questions());
}

TEST_P(BsdfBlocks, AreSampledByTheirDensity) {
  const auto bsdf = make();
  check_samples(*bsdf, random_questions(4000, 2), 1e-3);
  check_samples(*bsdf, extreme_questions(), 0.3);
}

TEST_P(BsdfBlocks, MayHaveAnyLength) {
  const auto bsdf = make();
  const auto questions = random_questions(64, 3);
  BsdfBlock whole(questions);
  bsdf->shade_block(whole.points, whole.query, whole.answer);
  for (const size_t count : {size_t(1), size_t(15), size_t(16), size_t(17), size_t(33)}) {
    // The lanes beyond `count` are NaN.
    BsdfBlock block({questions.begin(), questions.begin() + static_cast<ptrdiff_t>(count)});
    bsdf->shade_block(block.points, block.query, block.answer);
    for (size_t i = 0; i < count; ++i) {
      const BsdfReply a = block.reply(i), b = whole.reply(i);
      EXPECT_TRUE(same(a.value, b.value) && same(a.sample, b.sample)) << i << " of " << count;
    }
  }
  BsdfBlock none({});
  bsdf->shade_block(none.points, none.query, none.answer);
}

TEST_P(BsdfBlocks, ReturnOnlyTheRequestedValues) {
  const auto bsdf = make();
  const auto questions = random_questions(40, 4);
  BsdfBlock both(questions), value(questions), sample(questions);
  bsdf->shade_block(both.points, both.query, both.answer);
  value.query.u1 = nullptr;
  value.query.u2 = {};
  bsdf->shade_block(value.points, value.query, value.answer);
  sample.query.wo = {};
  bsdf->shade_block(sample.points, sample.query, sample.answer);
  for (size_t i = 0; i < questions.size(); ++i) {
    EXPECT_TRUE(same(value.reply(i).value, both.reply(i).value));
    EXPECT_TRUE(same(sample.reply(i).sample, both.reply(i).sample));
    EXPECT_TRUE(std::isnan(value.answer.sample_pdf[i]) && std::isnan(sample.answer.pdf[i]));
  }
}

TEST_P(BsdfBlocks, UseOnlyTheRequestedLobes) {
  const auto bsdf = make();
  const auto questions = random_questions(400, 6);
  for (const Lobe lobes : {Lobe::kNone, Lobe::kDiffuse, Lobe::kGlossy, Lobe::kDelta,
                           Lobe::kDiffuse | Lobe::kGlossy, Lobe::kGlossy | Lobe::kDelta}) {
    SCOPED_TRACE(static_cast<int>(lobes));
    BsdfBlock block(questions);
    block.query.lobes = lobes;
    bsdf->shade_block(block.points, block.query, block.answer);
    for (size_t i = 0; i < questions.size(); ++i) {
      const BsdfQuestion& q = questions[i];
      const BsdfReply reply = block.reply(i);
      const BsdfValue value = bsdf->eval_pdf(q.si, lobes, q.wo);
      EXPECT_TRUE(bounds().hold(reply.value.f, reply.value.pdf, value)) << text(q);
      const BsdfSample a = reply.sample;
      const BsdfSample b = bsdf->sample(q.si, lobes, q.u1, q.u2).value_or(BsdfSample{});
      if ((a.pdf > 0) != (b.pdf > 0)) {
        EXPECT_LT(std::abs((a.pdf > 0 ? a : b).wo.z), 1e-4f) << text(q);
        continue;
      }
      EXPECT_EQ(any(a.lobe & Lobe::kDelta), any(b.lobe & Lobe::kDelta)) << text(q);
      if (!(a.pdf > 0) || any(b.lobe & Lobe::kDelta)) continue;
      // If the samples differ, as in the tails, the density must still be that of the block's
      // sample.
      const BsdfValue there = bsdf->eval_pdf(q.si, lobes, a.wo);
      EXPECT_TRUE(bounds().hold(a.weight * a.pdf, a.pdf, there) ||
                  bounds().hold(a.weight * a.pdf, a.pdf, {b.weight * b.pdf, b.pdf}))
          << text(q);
    }
  }
}

std::string block_name(const testing::TestParamInfo<BsdfBlocks::ParamType>& info) {
  return fmt::format("{}_{}", std::get<0>(info.param).name, name_of(std::get<1>(info.param)));
}
INSTANTIATE_TEST_SUITE_P(All, BsdfBlocks,
                         testing::Combine(testing::ValuesIn(block_cases()),
                                          testing::ValuesIn(instruction_sets())),
                         block_name);

}  // namespace
}  // namespace kinome::test::bsdf_block_test
