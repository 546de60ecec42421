// Tests that BSDFs return the same values for blocks of points as for each point alone.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"
#include "support/plugin_sets.h"

namespace kinome::test::bsdf_block_test {
namespace {

std::vector<BsdfQuestion> random_questions(size_t count, unsigned seed) {
  RandomDirections random(seed);
  std::vector<BsdfQuestion> questions(count);
  for (size_t i = 0; i < count; ++i) {
    BsdfQuestion& q = questions[i];
    q.si.frame = Frame::from_normal(random.sphere());
    q.si.n = q.si.frame.n;
    q.si.dp_du = q.si.frame.to_world(glm::normalize(Vec3(1, random.unit(), random.unit())));
    q.si.dp_dv = glm::cross(q.si.n, q.si.dp_du);
    q.si.p = random.sphere();
    q.si.p_error = 1e-6f;
    q.si.uv = 3.f * random.unit2() - 1.f;
    q.si.wi = random.sphere();
    // Half of the directions are near the mirror direction.
    q.wo = random.sphere();
    if (i % 2) q.wo = glm::normalize(Vec3(-q.si.wi.x, -q.si.wi.y, q.si.wi.z) + 0.1f * q.wo);
    q.u1 = random.unit();
    q.u2 = random.unit2();
  }
  return questions;
}

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

/// Returns true if the values are equal. All NaN are equal.
bool same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}
bool same(const Vec3& a, const Vec3& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}
bool same(const BsdfValue& a, const BsdfValue& b) {
  return same(a.f, b.f) && same(a.pdf, b.pdf);
}
bool same(const BsdfSample& a, const BsdfSample& b) {
  return same(a.wo, b.wo) && same(a.weight, b.weight) && same(a.pdf, b.pdf) &&
         any(a.lobe & Lobe::kDelta) == any(b.lobe & Lobe::kDelta);
}

/// Permitted difference between a block and its points. Reordered or fused sums and products have
/// relative errors of some 1e-6. An exponential has the relative error that its argument has as an
/// absolute one: for exp(-25), 25 times as much. A cosine or a Fresnel reflectance that is the
/// difference of larger numbers has an absolute error of 1e-7, however small it is.
struct Bounds {
  float relative = 1e-5f;
  float absolute = 2e-7f;

