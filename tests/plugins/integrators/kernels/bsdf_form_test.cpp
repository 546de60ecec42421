// Tests that BsdfForm has the values of eval_pdf, and that kernels which evaluate and weight forms
// agree with plain code. Kernels are tested for each instruction set that this machine can run.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clustered/kernels/candidate_kernels.h"
#include "clustered/product/tiles/patches.h"
#include "kinome/warp.h"
#include "support/bsdf_cases.h"

namespace kinome::test::bsdf_form_test {
namespace {

class Random {
 public:
  float unit() { return static_cast<float>(rng_() >> 8) * 0x1p-24f; }
  Vec2 pair() { return {unit(), unit()}; }

 private:
  std::mt19937 rng_{7};
};

/// Returns a point whose frame differs from the world's.
SurfaceInteraction random_point(Random& random) {
  SurfaceInteraction si;
  si.frame = Frame::from_normal(square_to_uniform_sphere(random.pair()));
  si.n = si.frame.n;
  si.dp_du = si.frame.s;
  si.uv = random.pair();
  si.wi = square_to_uniform_sphere(random.pair());
  return si;
}

float transmittance(const BsdfForm& form, float cosine) {
  if (!form.transmittance) return 1;
  constexpr int kLast = BsdfForm::kTableSize - 1;
  const float x = std::min(cosine, 1.f) * kLast;
  const int i = std::min(static_cast<int>(x), kLast - 1);
  const float w = x - static_cast<float>(i);
  return (1 - w) * form.transmittance[i] + w * form.transmittance[i + 1];
}

/// Evaluates f of one direction with the kernel.
Rgb microfacet_value(const BsdfForm& form, const Frame& frame, const Vec3& viewer, const Vec3& wo,
                     bool by_point) {
  constexpr size_t kLanes = simd::kLobeLanes;
  simd::PointFrames frames;
  simd::MicrofacetPoints points;
  frames.resize(2);
  points.resize(2);
  for (size_t i = 0; i < 2; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      frames.normal[axis][i] = frame.n[axis];
      frames.tangent[axis][i] = frame.s[axis];
      frames.viewer[axis][i] = viewer[axis];
      points.specular[axis][i] = form.specular[axis];
    }
    points.alpha_u[i] = form.alpha_u;
    points.alpha_v[i] = form.alpha_v;
  }
  const simd::MicrofacetKind kind = kind_of(form);
  const simd::FirstMicrofacet first = microfacet_of(form);
  // Evaluates a group that fits into one vector, and one that doesn't.
  const std::vector<uint32_t> member(kLanes, 1), few{0, 1};
  std::vector<uint32_t> many(3 * kLanes, 0);
  many[1] = 1;
  const std::vector<float> x(kLanes, wo.x), y(kLanes, wo.y), z(kLanes, wo.z);
  std::vector<float> f[3], density(kLanes), again(kLanes);
  for (auto& v : f) v.resize(kLanes);
  const simd::HalfVectorLobe lobe{0.3f, 0.2f};
  simd::evaluate_microfacets(kind, first, by_point ? &points : nullptr, lobe,
                             {frames, few.data(), few.size()}, member.data(), x.data(), y.data(),
                             z.data(), kLanes,
                             {{f[0].data(), f[1].data(), f[2].data()}, density.data()});
  const Vec3 value(f[0][5], f[1][5], f[2][5]);
  simd::lobe_density(lobe, {frames, few.data(), few.size()}, member.data(), x.data(), y.data(),
                     z.data(), kLanes, again.data());
  EXPECT_NEAR(density[3], again[3], 1e-5f * (again[3] + 1));
  simd::evaluate_microfacets(kind, first, by_point ? &points : nullptr, lobe,
                             {frames, many.data(), many.size()}, member.data(), x.data(), y.data(),
                             z.data(), kLanes,
                             {{f[0].data(), f[1].data(), f[2].data()}, density.data()});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(f[c][5], value[c], 1e-6f * value[c]);
  if (!form.has_perturbed_normal) return value;
  simd::TurnedPoints turned;
  turned.resize(2);
  for (int axis = 0; axis < 3; ++axis) turned.normal[axis][1] = form.surface_normal[axis];
  turned.bump_alpha2[1] = form.bump_alpha2;
  float* const values[3] = {f[0].data(), f[1].data(), f[2].data()};
  simd::multiply_turned_factors(turned, {frames, few.data(), few.size()}, member.data(), x.data(),
                                y.data(), z.data(), kLanes, values);
  return {f[0][5], f[1][5], f[2][5]};
}

TEST(BsdfForm, AgreesWithEvalPdf) {
  Random random;
  size_t diffuse = 0, glossy = 0;
  for (const BsdfCase& c : bsdf_cases()) {
    SCOPED_TRACE(c.name);
    const auto bsdf = c.make();
    for (int i = 0; i < 400; ++i) {
      const SurfaceInteraction si = random_point(random);
      const Frame frame = bsdf->reflection_frame(si);
      const Vec3 viewer = si.frame.to_world(si.wi);
      if (!(glm::dot(frame.n, viewer) > 1e-3f)) continue;
      const auto form = bsdf->form(si);
      if (!form) break;
      // Half of the directions are near the mirror direction.
      const Vec3 mirrored = 2 * glm::dot(frame.n, viewer) * frame.n - viewer;
      const Vec3 any_direction = square_to_uniform_sphere(random.pair());
      const Vec3 wo = i % 2 ? any_direction : glm::normalize(mirrored + 0.1f * any_direction);
      const float cosine = glm::dot(frame.n, wo);
      if (std::abs(cosine) < 1e-3f) continue;
      const float above_surface = glm::dot(form->surface_normal, wo);
      if (form->has_perturbed_normal && std::abs(above_surface) < 1e-3f) continue;
      const float turned = form->has_perturbed_normal
                               ? wide::perturbed_normal_factor(above_surface, form->bump_alpha2)
                               : 1.f;
      const Rgb lambertian = bsdf->eval_pdf(si, Lobe::kDiffuse, si.frame.to_local(wo)).f;
      const Rgb expected =
          cosine > 0 ? form->diffuse * (transmittance(*form, cosine) * cosine * kInvPi * turned)
                     : Rgb(0.f);
      // The cosines of rounded frames have an absolute error of 2^-22.
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(lambertian[k], expected[k], 1e-6f + 3e-5f * expected[k]);
      ++diffuse;
      if (form->glossy == BsdfForm::Glossy::kNone) {
        EXPECT_FALSE(any(bsdf->lobes() & Lobe::kGlossy) &&
                     !is_black(bsdf->eval_pdf(si, Lobe::kGlossy, si.frame.to_local(wo)).f));
      }
      if (form->glossy != BsdfForm::Glossy::kBeckmann && form->glossy != BsdfForm::Glossy::kGgx) {
        continue;
      }
      const Rgb f = bsdf->eval_pdf(si, Lobe::kGlossy, si.frame.to_local(wo)).f;
      const Rgb by_kernel = microfacet_value(*form, frame, viewer, wo, i % 3 == 0);
      // The half vector's slope has an error of 2^-22. The distribution magnifies it by twice the
      // slope over alpha² in the exponent.
      const float alpha = std::min(form->alpha_u, form->alpha_v);
      const float tolerance = 1e-4f + 2e-5f / alpha;
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(by_kernel[k], f[k], tolerance * f[k] + 1e-7f);
      ++glossy;
    }
  }
  EXPECT_GT(diffuse, 2000u);
  EXPECT_GT(glossy, 1000u);
}

TEST(WeighCandidates, AgreesWithPlainCode) {
  constexpr size_t kCount = 4 * simd::kLobeLanes, kCells = 7;
  Random random;
  std::vector<float> f[3], weight[3], radiance(3 * kCount), cell_density(kCount),
      lobe_density(kCount), uncertainty(kCount), importance(kCells), v(kCells), sigma(kCells);
  std::vector<uint32_t> cell(kCount);
  for (int k = 0; k < 3; ++k) {
    f[k].resize(kCount);
    weight[k].resize(kCount);
    for (float& x : f[k]) x = random.unit();
  }
  for (float& x : radiance) x = random.unit() * 3 - 0.1f;
  for (auto* const values : {&cell_density, &lobe_density, &importance, &v, &sigma}) {
    for (float& x : *values) x = random.unit();
  }
  for (size_t i = 0; i < kCount; ++i) cell[i] = static_cast<uint32_t>(i * 5 % kCells);
  cell_density[3] = lobe_density[3] = 0;  // neither density can have drawn it
  const std::vector<float> drawn = cell_density;
  const simd::CandidateColumns columns{{{f[0].data(), f[1].data(), f[2].data()},
                                        radiance.data(),
                                        cell.data(),
                                        {weight[0].data(), weight[1].data(), weight[2].data()},
                                        uncertainty.data()},
                                       cell_density.data(),
                                       lobe_density.data()};
  const simd::CandidateQuery query{importance.data(), 0.3f, 24, 40, 5, {v.data(), sigma.data()}};
  float control[3];
  std::vector<float> blocks(kCount / simd::kLobeLanes);
  for (size_t i = 0; i < kCount; ++i) cell_density[i] = drawn[i];
  simd::weigh_candidates(columns, query, kCount, control, blocks.data());
  double expected_control[3] = {}, total = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const double from_cell = double{drawn[i]} * importance[cell[i]] * 0.3f;
    const double density = 24 * from_cell + 40 * double{lobe_density[i]};
    double mean = 0;
    for (int k = 0; k < 3; ++k) {
      const double w = density > 0 ? 5 * double{f[k][i]} * radiance[3 * i + k] / density : 0;
      EXPECT_NEAR(weight[k][i], w, 1e-5 * std::abs(w));
      expected_control[k] += w * v[cell[i]];
      mean += w / 3;
    }
    EXPECT_NEAR(cell_density[i], from_cell, 1e-6 * from_cell);
    EXPECT_NEAR(uncertainty[i], std::abs(mean) * sigma[cell[i]], 1e-5 * (1 + std::abs(mean)));
    total += std::abs(mean) * sigma[cell[i]];
  }
  double sum = 0;
  for (const float block : blocks) sum += block;
  EXPECT_NEAR(sum, total, 1e-5 * total);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(control[k], expected_control[k], 1e-5 * std::abs(expected_control[k]));
  }
}

}  // namespace
}  // namespace kinome::test::bsdf_form_test
