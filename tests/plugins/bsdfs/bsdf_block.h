#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "support/bsdf_blocks.h"
#include "support/bsdf_cases.h"
#include "support/plugin_sets.h"

/// BSDFs and points for tests of block functions, with the allowed differences.
namespace kinome::test::bsdf_block {

inline std::vector<BsdfQuestion> random_questions(size_t count, unsigned seed) {
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

/// Returns true if the values are equal. All NaN are equal.
inline bool same(float a, float b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}
inline bool same(const Vec3& a, const Vec3& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}
inline bool same(const BsdfValue& a, const BsdfValue& b) {
  return same(a.f, b.f) && same(a.pdf, b.pdf);
}
inline bool same(const BsdfSample& a, const BsdfSample& b) {
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

inline Bounds bounds_of(const std::string& name) {
  // The coordinates of a rotated direction have errors of 1e-7, which grazing cosines and smooth
  // surfaces magnify.
  if (name.find("normalmap") != name.npos || name.find("bumpmap") != name.npos)
    return {1e-3f, 1e-5f};
  // At the critical angle the slope of the Fresnel reflectance is infinite, and little light is
  // transmitted.
  if (name.find("inside_out") != name.npos) return {1e-3f, 2e-7f};
  if (name.find("roughdielectric") != name.npos || name.find("principled") != name.npos) {
    return {1e-3f, 1e-5f};
  }
  return {};
}

inline std::string text(const Vec3& v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}
inline std::string text(const BsdfQuestion& q) {
  return fmt::format("wi {} wo {} u1 {} u2 {} {}", text(q.si.wi), text(q.wo), q.u1, q.u2.x, q.u2.y);
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

}  // namespace kinome::test::bsdf_block
