/// Phase functions: values of Mitsuba, moments, and PhaseBsdf.
#include <gtest/gtest.h>

#include "kinome/block_points.h"
#include "kinome/phase.h"
#include "kit/scenes/block_memory.h"
#include "kit/statistics/random.h"
#include "support/render.h"
#include "support/statistics.h"
#include "support/volume_files.h"

namespace kinome::test::phase_test {
namespace {

std::string hg(float g) {
  char text[100];
  std::snprintf(text, sizeof text, "<phase type='hg'><float name='g' value='%.9g'/></phase>",
                double{g});
  return text;
}

/// Values of Mitsuba 3.9.1 (scalar_rgb) for four directions of the light.
TEST(Phase, HasMitsubasValues) {
  const TemporaryFolder folder;
  VolFile flakes;
  flakes.x = flakes.y = flakes.z = 1, flakes.channels = 6;
  const float s[] = {.7f, .5f, .3f, .2f, -.1f, .15f};
  const std::string file = folder.write("s.vol", flakes.bytes([&](int i) { return s[i]; }));
  const std::string sggx =
      "<phase type='sggx'><volume name='S' type='gridvolume'><string name='filename' value='" +
      file + "'/></volume></phase>";
  const std::pair<std::string, std::array<float, 4>> cases[] = {
      {hg(0.5f), {0.0176839f, 0.474832f, 0.0961454f, 0.0437217f}},
      {hg(-0.9f), {15.1197f, 0.00220589f, 0.00331519f, 0.00603326f}},
      {"<phase type='rayleigh'/>", {0.119366f, 0.119256f, 0.0759649f, 0.0597057f}},
      {"<phase type='isotropic'/>", {0.0795775f, 0.0795775f, 0.0795775f, 0.0795775f}},
      {"<phase type='tabphase'><string name='values' value='0.5, 1,4 0.2'/></phase>",
       {0.0223114f, 0.00915938f, 0.130426f, 0.115461f}},
      {"<phase type='blendphase'><float name='weight' value='0.3'/>" + hg(0.8f) +
           "<phase type='rayleigh'/></phase>",
       {0.0392484f, 2.40976f, 0.0505901f, 0.0277382f}},
      {sggx, {0.0609276f, 0.0226371f, 0.05402f, 0.231707f}},
  };
  const Vec3 directions[] = {{1, 2, -.5f}, {-1, -2, .4f}, {.3f, -1, 2}, {2, -1, .2f}};
  const MediumPoint point{Vec3(.3f, .4f, .5f),
                          Frame::from_normal(glm::normalize(Vec3(1, 2, -.5f)))};
  for (const auto& [xml, values] : cases) {
    const auto phase = make<Phase>(xml);
    for (size_t i = 0; i < 4; ++i) {
      const Vec3 wo = point.frame.to_local(glm::normalize(directions[i]));
      EXPECT_NEAR(phase->eval(point, wo), values[i], 2e-4f * values[i]) << xml << " " << i;
    }
  }
  const float areas[] = {0.8017837f, 0.8103019f, 0.4258356f, 0.6860284f};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(make<Phase>(sggx)->projected_area(Vec3(0.5f), glm::normalize(directions[i])),
                areas[i], 1e-5f);
  }
}

/// The mean cosine of samples is g, also for the narrowest peaks, where Mitsuba's formula returns
/// directions that aren't of unit length.
TEST(Phase, MeanCosineOfHenyeyGreensteinIsG) {
  for (const float g :
       {0.f, 1e-7f, -1e-7f, 1e-5f, 1e-3f, -0.3f, 0.5f, 0.9f, -0.9f, 0.999f, 0.9999f, -0.9999f}) {
    const auto phase = make<Phase>(hg(g));
    constexpr int kSteps = 1 << 16;
    double sum = 0, mass = 0;
    float worst = 0;
    for (int i = 0; i < kSteps; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / kSteps;
      const PhaseSample drawn = phase->sample({}, 0.5f, Vec2(u, 0.2f));
      sum += -double{drawn.wo.z};
      mass += 1 / (double{drawn.pdf} * 4 * std::numbers::pi);
      worst = std::max(worst, std::abs(glm::length(drawn.wo) - 1));
      ASSERT_NEAR(phase->eval({}, drawn.wo), drawn.pdf, 2e-3f * drawn.pdf) << g << " " << u;
    }
    EXPECT_NEAR(sum / kSteps, g, 2e-5) << g;
    EXPECT_LT(worst, 1e-6f) << g;
    if (std::abs(g) < 0.95f) {
      EXPECT_NEAR(mass / kSteps, 1, 2e-3) << g;  // the sphere
    }
  }
}

TEST(Phase, LobesHaveTheMeanCosine) {
  for (const char* const xml :
       {"<phase type='rayleigh'/>", "<phase type='isotropic'/>",
        "<phase type='tabphase'><string name='values' value='0, 1, 2, 5'/></phase>",
        "<phase type='blendphase'><float name='weight' value='0.25'/><phase type='hg'><float "
        "name='g' value='0.8'/></phase><phase type='hg'><float name='g' value='-0.4'/></phase>"
        "</phase>"}) {
    const auto phase = make<Phase>(xml);
    double sampled = 0, stated = 0;
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const Vec2 u = (Vec2(i % kSteps, i / kSteps) + 0.5f) / static_cast<float>(kSteps);
      sampled -= double{phase->sample({}, u.y, u).wo.z} / (kSteps * kSteps);
    }
    for (const HgLobe& lobe : phase->lobes()) stated += double{lobe.g} * double{lobe.weight};
    EXPECT_NEAR(sampled, stated, 5e-3) << xml;
  }
}

