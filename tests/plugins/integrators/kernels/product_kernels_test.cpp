// Compares kernels over the cells of distant light with plain code in double precision, for each
// instruction set that this machine can run.
#include <gtest/gtest.h>

#include <cmath>

#include "clustered/kernels/candidate_kernels.h"
#include "clustered/kernels/cell_kernels.h"
#include "kernel_helpers.h"

namespace kinome::test::product_kernels_test {
namespace {

constexpr double kPiD = 3.14159265358979323846;

/// Rectangles in longitude and latitude with their light, in the layout of DistantCells.
struct Cells {
  struct Rectangle {
    double phi0, phi1, theta0, theta1;
    glm::dvec3 direction(double s, double t) const {
      const double phi = phi0 + (phi1 - phi0) * s, theta = theta0 + (theta1 - theta0) * t;
      return {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
    }
  };
  std::vector<Rectangle> rectangles;
  std::vector<float> edges[8], axis[3], radius, flux, importance[3], vector_flux[9];
  std::vector<float> v, sigma, sigma_mixed, transmittance;

  Cells(size_t count, unsigned seed) {
    Random random(seed);
    const size_t length = padded(count);
    for (auto* const columns : {&radius, &flux, &v, &sigma, &sigma_mixed, &transmittance}) {
      columns->resize(length);
    }
    for (auto& c : edges) c.resize(length);
    for (auto& c : axis) c.resize(length);
    for (auto& c : importance) c.resize(length);
    for (auto& c : vector_flux) c.resize(length);
    for (size_t i = 0; i < count; ++i) {
      Rectangle r{};
      r.phi0 = random.between(0, 2 * kPiD);
      // From a fraction of a degree to half a turn, and caps around the poles.
      r.phi1 = r.phi0 + kPiD * std::pow(10, random.between(-3, 0));
      r.theta0 = i % 9 == 0 ? 0 : random.between(0, kPiD);
      r.theta1 = i % 9 == 1 ? kPiD : std::min(kPiD, r.theta0 + std::pow(10, random.between(-3, 0)));
      rectangles.push_back(r);
      const double values[8] = {std::sin(r.phi0),   std::cos(r.phi0),   std::sin(r.phi1),
                                std::cos(r.phi1),   std::cos(r.theta0), std::sin(r.theta0),
                                std::cos(r.theta1), std::sin(r.theta1)};
      for (int k = 0; k < 8; ++k) edges[k][i] = static_cast<float>(values[k]);
      const Vec3 centre(r.direction(0.5, 0.5));
      flux[i] = i % 17 == 5 ? 0.f : std::pow(10.f, 4 * random.unit() - 2);
      radius[i] = 0.3f * random.unit();
      for (int k = 0; k < 3; ++k) {
        axis[k][i] = centre[k];
        importance[k][i] = centre[k] * flux[i] * 0.9f;
        for (int c = 0; c < 3; ++c) {
          vector_flux[c * 3 + k][i] = flux[i] * (centre[k] + 0.1f * random.unit());
        }
      }
      v[i] = random.unit();
      sigma[i] = 0.01f + random.unit();
      sigma_mixed[i] = 0.1f + random.unit();
      transmittance[i] = 0.5f + random.unit();
    }
  }
  simd::CellColumns columns() const {
    simd::CellColumns c;
    c.count = flux.size();
    for (int k = 0; k < 8; ++k) c.edges[k] = edges[k].data();
    for (int k = 0; k < 3; ++k) {
      c.axis[k] = axis[k].data();
      c.importance_flux[k] = importance[k].data();
    }
    for (int k = 0; k < 9; ++k) c.vector_flux[k] = vector_flux[k].data();
    c.radius = radius.data();
    c.flux = flux.data();
    return c;
  }
  std::vector<uint32_t> all_blocks() const {
    std::vector<uint32_t> blocks(flux.size() / simd::kCellLanes);
    std::iota(blocks.begin(), blocks.end(), 0u);
    return blocks;
  }
  simd::CellKnowledge knowledge() const { return {v.data(), sigma.data(), sigma_mixed.data()}; }

