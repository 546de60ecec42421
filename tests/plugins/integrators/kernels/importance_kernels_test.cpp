// Compares kernels that estimate the importance of cells and light points with plain code in double
// precision.
#include "clustered/kernels/importance_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "kernel_helpers.h"

namespace kinome::test::importance_kernels_test {
namespace {

glm::dvec3 vector_of(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}
double ggx(double cosine, double alpha2) {
  const double t = 1 + (alpha2 - 1) * cosine * cosine;
  return alpha2 / (std::numbers::pi * t * t);
}

/// The estimates of importance_kernels.cpp in double precision.
struct PlainResponse {
  double fraction = 0, density = 0;
};
PlainResponse plain_response(const simd::ReflectingPatch& patch, const glm::dvec3& d,
                             double arriving, double spread2) {
  const double by_cosine = std::clamp(arriving, 0., 1.) / std::numbers::pi;
  if (!(patch.glossy > 0)) return {patch.diffuse * by_cosine, by_cosine};
  const glm::dvec3 sum = d + vector_of(patch.viewer);
  const double cosine = glm::dot(sum, vector_of(patch.normal)) / glm::length(sum);
  const double lobe = cosine > 0 ? ggx(cosine, std::min(1., patch.alpha2 + spread2 / 4)) / 4 : 0;
  const double share = patch.diffuse_share, glossy = arriving > 0 ? lobe + 0.05 : 0;
  return {patch.diffuse * by_cosine + patch.glossy * glossy,
          share * by_cosine + (1 - share) * lobe};
}

/// Returns the importance of light of unit flux, without the share that eye rays find.
double plain_importance(const simd::ReflectingPatch& patch, const glm::dvec3& to,
                        const glm::dvec3& normal, double size2, double eye_ratio) {
  const double squared = glm::dot(to, to), softened = squared + size2;
  const glm::dvec3 d = to / std::sqrt(squared);
  const double spread = std::sqrt(size2 / softened);
  const double leaving = 1 - glm::length(normal) - glm::dot(normal, d) + spread;
  const double arriving = glm::dot(d, vector_of(patch.normal)) + spread + 0.05;
  const PlainResponse response = plain_response(patch, d, arriving, size2 / softened);
  const double geometry = std::clamp(leaving, 0., 1.) / softened;
  return response.fraction * geometry /
         (1 + patch.eye_rays * response.density * geometry * eye_ratio);
}

double plain_sent(const simd::SentLobe& lobe, const glm::dvec3& d, double spread2) {
  constexpr double kFloor = 0.02;
  const glm::dvec3 n = vector_of(lobe.normal), light = vector_of(lobe.light), sum = light + d;
  const double in = std::max(glm::dot(n, light), kFloor), out = std::max(glm::dot(n, d), kFloor);
  const double a2 = std::min(1., lobe.alpha2 + spread2 / 4);
  const auto root = [&](double c) { return std::sqrt(a2 + (1 - a2) * c * c); };
  const double fresnel =
      std::lerp(static_cast<double>(lobe.glossy), 1., std::pow(1 - glm::length(sum) / 2, 5));
  const double gloss = ggx(glm::dot(n, sum) / glm::length(sum), a2) * fresnel * 0.5 /
                       (out * root(in) + in * root(out));
  return in * ((lobe.diffuse + lobe.glossy * kFloor) / std::numbers::pi + gloss);
}

TEST(ImportanceKernels, EstimateAsPlainCodeDoes) {
  constexpr size_t kCount = 64, kCells = 10;
  Random random(6);
  std::vector<float> position[3], normal[3], spread2(kCount), flux(kCount), of_cells(kCount),
      of_points(kCount), visibility(kCount), eye_ratio(kCount);
  std::vector<uint32_t> cell(kCount);
  for (int k = 0; k < 3; ++k) position[k].resize(kCount), normal[k].resize(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const Vec3 n = random.direction() * (i % 2 ? 1.f : random.unit());
    for (int k = 0; k < 3; ++k) {
      position[k][i] = static_cast<float>(random.between(-2, 2));
      normal[k][i] = n[k];
    }
    spread2[i] = random.unit();
    flux[i] = random.unit();
    eye_ratio[i] = random.unit();
    visibility[i] = 0.1f + random.unit();
    cell[i] = static_cast<uint32_t>(random.between(0, kCells));
  }
  for (const float glossy : {0.f, 0.4f}) {
    const Vec3 n = random.direction(), w = glm::normalize(n + 0.5f * random.direction());
    const simd::ReflectingPatch patch{{0.1f, -0.2f, 0.3f}, {n.x, n.y, n.z}, {w.x, w.y, w.z}, 0.3f,
                                      glossy,              0.02f,           0.7f,            0.6f};
    constexpr float kSize2 = 0.04f;
    simd::cell_importance(patch,
                          {{position[0].data(), position[1].data(), position[2].data()},
                           {normal[0].data(), normal[1].data(), normal[2].data()},
                           spread2.data(),
                           flux.data()},
                          visibility.data(), kCount, of_cells.data());
    simd::point_importance(patch, kSize2,
                           {{position[0].data(), position[1].data(), position[2].data()},
                            {normal[0].data(), normal[1].data(), normal[2].data()},
                            flux.data(),
                            eye_ratio.data(),
                            cell.data()},
                           visibility.data(), kCount, of_points.data());
    for (size_t i = 0; i < kCount; ++i) {
      const glm::dvec3 at(position[0][i], position[1][i], position[2][i]);
      const glm::dvec3 to = at - vector_of(patch.position);
      const glm::dvec3 facing(normal[0][i], normal[1][i], normal[2][i]);
      const double by_cell =
          plain_importance(patch, to, facing, spread2[i], 0) * flux[i] * visibility[i];
      const double by_point = plain_importance(patch, to, facing, kSize2, eye_ratio[i]) * flux[i] *
                              visibility[cell[i]];
      EXPECT_NEAR(of_cells[i], by_cell, 1e-4 * by_cell + 1e-6);
      EXPECT_NEAR(of_points[i], by_point, 1e-4 * by_point + 1e-6);
      const glm::dvec3 d = glm::normalize(to);
      const Vec3 single(d);
      const double fraction = plain_response(patch, d, 0.5, 0).fraction;
      EXPECT_NEAR(simd::reflected_fraction(patch, &single.x, 0.5f, 0), fraction, 1e-4 * fraction);
    }
  }
}

TEST(ImportanceKernels, SendByLobesAsPlainCodeDoes) {
  constexpr size_t kCount = 48;
  Random random(7);
  std::vector<float> columns[12], fraction(kCount);
  std::vector<simd::SentLobe> lobes(kCount);
  for (auto& column : columns) column.resize(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    simd::SentLobe& lobe = lobes[i];
    const Vec3 n = random.direction(), light = glm::normalize(n + 0.7f * random.direction());
    for (int k = 0; k < 3; ++k) {
      columns[k][i] = static_cast<float>(random.between(-1, 1));
      columns[3 + k][i] = lobe.normal[k] = n[k];
      columns[6 + k][i] = lobe.light[k] = light[k];
    }
    columns[9][i] = lobe.alpha2 = static_cast<float>(random.between(0.001, 0.5));
    columns[10][i] = lobe.diffuse = random.unit();
    columns[11][i] = lobe.glossy = random.unit();
  }
  constexpr float kSize2 = 0.01f;
  const simd::ReflectingPatch patch{{0.3f, 0.2f, 2}, {0, 0, 1}, {0, 0, 1}, 1, 0, 1, 0, 1};
  const auto column = [&](size_t k) { return columns[k].data(); };
  simd::sent_to_patch(patch, kSize2,
                      {{column(0), column(1), column(2)},
                       {column(3), column(4), column(5)},
                       {column(6), column(7), column(8)},
                       column(9),
                       column(10),
                       column(11)},
                      kCount, fraction.data());
  for (size_t i = 0; i < kCount; ++i) {
    const glm::dvec3 to =
        vector_of(patch.position) - glm::dvec3(columns[0][i], columns[1][i], columns[2][i]);
    const double squared = glm::dot(to, to);
    const glm::dvec3 d = to / std::sqrt(squared);
    const double expected = plain_sent(lobes[i], d, kSize2 / (squared + kSize2));
    EXPECT_NEAR(fraction[i], expected, 1e-4 * expected);
    const Vec3 single(d);
    const double alone = plain_sent(lobes[i], d, 0);
    EXPECT_NEAR(simd::sent_fraction(lobes[i], &single.x, 0), alone, 2e-4 * alone);
  }
}

TEST(ImportanceKernels, WeightsSumToOne) {
  std::vector<float> values(32), sums(32, 1.f);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  simd::add_normalized(values.data(), values.size(), sums.data());
  double sum = 0;
  for (const float v : sums) sum += v;
  EXPECT_NEAR(sum, 33, 1e-4);
  EXPECT_FLOAT_EQ(sums[31], 1 + 31 / 496.f);
  const std::vector<float> before = sums;
  const std::vector<float> zeros(32), endless(32, std::numeric_limits<float>::infinity());
  simd::add_normalized(zeros.data(), zeros.size(), sums.data());
  simd::add_normalized(endless.data(), endless.size(), sums.data());
  EXPECT_EQ(sums, before);
}

}  // namespace
}  // namespace kinome::test::importance_kernels_test