/// A long table without light between two peaks.
TEST(Phase, TablesHaveTheirShape) {
  std::string values = "3";
  for (int i = 0; i < 1000; ++i) values += ", 0";
  const auto phase = make<Phase>("<phase type='tabphase'><string name='values' value='" + values +
                                 " 1'/></phase>");
  int back = 0, ahead = 0;
  for (int i = 0; i < 4000; ++i) {
    const PhaseSample drawn =
        phase->sample({}, 0.5f, Vec2((static_cast<float>(i) + 0.5f) / 4000, 0.5f));
    ASSERT_GT(drawn.pdf, 0);
    back += drawn.wo.z > 0.99f;
    ahead += drawn.wo.z < -0.99f;
  }
  EXPECT_EQ(back, 3000);
  EXPECT_EQ(ahead, 1000);
}

TEST(PhaseBsdf, IsThePhaseFunction) {
  const auto phase = make<Phase>(hg(0.6f));
  const PhaseBsdf bsdf(*phase);
  constexpr size_t kCount = 37;
  check::BlockMemory memory(kCount);
  std::vector<const Shape*> shapes(padded(kCount));
  const SurfaceBlock points = memory.surface(kCount, shapes.data());
  check::Random random(3);
  BsdfQuery query{memory.three(), memory.one(), memory.two()};
  for (size_t i = 0; i < kCount; ++i) {
    SurfaceInteraction si;
    si.frame = Frame::from_normal(random.direction());
    si.n = Vec3(0.f);
    set_point(points, i, si);
    query.wo.set(i, random.direction());
    query.u1[i] = 0.5f;
    query.u2.set(i, random.unit2());
  }
  const BsdfAnswer answer{memory.three(), memory.one(), memory.three(),
                          memory.three(), memory.one(), memory.one()};
  bsdf.shade_block(points, query, answer);
  EXPECT_FALSE(memory.is_overrun());
  for (size_t i = 0; i < kCount; ++i) {
    const SurfaceInteraction si = interaction_of(points, i);
    const BsdfValue value = bsdf.eval_pdf(si, Lobe::kAll, query.wo.at(i));
    EXPECT_NEAR(answer.pdf[i], value.pdf, 1e-4f * value.pdf);
    EXPECT_EQ(answer.f.at(i), Rgb(answer.pdf[i]));
    const auto sample = bsdf.sample(si, Lobe::kAll, query.u1[i], query.u2.at(i));
    ASSERT_TRUE(sample.has_value());
    EXPECT_LT(glm::length(answer.wo.at(i) - sample->wo), 1e-5f);
    EXPECT_EQ(answer.weight.at(i), Rgb(1.f));
    EXPECT_EQ(answer.is_delta[i], 0);
  }
  query.lobes = Lobe::kDelta;
  bsdf.shade_block(points, query, answer);
  for (size_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(answer.f.at(i), Rgb(0.f));
    EXPECT_EQ(answer.sample_pdf[i], 0);
    EXPECT_EQ(answer.weight.at(i), Rgb(0.f));
  }
}

}  // namespace
}  // namespace kinome::test::phase_test
