#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "plugins/bsdfs/bsdf_block.h"
#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"
#include "support/plugin_sets.h"

/// Tests the forms of BSDFs at blocks of points.
namespace kinome::test::bsdf_form_block_test {
namespace {

using namespace bsdf_block;

/// Columns for the parametric forms of a block's points.
struct FormColumns {
  explicit FormColumns(size_t count) : memory(count), kind(padded(count)) {
    out.normal = memory.three(), out.tangent = memory.three();
    out.diffuse = memory.three(), out.specular = memory.three();
    out.alpha_u = memory.one(), out.alpha_v = memory.one();
    out.surface_normal = memory.three(), out.bump_alpha2 = memory.one();
    out.kind = kind.data(), out.kinds = &kinds;
  }
  BlockMemory memory;
  std::vector<uint32_t> kind;
  BsdfFormKinds kinds;
  BsdfFormBlock out;
};

/// Points are described as having no form if the block already contains too many kinds.
TEST_P(BsdfBlocks, AreDescribedByColoursWhereKindsAreTooMany) {
  const auto bsdf = make();
  const Bounds bounds = bounds_of(std::get<0>(GetParam()).name);
  constexpr size_t kCount = 17;
  const auto questions = random_questions(kCount, 9);
  BsdfBlock block(questions);
  FormColumns columns(kCount);
  for (size_t k = 0; k < BsdfFormKinds::kMaxKinds; ++k) {
    BsdfForm other;
    other.glossy = BsdfForm::Glossy::kGgx;
    other.eta = Rgb(100 + static_cast<float>(k));
    ASSERT_NE(columns.kinds.number_of(other), BsdfFormKinds::kNone);
  }
  bsdf->describe_block(block.points, columns.out);
  for (size_t i = 0; i < kCount; ++i) {
    const SurfaceInteraction& si = questions[i].si;
    if (!(glm::dot(bsdf->reflection_frame(si).n, si.frame.to_world(si.wi)) > 1e-3f)) continue;
    EXPECT_EQ(columns.out.kind[i], BsdfFormKinds::kNone);
    const LobeReflectance colours = bsdf->reflectance(si);
    EXPECT_TRUE(bounds.hold(columns.out.diffuse.at(i), colours.diffuse)) << text(questions[i]);
    EXPECT_TRUE(bounds.hold(columns.out.specular.at(i), colours.glossy)) << text(questions[i]);
  }
}

TEST_P(BsdfBlocks, AreDescribedLikeTheirPoints) {
  const auto bsdf = make();
  const Bounds bounds = bounds_of(std::get<0>(GetParam()).name);
  for (const size_t count : {0, 1, 15, 16, 17, 400}) {
    const auto questions = random_questions(count, 9);
    BsdfBlock block(questions);
    FormColumns columns(count);
    const BsdfFormBlock& out = columns.out;
    bsdf->describe_block(block.points, out);
    for (size_t i = 0; i < count; ++i) {
      const SurfaceInteraction& si = questions[i].si;
      const Frame frame = bsdf->reflection_frame(si);
      // For nearly grazing views, rounding decides on which side they are.
      if (!(glm::dot(frame.n, si.frame.to_world(si.wi)) > 1e-3f)) continue;
      EXPECT_TRUE(bounds.hold(out.normal.at(i), frame.n)) << text(questions[i]);
      EXPECT_TRUE(bounds.hold(out.tangent.at(i), frame.s)) << text(questions[i]);
      const auto form = bsdf->form(si);
      if (!form) {
        EXPECT_EQ(out.kind[i], BsdfFormKinds::kNone);
        const LobeReflectance colours = bsdf->reflectance(si);
        EXPECT_TRUE(bounds.hold(out.diffuse.at(i), colours.diffuse)) << text(questions[i]);
        EXPECT_TRUE(bounds.hold(out.specular.at(i), colours.glossy)) << text(questions[i]);
        continue;
      }
      ASSERT_NE(out.kind[i], BsdfFormKinds::kNone);
      EXPECT_TRUE(columns.kinds[out.kind[i]].same_kind(*form)) << text(questions[i]);
      EXPECT_TRUE(bounds.hold(out.diffuse.at(i), form->diffuse)) << text(questions[i]);
      if (form->glossy == BsdfForm::Glossy::kBeckmann || form->glossy == BsdfForm::Glossy::kGgx) {
        EXPECT_TRUE(bounds.hold(out.specular.at(i), form->specular)) << text(questions[i]);
        EXPECT_TRUE(bounds.hold(out.alpha_u[i], form->alpha_u, 1)) << text(questions[i]);
        EXPECT_TRUE(bounds.hold(out.alpha_v[i], form->alpha_v, 1)) << text(questions[i]);
      }
      if (!form->has_perturbed_normal) continue;
      EXPECT_TRUE(bounds.hold(out.surface_normal.at(i), form->surface_normal));
      EXPECT_TRUE(bounds.hold(out.bump_alpha2[i], form->bump_alpha2, 1)) << text(questions[i]);
    }
  }
}

TEST_P(BsdfBlocks, OfPluginsWithoutThemAreLoopsOverPoints) {
  const auto bsdf = make();
  auto questions = random_questions(100, 5);
  BsdfBlock block(questions);
  bsdf->Bsdf::shade_block(block.points, block.query, block.answer);
  for (size_t i = 0; i < questions.size(); ++i) {
    const BsdfReply a = block.reply(i), b = reply_at(*bsdf, questions[i]);
    EXPECT_TRUE(same(a.value, b.value) && same(a.sample, b.sample)) << text(questions[i]);
  }
}

}  // namespace
}  // namespace kinome::test::bsdf_form_block_test
