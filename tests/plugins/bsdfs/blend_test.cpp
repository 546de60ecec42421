/// Tests nested blends. Objects that are part of several blends are evaluated only once, so that
/// the time is linear in the number of blends.
#include <gtest/gtest.h>

#include "kinome/plugin_registry.h"
#include "kinome/texture.h"
#include "kinome/warp.h"
#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"

namespace kinome::test::blend_test {
namespace {

constexpr const char* kWeight =
    "<texture type='checkerboard' name='weight'><float name='color0' value='0.2'/>"
    "<float name='color1' value='0.7'/><transform name='to_uv'><scale value='3'/></transform>"
    "</texture>";

/// Numbers of calls of a BSDF's functions.
struct Calls {
  int eval_pdf = 0, sample = 0, shade_block = 0, others = 0;
};

/// Diffuse BSDF that lets part of the light through and counts calls.
class CountingBsdf final : public Bsdf {
 public:
  explicit CountingBsdf(float reflectance) : reflectance_(reflectance) {
    lobes_ = Lobe::kDiffuse | Lobe::kDelta;
    transmits_ = true;
    has_null_lobe_ = true;
  }

  BsdfValue eval_pdf(const SurfaceInteraction& si, Lobe, const Vec3& wo) const override {
    ++calls.eval_pdf;
    if (!(si.wi.z > 0 && wo.z > 0)) return {};
    return {Rgb(reflectance_ * wo.z / kPi), wo.z / kPi};
  }
  std::optional<BsdfSample> sample(const SurfaceInteraction& si, Lobe, float,
                                   const Vec2& u2) const override {
    ++calls.sample;
    if (!(si.wi.z > 0)) return std::nullopt;
    const Vec3 wo = warp::square_to_cosine_hemisphere<Vec3>(u2);
    return BsdfSample{wo, wo.z / kPi, Rgb(reflectance_), Lobe::kDiffuse};
  }
  void shade_block(const SurfaceBlock& points, const BsdfQuery& query,
                   const BsdfAnswer& answer) const override {
    ++calls.shade_block;
    const Calls before = calls;
    Bsdf::shade_block(points, query, answer);
    calls = before;  // without the calls for single points
  }
  NullTransmission null_transmission(const SurfaceInteraction&) const override {
    ++calls.others;
    return {Rgb(reflectance_), 0.5f};
  }
  LobeReflectance reflectance(const SurfaceInteraction&) const override {
    ++calls.others;
    return {Rgb(reflectance_), Rgb(0.f)};
  }
  Rgb albedo(const SurfaceInteraction&) const override {
    ++calls.others;
    return Rgb(reflectance_);
  }

  mutable Calls calls;