  struct Range {
    double low = 2, high = -2;
  };
  /// Samples densely: for at most pi x 1 rad, 48 steps miss an extreme by less than 1e-3 / 2.
  Range cosines(size_t cell, const glm::dvec3& n) const {
    constexpr int kSteps = 48;
    Range range;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        const double c =
            glm::dot(n, rectangles[cell].direction(i / double{kSteps}, j / double{kSteps}));
        range.low = std::min(range.low, c);
        range.high = std::max(range.high, c);
      }
    }
    return range;
  }
};

enum Side { kBelow, kMixed, kAbove };
std::vector<Side> sides_of(const simd::PatchCells& patch, const Cells& cells) {
  std::vector<Side> sides(cells.flux.size(), kBelow);
  for (size_t i = 0; i < patch.above + patch.mixed; ++i) {
    const uint32_t id = patch.ids()[i];
    const bool above = i < patch.above;
    const float flux = above ? patch.above_column(simd::PatchCells::kMinFlux)[i]
                             : patch.mixed_column(simd::PatchCells::kFlux)[i - patch.above];
    if (!(flux > 0)) continue;  // padding
    EXPECT_EQ(sides.at(id), kBelow) << id << " is listed twice";
    sides.at(id) = above ? kAbove : kMixed;
  }
  return sides;
}

/// Tests all sampled directions of a cell, within the rounding of floats. They are above the
/// horizon of each normal of the cone if the cell is `above`, and of none if it is `below`. All
/// other cells, and no others, are mixed.
TEST(CellKernels, SortCellsByTheirWholeRectangles) {
  const Cells cells(250, 1);
  Random random(2);
  int counts[3] = {};
  for (int trial = 0; trial < 40; ++trial) {
    Vec3 n = random.direction();
    if (trial < 6) {
      n = Vec3(0.f);
      n[trial % 3] = trial < 3 ? 1.f : -1.f;
    }
    const double sine = trial % 4 == 0 ? 0 : std::pow(10, random.between(-3, 0));
    simd::PatchCells patch;
    simd::classify_cells(cells.columns(), cells.all_blocks(), &n.x, static_cast<float>(sine),
                         cells.knowledge(), nullptr, patch);
    const auto sides = sides_of(patch, cells);
    for (size_t i = 0; i < cells.rectangles.size(); ++i) {
      if (cells.flux[i] == 0) {
        EXPECT_EQ(sides[i], kBelow);
        continue;
      }
      const Cells::Range range = cells.cosines(i, glm::dvec3(n));
      ++counts[sides[i]];
      EXPECT_TRUE(sides[i] != kAbove || range.low >= sine - 1e-5) << i << ": " << range.low;
      EXPECT_TRUE(sides[i] != kBelow || range.high <= -sine + 1e-5) << i << ": " << range.high;
      if (sides[i] == kMixed) {
        EXPECT_LE(range.low, sine + 1e-3);
        EXPECT_GE(range.high, -sine - 1e-3);
      }
    }
  }
  for (const int count : counts) EXPECT_GT(count, 500);
}

/// The cone is wider than a right angle, so that no cell is certainly above or below.
TEST(CellKernels, WidestConesKeepAllCells) {
  const Cells cells(100, 4);
  const Vec3 n(0, 1, 0);
  simd::PatchCells patch;
  simd::classify_cells(cells.columns(), cells.all_blocks(), &n.x, 2, cells.knowledge(), nullptr, patch);
  const auto sides = sides_of(patch, cells);
  for (size_t i = 0; i < cells.rectangles.size(); ++i) {
    EXPECT_EQ(sides[i], cells.flux[i] > 0 ? kMixed : kBelow);
  }
}

/// Compares weights, visibilities and control terms of strata with those in double precision.
TEST(CellKernels, DiffuseStrataMatchTheirSums) {
  const Cells cells(300, 7);
  Random random(8);
  simd::PatchCells patch;
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 mean = random.direction();
    const Vec3 n = glm::normalize(mean + 0.1f * random.direction());
    const float* const t = trial % 2 ? cells.transmittance.data() : nullptr;
    const auto factor = [&](size_t id) { return t ? static_cast<double>(t[id]) : 1.; };
    // The cone of the patch contains that of the group.
    simd::classify_cells(cells.columns(), cells.all_blocks(), &mean.x, 0.15f, cells.knowledge(), t,
                         patch);
    const simd::GroupNormal normal{{n.x, n.y, n.z}, {n.x, n.y, n.z}, 0.02f};
    const float scale = 0.3f;
    const size_t size = patch.above + patch.mixed;
    std::vector<float> p(size), sums(size / simd::kCellLanes), visibility(patch.mixed);
    float control[9], straddling[3];
    const float total = simd::diffuse_strata(patch, normal, scale, p.data(), sums.data(),
                                             visibility.data(), control, straddling);
    for (const float light : straddling) EXPECT_EQ(light, 0);
    double expected_control[9] = {}, magnitude[9] = {}, expected_total = 0;
    for (size_t i = 0; i < size; ++i) {
      const size_t id = patch.ids()[i];
      const bool listed_above = i < patch.above;
      const float lit = listed_above ? patch.above_column(simd::PatchCells::kMinFlux)[i]
                                     : patch.mixed_column(simd::PatchCells::kFlux)[i - patch.above];
      if (!(lit > 0)) {
        EXPECT_EQ(p[i], 0);
        continue;
      }
      const double flux = cells.flux[id];
      double towards = 0;
      for (int k = 0; k < 3; ++k) towards += static_cast<double>(n[k]) * cells.importance[k][id];
      const Cells::Range range = cells.cosines(id, glm::dvec3(n));
      double expected = 0, v = cells.v[id] * factor(id);
      double slack = 1e-5 * flux * scale * factor(id);
      if (listed_above || visibility[i - patch.above] > 0) {
        expected = std::max(towards, 1e-3 * flux) * cells.sigma[id];
        EXPECT_GE(range.low, 0.02 - 1e-5) << id;
        EXPECT_TRUE(listed_above || std::abs(visibility[i - patch.above] - v) < 1e-6) << id;
      } else {
        v = 0;
        const double highest = std::max(range.high, 0.02);
        if (range.high > -0.02 + 1e-3) {
          expected = std::max(towards, 0.4 * flux * highest) * cells.sigma_mixed[id];
          slack += 1e-3 * flux * scale * factor(id);  // error of the sampled extremes
          EXPECT_LE(range.low, 0.02 + 1e-3);
        } else if (range.high > -0.02 - 1e-3) {
          expected = p[i] / (scale * factor(id));  // too close to decide
        }
      }
      expected *= scale * factor(id);
      EXPECT_NEAR(p[i], expected, 1e-5 * expected + slack) << id;
      EXPECT_TRUE(range.high <= 0 || p[i] > 0) << id << ": light without a ray";
      expected_total += p[i];
      for (int k = 0; k < 9; ++k) {
        expected_control[k] += v * cells.vector_flux[k][id];
        magnitude[k] += v * std::abs(cells.vector_flux[k][id]);
      }
    }
    double blocks = 0;
    for (const float s : sums) blocks += s;
    EXPECT_NEAR(total, expected_total, 1e-5 * expected_total);
    EXPECT_NEAR(blocks, expected_total, 1e-5 * expected_total);
    for (int k = 0; k < 9; ++k) EXPECT_NEAR(control[k], expected_control[k], 1e-5 * magnitude[k]);
  }
}

