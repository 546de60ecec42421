/// Compares null_transmission() with samples, and its block version with single points.
#include <gtest/gtest.h>

#include "kit/scenes/bsdf_points.h"
#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"
#include "support/plugin_sets.h"

namespace kinome::test::null_transmission_test {
namespace {

const std::string kPane =
    "<bsdf type='thindielectric'><rgb name='specular_transmittance' value='0.9 0.5 0.2'/></bsdf>";
const std::string kTexture =
    "<texture type='checkerboard' name='NAME'><float name='color0' value='0.3'/><float "
    "name='color1' value='1'/><transform name='to_uv'><scale value='3'/></transform></texture>";

std::string textured(const std::string& type, const std::string& parameter,
                     const std::string& nested) {
  std::string texture = kTexture;
  texture.replace(texture.find("NAME"), 4, parameter);
  return "<bsdf type='" + type + "'>" + texture + nested + "</bsdf>";
}

std::vector<std::string> bsdfs() {
  const std::string diffuse = "<bsdf type='diffuse'/>";
  const std::string mask = textured("mask", "opacity", diffuse);
  return {
      "<bsdf type='null'/>",
      kPane,
      mask,
      textured("mask", "opacity", kPane),
      textured("mask", "opacity", mask),
      textured("blendbsdf", "weight", kPane + diffuse),
      textured("blendbsdf", "weight", mask + "<bsdf type='null'/>"),
      "<bsdf type='twosided'><boolean name='allow_transmission' value='true'/>" + mask + kPane +
          "</bsdf>",
  };
}

std::vector<SurfaceInteraction> points(size_t count) {
  RandomDirections random(5);
  std::vector<SurfaceInteraction> result;
  for (size_t i = 0; i < count; ++i) {
    result.push_back(check::seen_from(random.sphere()));
    result.back().uv = random.unit2();
  }
  return result;
}

/// Returns the mean weight and share of samples with Lobe::kNull, by the midpoint rule over u1.
NullTransmission sampled(const Bsdf& bsdf, const SurfaceInteraction& si) {
  constexpr int kSteps = 4096;
  NullTransmission sum;
  for (int k = 0; k < kSteps; ++k) {
    const float u1 = (static_cast<float>(k) + 0.5f) / kSteps;
    const auto sample = bsdf.sample(si, Lobe::kAll, u1, Vec2(0.3f, 0.6f));
    if (!sample || !any(sample->lobe & Lobe::kNull)) continue;
    EXPECT_LT(glm::length(sample->wo + si.wi), 1e-5f);
    sum.transmittance += sample->weight / static_cast<float>(kSteps);
    sum.probability += 1.f / kSteps;
  }
  return sum;
}

TEST(NullTransmission, IsTheMeanOfSamples) {
  constexpr float kMaxError = 1e-3f;  // at most three intervals of u1 in 4096 steps
  for (const std::string& xml : bsdfs()) {
    const auto bsdf = make<Bsdf>(xml);
    EXPECT_TRUE(bsdf->has_null_lobe()) << xml;
    for (const SurfaceInteraction& si : points(50)) {
      const NullTransmission expected = sampled(*bsdf, si), stated = bsdf->null_transmission(si);
      EXPECT_LT(max_component(glm::abs(stated.transmittance - expected.transmittance)), kMaxError)
          << xml;
      EXPECT_NEAR(stated.probability, expected.probability, kMaxError) << xml;
    }
  }
}

TEST(NullTransmission, OfBlocksEqualsThatOfPoints) {
  const auto all = points(101);
  std::vector<BsdfQuestion> questions;
  for (const SurfaceInteraction& si : all) {
    questions.push_back({});
    questions.back().si = si;
  }
  for (const std::string& xml : bsdfs()) {
    for (const InstructionSet set : instruction_sets()) {
      const auto bsdf = make_for<Bsdf>(set, xml);
      BsdfBlock block(questions);
      const NullTransmissionBlock out{block.answer.f, block.answer.pdf};
      bsdf->null_transmission_block(block.points, out);
      EXPECT_FALSE(block.is_overrun());
      for (size_t i = 0; i < all.size(); ++i) {
        const NullTransmission point = bsdf->null_transmission(all[i]);
        EXPECT_LT(max_component(glm::abs(out.transmittance.at(i) - point.transmittance)), 1e-6f)
            << xml << i;
        EXPECT_NEAR(out.probability[i], point.probability, 1e-6f) << xml << i;
      }
    }
  }
}

TEST(NullTransmission, IsThereOnlyWhereLightPassesStraight) {
  for (const char* xml :
       {"<bsdf type='diffuse'/>", "<bsdf type='dielectric'/>",
        "<bsdf type='twosided'><bsdf type='plastic'/></bsdf>", "<bsdf type='principledthin'/>"}) {
    const auto bsdf = make<Bsdf>(xml);
    EXPECT_FALSE(bsdf->has_null_lobe()) << xml;
    EXPECT_EQ(bsdf->null_transmission(check::seen_at(20, 30)).probability, 0) << xml;
  }
}

}  // namespace
}  // namespace kinome::test::null_transmission_test