 private:
  float reflectance_;
};
using Leaves = std::vector<std::shared_ptr<CountingBsdf>>;

Leaves make_leaves(size_t count) {
  Leaves leaves;
  for (size_t i = 0; i < count; ++i) {
    leaves.push_back(std::make_shared<CountingBsdf>(1 / (1.f + static_cast<float>(i))));
  }
  return leaves;
}

std::shared_ptr<Bsdf> blend(const std::shared_ptr<Bsdf>& first,
                            const std::shared_ptr<Bsdf>& second) {
  const Location where{"blend.xml", 1, 1};
  Properties props(Category::kBsdf, "blendbsdf", where);
  props.set("weight", std::static_pointer_cast<Object>(make<Texture>(kWeight)), where);
  props.set("_arg_0", std::static_pointer_cast<Object>(first), where);
  props.set("_arg_1", std::static_pointer_cast<Object>(second), where);
  return std::dynamic_pointer_cast<Bsdf>(registry().create(props));
}
/// Each blend mixes the last one with a leaf of its own.
std::shared_ptr<Bsdf> chain(const Leaves& leaves) {
  std::shared_ptr<Bsdf> last = leaves.front();
  for (size_t i = 1; i < leaves.size(); ++i) last = blend(last, leaves[i]);
  return last;
}
/// Each blend mixes the two before: there are over 10^8 paths from the last one to the two leaves.
constexpr int kDepth = 40;
std::shared_ptr<Bsdf> chain_of_pairs(const Leaves& leaves) {
  std::shared_ptr<Bsdf> before = leaves[0], last = leaves[1];
  for (int i = 0; i < kDepth; ++i) {
    const auto next = blend(last, before);
    before = last;
    last = next;
  }
  return last;
}

/// Checks that each function of `bsdf` calls functions of each leaf once.
void expect_one_call(const Bsdf& bsdf, const Leaves& leaves) {
  const SurfaceInteraction si = check::seen_at(30, 40);
  const auto sum_of = [&](const auto& run) {
    for (const auto& leaf : leaves) leaf->calls = {};
    run();
    Calls sum;
    for (const auto& leaf : leaves) {
      sum.eval_pdf += leaf->calls.eval_pdf, sum.sample += leaf->calls.sample;
      sum.shade_block += leaf->calls.shade_block, sum.others += leaf->calls.others;
    }
    return sum;
  };
  const auto count = static_cast<int>(leaves.size());
  EXPECT_EQ(sum_of([&] { bsdf.eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)); }).eval_pdf, count);
  const Calls sampled = sum_of([&] { bsdf.sample(si, Lobe::kAll, 0.4f, Vec2(0.3f, 0.8f)); });
  EXPECT_EQ(sampled.sample, 1);
  EXPECT_EQ(sampled.eval_pdf, count);
  EXPECT_EQ(sum_of([&] { bsdf.null_transmission(si); }).others, count);
  EXPECT_EQ(sum_of([&] { bsdf.reflectance(si); }).others, count);
  EXPECT_EQ(sum_of([&] { bsdf.albedo(si); }).others, count);

  BsdfBlock block({{si, Vec3(0, 0, 1), 0.4f, Vec2(0.3f, 0.8f)}});
  BsdfQuery query = block.query;
  query.u1 = nullptr;
  EXPECT_EQ(sum_of([&] { bsdf.shade_block(block.points, query, block.answer); }).shade_block,
            count);
  // Samples are drawn, and the mix is evaluated for them.
  query = block.query;
  query.wo = {};
  EXPECT_EQ(sum_of([&] { bsdf.shade_block(block.points, query, block.answer); }).shade_block,
            2 * count);
}

TEST(Blend, EvaluatesEachPartOfAChainOnce) {
  const Leaves leaves = make_leaves(17);
  expect_one_call(*chain(leaves), leaves);
}

TEST(Blend, EvaluatesPartsOfSeveralBlendsOnce) {
  const Leaves leaves = make_leaves(2);
  expect_one_call(*chain_of_pairs(leaves), leaves);
}

TEST(Blend, PartsOfSeveralBlendsHaveTheSumOfTheirWeights) {
  const Leaves leaves = make_leaves(2);
  const auto bsdf = chain_of_pairs(leaves);
  const SurfaceInteraction si = check::seen_at(30, 40);
  const double weight = double{make<Texture>(kWeight)->eval_1_at(si)};
  double before = 1, last = 0.5;  // reflectances of the leaves
  for (int i = 0; i < kDepth; ++i) {
    const double next = last * (1 - weight) + before * weight;
    before = last;
    last = next;
  }
  const auto reflectance = static_cast<float>(last);
  constexpr float kRounding = 1e-5f;
  EXPECT_NEAR(bsdf->albedo(si).x, reflectance, kRounding);
  EXPECT_NEAR(bsdf->reflectance(si).diffuse.y, reflectance, kRounding);
  EXPECT_NEAR(bsdf->null_transmission(si).transmittance.z, reflectance, kRounding);
  EXPECT_NEAR(bsdf->null_transmission(si).probability, 0.5f, kRounding);
  const BsdfValue value = bsdf->eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1));
  EXPECT_NEAR(value.f.x * kPi, reflectance, kRounding);
  EXPECT_NEAR(value.pdf * kPi, 1, kRounding);
}