/// Cells that straddle the horizon of a flat patch have the control terms of the patch.
TEST(CellKernels, FlatPatchesClassifyCellsAtTheHorizon) {
  const Cells cells(300, 9);
  Random random(10);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 n = random.direction();
    simd::PatchCells patch;
    simd::classify_cells(cells.columns(), cells.all_blocks(), &n.x, 0.01f, cells.knowledge(),
                         nullptr, patch);
    const size_t size = patch.above + patch.mixed;
    const simd::GroupNormal normal{{n.x, n.y, n.z}, {n.x, n.y, n.z}, 0.01f};
    std::vector<float> p(size), old_p(size), sums(size / simd::kCellLanes), v(patch.mixed);
    float control[9], old_control[9], straddling[3];
    simd::diffuse_strata(patch, normal, 1, old_p.data(), sums.data(), v.data(), old_control,
                         straddling);
    patch.is_flat = true;
    for (int c = simd::PatchCells::kStraddling; c <= simd::PatchCells::kStraddlingSigma; ++c) {
      float* const column = patch.mixed_column(c);
      for (size_t i = 0; i < patch.mixed; ++i) {
        const bool is_cell = patch.mixed_column(simd::PatchCells::kFlux)[i] > 0;
        column[i] = is_cell ? random.unit() : 0;
      }
    }
    simd::diffuse_strata(patch, normal, 1, p.data(), sums.data(), v.data(), control, straddling);
    double expected[3] = {};
    for (size_t i = 0; i < patch.mixed; ++i) {
      const float known = patch.mixed_column(simd::PatchCells::kVisibility)[i];
      const size_t k = patch.above + i;
      if (v[i] < 0) {
        EXPECT_EQ(v[i], -known);
        const float wanted = patch.mixed_column(simd::PatchCells::kStraddlingSigma)[i];
        EXPECT_FLOAT_EQ(p[k], std::max(wanted, 0.02f * old_p[k]));
        for (int c = 0; c < 3; ++c) {
          expected[c] += patch.mixed_column(simd::PatchCells::kStraddling + c)[i];
        }
      } else {
        EXPECT_TRUE(v[i] == 0 || v[i] == known);
        EXPECT_TRUE(p[k] == old_p[k] || known == 0) << i;
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(straddling[c], expected[c], 1e-5 * expected[c]);
    for (int k = 0; k < 9; ++k) EXPECT_EQ(control[k], old_control[k]);
    for (size_t i = 0; i < patch.above; ++i) EXPECT_EQ(p[i], old_p[i]);
  }
}

TEST(CellKernels, GlossyImportanceIsTheWidenedLobe) {
  const Cells cells(300, 11);
  Random random(12);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 n = random.direction();
    Vec3 viewer = random.direction();
    if (glm::dot(viewer, n) < 0) viewer = -viewer;
    const simd::GlossyQuery query{{n.x, n.y, n.z},
                                  {viewer.x, viewer.y, viewer.z},
                                  std::pow(10.f, -4 * random.unit()),
                                  trial % 3 ? 0.1f * random.unit() : 0.f};
    std::vector<float> importance(cells.flux.size());
    std::vector<float> sums(cells.flux.size() / simd::kCellLanes);
    const float total =
        simd::glossy_importance(cells.columns(), query, importance.data(), sums.data());
    double expected_total = 0;
    for (size_t i = 0; i < cells.flux.size(); ++i) {
      const glm::dvec3 c(cells.axis[0][i], cells.axis[1][i], cells.axis[2][i]);
      const glm::dvec3 h = glm::dvec3(viewer) + c;
      const double radius = cells.radius[i], nh = glm::dot(glm::dvec3(n), h);
      const double cosine2 = std::max(1e-4, nh * nh / std::max(glm::dot(h, h), 1e-12));
      const double a2 = std::min(1., double{query.alpha2} + query.spread + radius * radius / 8);
      const double denominator = 1 - cosine2 * (1 - a2);
      const double above = glm::dot(glm::dvec3(n), c) + radius + 2 * std::sqrt(query.spread);
      const double lobe = a2 / (denominator * denominator);
      expected_total += importance[i];
      if (cells.flux[i] == 0 || above < 1e-6) {
        EXPECT_TRUE(importance[i] == 0 || above > -1e-6);
        continue;
      }
      // 1 - cosine2 cancels: the error is 4 units of 2^-24 for a denominator of at least a2.
      EXPECT_NEAR(importance[i], cells.flux[i] * lobe,
                  cells.flux[i] * lobe * (1e-5 + 5e-7 / denominator));
    }
    EXPECT_NEAR(total, expected_total, 1e-5 * expected_total);
  }
}