  bool hold(float a, float b, float scale) const {
    return std::abs(a - b) <= relative * std::abs(b) + absolute * scale;
  }
  bool hold(const Vec3& a, const Vec3& b, float scale = 1) const {
    return hold(a.x, b.x, scale) && hold(a.y, b.y, scale) && hold(a.z, b.z, scale);
  }
  /// f has the magnitude of the density, or that of a diffuse surface.
  bool hold(const Rgb& f, float pdf, const BsdfValue& b) const {
    return hold(f, b.f, 1 + b.pdf) && hold(pdf, b.pdf, 1);
  }
};

Bounds bounds_of(const std::string& name) {
  // The coordinates of a rotated direction have errors of 1e-7, which grazing cosines and smooth
  // surfaces magnify.
  if (name.find("normalmap") != name.npos || name.find("bumpmap") != name.npos) return {1e-3f, 1e-5f};
  // At the critical angle the slope of the Fresnel reflectance is infinite, and little light is
  // transmitted.
  if (name.find("inside_out") != name.npos) return {1e-3f, 2e-7f};
  if (name.find("roughdielectric") != name.npos || name.find("principled") != name.npos) {
    return {1e-3f, 1e-5f};
  }
  return {};
}

std::string text(const Vec3& v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}
std::string text(const BsdfQuestion& q) {
  return fmt::format("wi {} wo {} u1 {} u2 {} {}", text(q.si.wi), text(q.wo), q.u1, q.u2.x, q.u2.y);
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

class BsdfBlocks : public testing::TestWithParam<std::tuple<BsdfCase, InstructionSet>> {
 protected:
  static std::shared_ptr<Bsdf> make() {
    const auto& [bsdf, set] = GetParam();
    return make_for<Bsdf>(set, bsdf.xml);
  }

  static Bounds bounds() { return bounds_of(std::get<0>(GetParam()).name); }

  static void check_values(const Bsdf& bsdf, const std::vector<BsdfQuestion>& questions) {
    BsdfBlock block(questions);
    bsdf.shade_block(block.points, block.query, block.answer);
    for (size_t i = 0; i < questions.size(); ++i) {
      const BsdfValue a = block.reply(i).value, b = reply_at(bsdf, questions[i]).value;
      EXPECT_TRUE(bounds().hold(a.f, a.pdf, b))
          << text(questions[i]) << ": f " << text(a.f) << " pdf " << a.pdf << ", the point has "
          << text(b.f) << " and " << b.pdf;
      EXPECT_TRUE(is_black(a.f) || a.pdf > 0) << text(questions[i]);
    }
  }

  /// Compares samples of a block with those of its points. In the tails, where densities are small,
  /// rounding may move a sample far away. At most a fraction `max_far` of the samples may move.
  static void check_samples(const Bsdf& bsdf, const std::vector<BsdfQuestion>& questions,
                            double max_far) {
    BsdfBlock block(questions);
    bsdf.shade_block(block.points, block.query, block.answer);
    double far = 0;
    for (size_t i = 0; i < questions.size(); ++i) {
      SCOPED_TRACE(text(questions[i]));
      const BsdfSample a = block.reply(i).sample, b = reply_at(bsdf, questions[i]).sample;
      EXPECT_TRUE(is_finite(a.wo) && std::isfinite(a.pdf) && is_finite(a.weight));
      if ((a.pdf > 0) != (b.pdf > 0)) {
        // Permitted only at the horizon, or for random numbers next to 1, which sample the tails.
        if (max_component(Vec3(questions[i].u2, 0)) > 0.9999f) {
          ++far;
        } else {
          EXPECT_LT(std::abs((a.pdf > 0 ? a : b).wo.z), 1e-4f);
        }
        continue;
      }
      EXPECT_EQ(a.lobe & Lobe::kDelta, b.lobe & Lobe::kDelta);
      if (!(a.pdf > 0)) {
        EXPECT_TRUE(a.pdf == 0 && is_black(a.weight));
        continue;
      }
      EXPECT_NEAR(glm::length(a.wo), 1, 1e-4f);
      if (any(a.lobe & Lobe::kDelta)) {
        EXPECT_TRUE(bounds().hold(a.wo, b.wo) && a.pdf == 1 && bounds().hold(a.weight, b.weight));
        continue;
      }
      far += glm::length(a.wo - b.wo) > 1e-4f;
      // Rotating wo to the nested frame and back rounds it. The error matters at the horizon of the
      // nested surface, and affects single points, too.
      if (bounds().hold(a.wo, b.wo) &&
          bounds().hold(a.weight * a.pdf, a.pdf, {b.weight * b.pdf, b.pdf})) {
        continue;
      }
      // A lobe of exponent 0 ends abruptly at 90 degrees from the mirror direction.
      const Vec3 wi = questions[i].si.wi;
      const float in_lobe = glm::dot(a.wo, Vec3(-wi.x, -wi.y, wi.z));
      if (std::get<0>(GetParam()).name == std::string("phong_0") && std::abs(in_lobe) < 1e-6f) {
        continue;
      }
      const BsdfValue v = bsdf.eval_pdf(questions[i].si, Lobe::kAll, a.wo);
      EXPECT_TRUE(bounds().hold(a.weight * a.pdf, a.pdf, v))
          << "pdf " << a.pdf << " instead of " << v.pdf << ", f " << text(a.weight * a.pdf)
          << " instead of " << text(v.f);
    }
    EXPECT_LE(far / static_cast<double>(questions.size()), max_far);
  }
};

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

TEST_P(BsdfBlocks, AnswerOnlyWhatIsAsked) {
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

TEST_P(BsdfBlocks, KeepToTheLobesThatAreAsked) {
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
      if (!form->is_turned) continue;
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

std::string block_name(const testing::TestParamInfo<BsdfBlocks::ParamType>& info) {
  return fmt::format("{}_{}", std::get<0>(info.param).name, name_of(std::get<1>(info.param)));
}
INSTANTIATE_TEST_SUITE_P(All, BsdfBlocks,
                         testing::Combine(testing::ValuesIn(block_cases()),
                                          testing::ValuesIn(instruction_sets())),
                         block_name);

}  // namespace
}  // namespace kinome::test::bsdf_block_test