/// A blend of two blends that share a blend of glass and metal.
std::shared_ptr<Bsdf> shared_glass() {
  const auto metal = make<Bsdf>("<bsdf type='roughconductor'/>");
  const auto inner = blend(make<Bsdf>("<bsdf type='dielectric'/>"), metal);
  return blend(blend(inner, make<Bsdf>("<bsdf type='diffuse'/>")), blend(metal, inner));
}

/// Compares a block with single points. Returns the number of samples.
size_t compare_block(const Bsdf& bsdf, std::vector<BsdfQuestion>& questions, Lobe lobes) {
  BsdfBlock block(questions);
  block.query.lobes = lobes;
  bsdf.shade_block(block.points, block.query, block.answer);
  size_t samples = 0;
  for (size_t i = 0; i < questions.size(); ++i) {
    const BsdfQuestion& q = questions[i];
    const BsdfReply reply = block.reply(i);
    const BsdfValue value = bsdf.eval_pdf(q.si, lobes, q.wo);
    EXPECT_NEAR(reply.value.pdf, value.pdf, 1e-4f * (1 + value.pdf)) << i;
    EXPECT_NEAR(reply.value.f.x, value.f.x, 1e-4f * (1 + value.pdf)) << i;
    const auto sample = bsdf.sample(q.si, lobes, q.u1, q.u2);
    const float pdf = sample ? sample->pdf : 0.f;
    EXPECT_NEAR(reply.sample.pdf, pdf, 1e-4f * (1 + pdf)) << i;
    if (pdf == 0) continue;
    EXPECT_EQ(any(reply.sample.lobe & Lobe::kDelta), any(sample->lobe & Lobe::kDelta)) << i;
    EXPECT_NEAR(reply.sample.weight.y, sample->weight.y, 1e-3f) << i;
    ++samples;
  }
  return samples;
}

TEST(Blend, BlocksEqualPointsIfPartsAreShared) {
  const auto bsdf = shared_glass();
  RandomDirections random(3);
  std::vector<BsdfQuestion> questions(1000);
  for (BsdfQuestion& q : questions) {
    q.si = check::seen_from(random.sphere());
    q.si.uv = random.unit2();
    q.wo = random.sphere(), q.u1 = random.unit(), q.u2 = random.unit2();
  }
  for (const Lobe lobes : {Lobe::kAll, Lobe::kDelta, Lobe::kGlossy}) {
    EXPECT_GT(compare_block(*bsdf, questions, lobes), 200u);
  }
}

/// Returns the mean weight of samples of delta lobes, by the midpoint rule over u1.
float mean_delta_weight(const Bsdf& bsdf, const SurfaceInteraction& si, Lobe lobes) {
  constexpr int kSteps = 4096;
  float sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const float u1 = (static_cast<float>(k) + 0.5f) / kSteps;
    const auto sample = bsdf.sample(si, lobes, u1, Vec2(0.3f, 0.6f));
    if (sample && any(sample->lobe & Lobe::kDelta)) sum += sample->weight.x;
  }
  return sum / kSteps;
}

TEST(Blend, SharedPartsAreSampledByTheSumOfTheirWeights) {
  const SurfaceInteraction si = check::seen_at(20, 30);
  const float second = make<Texture>(kWeight)->eval_1_at(si), first = 1 - second;
  const float weight = first * first * first + second * second * first;
  const auto glass = make<Bsdf>("<bsdf type='dielectric'/>");
  for (const Lobe lobes : {Lobe::kAll, Lobe::kDelta}) {
    EXPECT_NEAR(mean_delta_weight(*shared_glass(), si, lobes),
                weight * mean_delta_weight(*glass, si, lobes), 2e-3f);
  }
}

}  // namespace
}  // namespace kinome::test::blend_test