/// Compares the known light of shared candidates, and their weights, with double precision.
TEST(CandidateKernels, SharedCandidatesMatchTheirSums) {
  constexpr size_t kCount = 3 * kBlockLanes, kCells = 20;
  Random random(12);
  const auto column = [&random](size_t size) {
    std::vector<float> values(size);
    for (float& v : values) v = 0.1f + random.unit();
    return values;
  };
  std::vector<std::vector<float>> f, taken, ratio, known, weight;
  for (int c = 0; c < 3; ++c) {
    f.push_back(column(kCount));
    taken.push_back(column(kCount));
    ratio.emplace_back(kCount);
    known.emplace_back(kCount);
    weight.emplace_back(kCount);
  }
  const std::vector<float> radiance = column(3 * kCount), importance = column(kCells),
                           v = column(kCells), sigma = column(kCells);
  std::vector<float> of_cell = column(kCount), of_lobe = column(kCount), visibility(kCount),
                     deviation(kCount), uncertainty(kCount), sums(kCount / simd::kLobeLanes);
  of_cell[5] = of_lobe[5] = 0;  // padding, or below a horizon
  std::vector<uint32_t> cell(kCount);
  for (size_t i = 0; i < kCount; ++i) cell[i] = static_cast<uint32_t>(i * 7 % kCells);
  const simd::CandidateQuery query{importance.data(), 0.2f, 9, 32, 1, {v.data(), sigma.data()}};
  float of_known[3];
  simd::share_candidates({{f[0].data(), f[1].data(), f[2].data()},
                          radiance.data(),
                          cell.data(),
                          of_cell.data(),
                          of_lobe.data()},
                         query, kCount,
                         {{ratio[0].data(), ratio[1].data(), ratio[2].data()},
                          {known[0].data(), known[1].data(), known[2].data()},
                          visibility.data(),
                          deviation.data()},
                         of_known);
  const float variate[3] = {0.3f, 0.2f, 0.7f};
  float control[3] = {1, 2, 3};
  simd::weigh_taken({{taken[0].data(), taken[1].data(), taken[2].data()},
                     {{ratio[0].data(), ratio[1].data(), ratio[2].data()},
                      {known[0].data(), known[1].data(), known[2].data()},
                      visibility.data(),
                      deviation.data()},
                     {weight[0].data(), weight[1].data(), weight[2].data()},
                     uncertainty.data()},
                    {2.5f, {variate[0], variate[1], variate[2]}}, kCount, control, sums.data());
  double expected_control[3] = {1, 2, 3}, expected_known[3] = {}, expected_sum = 0, sum = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const double density =
        9 * (double{of_cell[i]} * importance[cell[i]] * 0.2f) + 32 * double{of_lobe[i]};
    double mean = 0;
    for (int c = 0; c < 3; ++c) {
      const double r = density > 0 ? radiance[3 * i + c] / density : 0;
      const double k = v[cell[i]] * r * f[c][i], w = 2.5 * taken[c][i] * r;
      EXPECT_NEAR(ratio[c][i], r, 1e-5 * r);
      EXPECT_NEAR(known[c][i], k, 1e-5 * k);
      EXPECT_NEAR(weight[c][i], w, 1e-5 * w);
      expected_known[c] += k;
      expected_control[c] += v[cell[i]] * w - variate[c] * k;
      mean += w / 3;
    }
    EXPECT_NEAR(uncertainty[i], mean * sigma[cell[i]], 1e-5 * mean);
    expected_sum += mean * sigma[cell[i]];
  }
  for (const float s : sums) sum += s;
  EXPECT_NEAR(sum, expected_sum, 1e-5 * expected_sum);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(of_known[c], expected_known[c], 1e-5 * expected_known[c]);
    EXPECT_NEAR(control[c], expected_control[c], 1e-5 * (10 + std::abs(expected_control[c])));
  }
}

}  // namespace
}  // namespace kinome::test::product_kernels_test
