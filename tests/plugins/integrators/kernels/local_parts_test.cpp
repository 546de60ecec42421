// Tests parts of learned sampling under local light: cells of points, the choice of a tile, and
// kernels over light points. Kernels are compared with plain code in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "clustered/kernels/candidate_kernels.h"
#include "clustered/kernels/lobe_kernels.h"
#include "clustered/kernels/local_kernels.h"
#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/point_partition.h"
#include "kernel_helpers.h"
#include "kinome/render_context.h"
#include "support/statistics.h"

namespace kinome::test::local_parts_test {
namespace {

constexpr double kAlpha = 1e-4;  // false-alarm rate of each statistical test

OrientedPoint random_point(Random& random) {
  return {Vec3(random.unit(), 3 * random.unit(), -random.unit()), random.direction()};
}

TEST(PointPartition, GivesEachPointOneCell) {
  Random random(1);
  std::vector<OrientedPoint> points;
  std::vector<float> flux;
  for (int i = 0; i < 4000; ++i) {
    points.push_back(random_point(random));
    flux.push_back(points.back().position.x < 0.5f ? 100.f : 1.f);
  }
  const PointPartition cells(points, flux, 200);
  EXPECT_EQ(cells.size(), 200u);
  std::vector<Aabb> boxes(cells.size());
  for (const OrientedPoint& p : points) {
    ASSERT_LT(cells.cell_of(p), cells.size());
    boxes[cells.cell_of(p)].expand(p.position);
  }
  // Cells are smaller where there is more light, and none is empty.
  Moments bright, dim;
  for (const Aabb& box : boxes) {
    ASSERT_FALSE(box.empty());
    (box.hi.x <= 0.5f ? bright : dim).add(glm::length(box.extent()));
  }
  EXPECT_LT(bright.mean(), 0.7 * dim.mean());
  // Positions far from all points have a cell, too.
  for (const float far : {-1e6f, 1e6f}) {
    EXPECT_LT(cells.cell_of({Vec3(far), Vec3(0, 0, 1)}), cells.size());
  }
}

/// Threads make the same cells. Equal points, which can't be divided, are among the points.
TEST(PointPartition, IsTheSameWithThreads) {
  Random random(3);
  std::vector<OrientedPoint> points(300, random_point(random));
  while (points.size() < 3000) points.push_back(random_point(random));
  std::vector<float> flux;
  for (const OrientedPoint& p : points) flux.push_back(p.position.x < 0.1f ? 100.f : 1.f);
  RenderContext context({.threads = 3});
  for (const uint32_t count : {1u, 7u, 200u, 5000u}) {
    std::vector<uint32_t> cells;
    const PointPartition alone(points, flux, count);
    const PointPartition together(points, flux, count, &context.scheduler, &cells);
    ASSERT_EQ(together.size(), alone.size());
    ASSERT_EQ(cells.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(alone.cell_of(points[i]), cells[i]);
      ASSERT_EQ(together.cell_of(points[i]), cells[i]);
    }
  }
}

TEST(PointPartition, SeparatesSidesOfAWall) {
  Random random(2);
  std::vector<OrientedPoint> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back({Vec3(random.unit(), random.unit(), 0), Vec3(0, 0, i % 2 ? 1 : -1)});
  }
  const PointPartition cells(points, std::vector<float>(points.size(), 1.f), 64);
  std::map<uint32_t, float> side;
  for (const OrientedPoint& p : points) {
    const auto [at, is_new] = side.try_emplace(cells.cell_of(p), p.normal.z);
    EXPECT_EQ(at->second, p.normal.z);
  }
}

TEST(PointPartition, StopsWhereNothingIsLeftToDivide) {
  const std::vector<OrientedPoint> same(50, {Vec3(1, 2, 3), Vec3(0, 1, 0)});
  EXPECT_EQ(PointPartition(same, std::vector<float>(50, 1.f), 10).size(), 1u);
  EXPECT_EQ(PointPartition(same, std::vector<float>(50, 0.f), 10).size(), 1u);
  EXPECT_EQ(PointPartition({}, {}, 10).size(), 0u);
  std::vector<OrientedPoint> three = {same[0], same[0], same[0]};
  three[1].position.x = 7;
  three[2].position.y = 7;
  EXPECT_EQ(PointPartition(three, std::vector<float>(3, 0.f), 10).size(), 3u);
}

TEST(Turns, GiveEachSourceItsShare) {
  const std::vector<double> shares = {0.5, 0, 0.1, 0.003, 0.397};
  std::vector<double> ends;
  double end = 0;
  for (const double s : shares) ends.push_back(end += s);
  constexpr uint32_t kCount = 50, kRuns = 4000;
  std::vector<Moments> counts(shares.size());
  for (uint32_t run = 0; run < kRuns; ++run) {
    const Turns turns(ends, kCount, hash_words(run, 7));
    std::vector<uint32_t> of(shares.size());
    for (uint32_t i = 0; i < kCount; ++i) {
      const Turns::Turn turn = turns[i];
      ASSERT_EQ(turn.number, of[turn.source]) << "a source's points are numbered consecutively";
      ++of[turn.source];
    }
    for (size_t s = 0; s < shares.size(); ++s) {
      EXPECT_LE(std::abs(of[s] - kCount * shares[s]), 1)
          << "counts differ by at most one from the shares";
      counts[s].add(of[s]);
    }
  }
  for (size_t s = 0; s < shares.size(); ++s) {
    const double deviation = std::sqrt(counts[s].variance_of_mean());
    const double z = deviation > 0 ? (counts[s].mean() - kCount * shares[s]) / deviation
                                   : 1e9 * (counts[s].mean() - kCount * shares[s]);
    EXPECT_GT(normal_two_sided(z), kAlpha / shares.size()) << "source " << s << ": z = " << z;
  }
}

struct Columns {
  std::vector<float> values[13];
  explicit Columns(size_t count) {
    for (auto& v : values) v.resize(count);
  }
  simd::LightPointColumns view() const {
    const auto three = [&](int first, const float* out[3]) {
      for (int k = 0; k < 3; ++k) out[k] = values[first + k].data();
    };
    simd::LightPointColumns columns;
    three(0, columns.position);
    three(3, columns.normal);
    three(6, columns.geometric);
    three(9, columns.power);
    columns.eye_ratio = values[12].data();
    return columns;
  }
  Vec3 vector(int first, size_t i) const {
    return {values[first][i], values[first + 1][i], values[first + 2][i]};
  }
};

TEST(LocalKernels, GatherPointsThatWerePicked) {
  constexpr size_t kRows = 100, kPicks = 48;
  Random random(5);
  std::vector<simd::LightPointRow> rows(kRows);
  const auto number = [&](const simd::LightPointRow& row, size_t k) {
    const float(*const threes[])[3] = {&row.position, &row.normal, &row.geometric, &row.power};
    return k == 12 ? row.eye_ratio : (*threes[k / 3])[k % 3];
  };
  for (simd::LightPointRow& row : rows) {
    for (auto* const three : {&row.position, &row.normal, &row.geometric, &row.power}) {
      for (float& value : *three) value = random.unit();
    }
    row.eye_ratio = random.unit();
  }
  std::vector<uint32_t> picks(kPicks);
  std::vector<float> weights(kPicks), eye_weights(kPicks);
  for (size_t i = 0; i < kPicks; ++i) {
    picks[i] = static_cast<uint32_t>(random.unit() * kRows);
    weights[i] = i % 5 == 0 ? 0.f : random.unit();
    eye_weights[i] = random.unit();
  }
  Columns columns(kPicks);
  float* out[simd::kLightPointNumbers];
  for (size_t k = 0; k < simd::kLightPointNumbers; ++k) out[k] = columns.values[k].data();
  simd::gather_points(rows.data(), {picks.data(), weights.data(), eye_weights.data()}, kPicks, out);
  for (size_t i = 0; i < kPicks; ++i) {
    for (size_t k = 0; k < simd::kLightPointNumbers; ++k) {
      const float factor = k < 9 ? 1.f : k < 12 ? weights[i] : eye_weights[i];
      EXPECT_EQ(columns.values[k][i], number(rows[picks[i]], k) * factor)
          << "number " << k << " of pick " << i;
    }
  }
}

TEST(LocalKernels, ConnectPointsAsPlainCodeDoes) {
  constexpr size_t kCount = 64;
  Random random(3);
  Columns points(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const Vec3 normal = random.direction();
    const Vec3 geometric = glm::normalize(normal + 0.3f * random.direction());
    for (int k = 0; k < 3; ++k) {
      points.values[k][i] = static_cast<float>(random.between(-2, 2));
      points.values[3 + k][i] = normal[k];
      points.values[6 + k][i] = geometric[k];
      points.values[9 + k][i] = static_cast<float>(random.between(0, 5));
    }
    points.values[12][i] = random.unit();
  }
  const Vec3 from(0.1f, 0.2f, -0.3f), plane = random.direction();
  // One point is in the plane of the surface, and one is at the shading point itself. Neither may
  // contribute.
  const Vec3 in_plane = from + 0.5f * Frame::from_normal(plane).s;
  for (int k = 0; k < 3; ++k) {
    points.values[k][5] = in_plane[k];
    points.values[k][9] = from[k];
  }
  std::vector<float> x(kCount), y(kCount), z(kCount), distance(kCount), light(3 * kCount),
      ratio(kCount);
  const simd::ConnectionColumns out{x.data(),        y.data(),     z.data(),
                                    distance.data(), light.data(), ratio.data()};
  simd::connect_points(points.view(),
                       {{from.x, from.y, from.z}, {plane.x, plane.y, plane.z}, 1e-6f}, kCount, out);
  for (size_t i = 0; i < kCount; ++i) {
    for (const float v : {x[i], y[i], z[i], distance[i], light[3 * i], ratio[i]}) {
      ASSERT_TRUE(std::isfinite(v)) << i;
    }
    if (i == 5 || i == 9) {
      EXPECT_EQ(light[3 * i], 0);
      continue;
    }
    const glm::dvec3 to = glm::dvec3(points.vector(0, i)) - glm::dvec3(from);
    const double d2 = glm::dot(to, to);
    const glm::dvec3 d = to / std::sqrt(d2);
    const double facing = -glm::dot(glm::dvec3(points.vector(3, i)), d);
    const double geometry = std::abs(glm::dot(glm::dvec3(points.vector(6, i)), d)) / d2;
    // Cosines are differences of products near 1, with errors of some ulp of 1.
    const double bound = 8 * 0x1p-24;
    EXPECT_NEAR(x[i], d.x, bound);
    EXPECT_NEAR(distance[i], std::sqrt(d2), bound * std::sqrt(d2));
    EXPECT_NEAR(ratio[i], geometry * static_cast<double>(points.values[12][i]),
                bound / d2 + 4 * bound * geometry);
    if (std::abs(facing) < 1e-5) continue;
    for (int k = 0; k < 3; ++k) {
      const double power = points.values[9 + k][i];
      EXPECT_NEAR(light[3 * i + k], facing > 0 ? power * geometry : 0.,
                  power * (bound / d2 + 4 * bound * geometry));
    }
  }
}

/// The weight of a near light point is bounded by that of an eye ray that hits it, divided by the
/// number of eye rays.
TEST(LocalKernels, EyeRaysBoundTheWeightOfNearPoints) {
  constexpr size_t kCount = 64;
  constexpr float kEyeRays = 1 / 8.f, kRatio = 0.01f;
  const Vec3 power(3, 2, 1);
  Columns points(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const float distance = std::pow(10.f, -0.3f * static_cast<float>(i));  // down to 1e-19
    const Vec3 normal(0, 0, -1), at = distance * glm::normalize(Vec3(0.3f, 0.2f, 1));
    for (int k = 0; k < 3; ++k) {
      points.values[k][i] = at[k];
      points.values[3 + k][i] = points.values[6 + k][i] = normal[k];
      points.values[9 + k][i] = power[k];
    }
    points.values[12][i] = kRatio;
  }
  std::vector<float> x(kCount), y(kCount), z(kCount), distance(kCount), light(3 * kCount),
      ratio(kCount), f(kCount), uncertainty(kCount), blocks(kCount / simd::kLobeLanes);
  std::vector<float> weight[3];
  for (auto& column : weight) column.resize(kCount);
  simd::connect_points(points.view(), {{0, 0, 0}, {0, 0, 1}, 0}, kCount,
                       {x.data(), y.data(), z.data(), distance.data(), light.data(), ratio.data()});
  for (size_t i = 0; i < kCount; ++i) f[i] = kInvPi * z[i];
  const std::vector<uint32_t> cell(kCount);
  const float one = 1;
  float control[3];
  simd::weigh_connections({{{f.data(), f.data(), f.data()},
                            light.data(),
                            cell.data(),
                            {weight[0].data(), weight[1].data(), weight[2].data()},
                            uncertainty.data()},
                           f.data(),
                           ratio.data()},
                          {kEyeRays, {&one, &one}}, kCount, control, blocks.data());
  for (int k = 0; k < 3; ++k) {
    const float bound = power[k] / (kEyeRays * kRatio);
    float largest = 0;
    for (size_t i = 0; i < kCount; ++i) {
      ASSERT_TRUE(std::isfinite(weight[k][i])) << distance[i];
      EXPECT_LE(weight[k][i], bound * (1 + 1e-6f)) << distance[i];
      largest = std::max(largest, weight[k][i]);
    }
    EXPECT_GT(largest, 0.99f * bound);
    EXPECT_LT(weight[k][0], 0.01f * bound);
  }
}

TEST(LocalKernels, WeighConnectionsAsPlainCodeDoes) {
  constexpr size_t kCount = 48, kCells = 20;
  Random random(4);
  std::vector<float> f[3], light(3 * kCount), density(kCount), ratio(kCount), v(kCells), s(kCells);
  std::vector<uint32_t> cell(kCount);
  for (auto& column : f) column.resize(kCount);
  for (size_t i = 0; i < kCount; ++i) {
    for (int k = 0; k < 3; ++k) {
      f[k][i] = random.unit();
      light[3 * i + k] = static_cast<float>(random.between(-0.1, 4));
    }
    density[i] = static_cast<float>(random.between(0, 3));
    ratio[i] = i % 7 == 0 ? 0.f : static_cast<float>(std::pow(10, random.between(-6, 6)));
    cell[i] = static_cast<uint32_t>(random.between(0, kCells));
  }
  for (size_t c = 0; c < kCells; ++c) {
    v[c] = random.unit();
    s[c] = random.unit();
  }
  std::vector<float> weight[3], uncertainty(kCount), blocks(kCount / simd::kLobeLanes);
  for (auto& column : weight) column.resize(kCount);
  float control[3];
  simd::weigh_connections({{{f[0].data(), f[1].data(), f[2].data()},
                            light.data(),
                            cell.data(),
                            {weight[0].data(), weight[1].data(), weight[2].data()},
                            uncertainty.data()},
                           density.data(),
                           ratio.data()},
                          {0.4f, {v.data(), s.data()}}, kCount, control, blocks.data());
  double sums[3] = {}, total = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const double share = 1 / (1 + 0.4f * static_cast<double>(density[i]) * ratio[i]);
    double mean = 0;
    for (int k = 0; k < 3; ++k) {
      const double w = static_cast<double>(f[k][i]) * light[3 * i + k] * share;
      EXPECT_NEAR(weight[k][i], w, 1e-6 * std::abs(w));
      sums[k] += w * v[cell[i]];
      mean += w / 3;
    }
    EXPECT_NEAR(uncertainty[i], std::abs(mean) * s[cell[i]], 2e-6);
    total += std::abs(mean) * s[cell[i]];
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(control[k], sums[k], 1e-5 * kCount);
  EXPECT_NEAR(blocks[0] + blocks[1] + blocks[2], total, 1e-5 * kCount);
}

}  // namespace
}  // namespace kinome::test::local_parts_test
