// Tests the visibility that product sampling learns.
#include "clustered/product/tiles/visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinome/emitter.h"
#include "kinome/sampler.h"
#include "kinome/warp.h"
#include "support/render.h"

namespace kinome::test::visibility_test {
namespace {

constexpr size_t kCells = 512;

Visibility learn(const std::vector<std::vector<VisibilityRecord>>& records, uint32_t weight = 16) {
  VisibilityLearner learner(kCells);
  learner.begin();
  for (const auto& some : records) learner.add(some, weight);
  Visibility out(kCells);
  learner.finish(out);
  return out;
}

void expect_sane(const Visibility& learned) {
  for (size_t c = 0; c < kCells; ++c) {
    EXPECT_GE(learned.v[c], 0);
    EXPECT_LE(learned.v[c], 1);
    EXPECT_GT(learned.sigma[c], 0);
    EXPECT_GT(learned.sigma_mixed[c], 0);
    EXPECT_LT(learned.sigma[c], 1.1f);
    EXPECT_LT(learned.sigma_mixed[c], 1.1f);
  }
}

/// Returns records of all cells, `count` times.
std::vector<VisibilityRecord> everywhere(bool visible, int count) {
  std::vector<VisibilityRecord> records;
  for (int k = 0; k < count; ++k) {
    for (uint32_t c = 0; c < kCells; ++c) records.emplace_back(c, visible);
  }
  return records;
}

TEST(VisibilityRecord, KeepsBoth) {
  for (const uint32_t cell : {0u, 1u, 511u, kMaxCells - 1}) {
    for (const bool visible : {false, true}) {
      EXPECT_EQ(VisibilityRecord(cell, visible).cell(), cell);
      EXPECT_EQ(VisibilityRecord(cell, visible).visible(), visible);
      EXPECT_EQ(VisibilityRecord(cell, visible).value(), visible ? 1.f : 0.f);
    }
    EXPECT_NEAR(VisibilityRecord(cell, 0.3f).value(), 0.3f, 0.002f);
    EXPECT_EQ(VisibilityRecord(cell, 0.3f).cell(), cell);
  }
}

/// A pane transmits a part of the light in half of the cells; the others are hidden.
TEST(VisibilityLearner, LearnsTheTransmittanceOfPanes) {
  constexpr float kShare = 0.6f;
  std::vector<VisibilityRecord> records;
  for (int k = 0; k < 30; ++k) {
    for (uint32_t c = 0; c < kCells; ++c) records.emplace_back(c, c < kCells / 2 ? kShare : 0.f);
  }
  const Visibility learned = learn({records});
  expect_sane(learned);
  for (size_t c = 16; c < kCells - 16; ++c) {
    if (c > kCells / 2 - 16 && c < kCells / 2 + 16) continue;
    EXPECT_NEAR(learned.v[c], c < kCells / 2 ? kShare : 0.f, 0.02f) << c;
    EXPECT_LT(learned.sigma[c], 0.1f) << c;
  }
}

TEST(VisibilityLearner, IsUncertainWithoutRecords) {
  const Visibility learned = learn({});
  expect_sane(learned);
  for (size_t c = 0; c < kCells; ++c) {
    EXPECT_EQ(learned.v[c], 0);
    EXPECT_EQ(learned.sigma[c], 1);  // all light is left to rays
  }
}

TEST(VisibilityLearner, IsCertainAfterManyRecords) {
  for (const bool visible : {false, true}) {
    const Visibility learned = learn({everywhere(visible, 30)});
    expect_sane(learned);
    for (size_t c = 0; c < kCells; ++c) {
      EXPECT_EQ(learned.v[c], visible ? 1.f : 0.f);
      EXPECT_LT(learned.sigma[c], 0.06f);
      EXPECT_GE(learned.sigma[c], 0.01f);
    }
    EXPECT_EQ(learned.sigma_mixed[0] > 0.9f, visible);
  }
}

TEST(VisibilityLearner, UsesNeighboursOfCellsWithoutRecords) {
  // Cells of the first half are visible, those of the second hidden; one in each has no record.
  std::vector<VisibilityRecord> records;
  const auto unknown = [](uint32_t c) { return c == 100 || c == 400; };
  for (int k = 0; k < 8; ++k) {
    for (uint32_t c = 0; c < kCells; ++c) {
      if (!unknown(c)) records.emplace_back(c, c < kCells / 2);
    }
  }
  const Visibility learned = learn({records});
  expect_sane(learned);
  EXPECT_GT(learned.v[100], 0.9f);
  EXPECT_LT(learned.v[400], 0.1f);
  EXPECT_GT(learned.sigma[100], learned.sigma[101]);
  EXPECT_GT(learned.sigma[400], learned.sigma[401]);
}

TEST(VisibilityLearner, CountsRecordsByTheirWeightAndForgetsThem) {
  std::mt19937 rng(5);
  std::vector<VisibilityRecord> records;
  for (int k = 0; k < 2000; ++k) records.emplace_back(rng() % kCells, rng() % 3 == 0);
  const Visibility once = learn({records}, 32);
  const Visibility twice = learn({records, records}, 16);
  expect_sane(once);
  EXPECT_EQ(once.v, twice.v);
  EXPECT_EQ(once.sigma, twice.sigma);
  VisibilityLearner learner(kCells);
  Visibility out(kCells);
  for (int k = 0; k < 2; ++k) {
    learner.begin();
    learner.add(records, 32);
    learner.finish(out);
  }
  EXPECT_EQ(out.v, once.v);
}

/// The estimator's variance depends on v and sigma. For many random records, v is their mean (moved
/// toward 0 or 1), and sigma is the root mean square of V - v.
TEST(VisibilityLearner, FindsSharesAndDeviations) {
  for (const double share : {0.1, 0.5, 0.8}) {
    std::vector<VisibilityRecord> records;
    for (int k = 0; k < 500; ++k) {
      for (uint32_t c = 0; c < 8; ++c) records.emplace_back(c, k < 500 * share);
    }
    const Visibility learned = learn({records});
    const double v = (share - 0.05) / 0.9;
    EXPECT_NEAR(learned.v[3], v, 0.002);
    EXPECT_NEAR(learned.sigma[3], std::sqrt(share * sqr(1 - v) + (1 - share) * sqr(v)), 0.002);
  }
}

/// Counts have 16 bits; further records are ignored.
TEST(VisibilityLearner, IgnoresExcessRecords) {
  const std::vector<VisibilityRecord> seen(3000, VisibilityRecord(3, true));
  const std::vector<VisibilityRecord> hidden(3000, VisibilityRecord(4, false));
  const std::vector<VisibilityRecord> most(hidden.begin(), hidden.begin() + 4095 - 3000);
  const Visibility all = learn({seen, hidden, hidden}), some = learn({seen, most});
  expect_sane(all);
  EXPECT_EQ(all.v, some.v);
  EXPECT_EQ(all.sigma, some.sigma);
  EXPECT_GT(all.v[3], 0.99f);
  EXPECT_LT(all.v[4], 0.01f);
}

/// A sky whose cells have very different sizes.
class Sky final : public Emitter {
 public:
  Sky() : grid_{64, 32} { grid_.smooth_quads = true; }
  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& d) const override {
    return Rgb(std::exp(20 * (glm::dot(d, glm::normalize(Vec3(1, 0.6f, 0.3f))) - 1)) + 0.01f);
  }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override {
    return std::nullopt;
  }
  const EnvironmentGrid& grid() const { return grid_; }

 private:
  EnvironmentGrid grid_;
};

/// All cells that a patch faces are learned as before, and so are cells without a direction.
TEST(VisibilityLearner, LearnsTheVisibleHemisphere) {
  RenderContext context({});
  const Sky sky;
  const DistantCells cells(sky, sky.grid(), 512, context.scheduler);
  const CellNeighbours neighbours = find_neighbours(cells, context.scheduler);
  constexpr size_t kLocal = 2 * kBlockLanes;
  const size_t size = cells.padded_size() + kLocal;
  VisibilityLearner learner(size, &neighbours);
  std::vector<VisibilityRecord> records;
  for (uint32_t c = 0; c < size; ++c) records.emplace_back(c, c % 3 != 0);
  learner.begin();
  learner.add(records, 16);
  Visibility all(size), facing(size);
  learner.finish(all);
  const Vec3 normal = glm::normalize(Vec3(-1, 0.2f, 0.5f));
  learner.finish(cells.blocks(), normal, 0.1f, facing);
  std::vector<uint32_t> blocks;
  cells.blocks().find_facing(normal, 0.1f, blocks);
  std::vector<bool> faces(size / kBlockLanes);
  for (const uint32_t block : blocks) faces[block] = true;
  for (size_t k = 0; k < kLocal / kBlockLanes; ++k) faces[faces.size() - 1 - k] = true;
  for (size_t c = 0; c < size; ++c) {
    const bool is_learned = faces[c / kBlockLanes];
    EXPECT_EQ(facing.v[c], is_learned ? all.v[c] : 0.f) << c;
    EXPECT_EQ(facing.sigma[c], is_learned ? all.sigma[c] : 1.f) << c;
    EXPECT_EQ(facing.sigma_mixed[c], is_learned ? all.sigma_mixed[c] : 1.f) << c;
  }
}

/// No light of an omitted block is above the horizon of any normal of the cone. Some blocks are
/// omitted, although most cells are around the bright part of this sky.
TEST(CellBlocks, LeaveOutNothingThatIsFaced) {
  RenderContext context({});
  const Sky sky;
  uint64_t state = 1;
  const auto random = [&state] { return to_unit_float(static_cast<uint32_t>(hash_words(++state))); };
  const auto direction = [&] { return square_to_uniform_sphere(Vec2(random(), random())); };
  for (const uint32_t count : {1u, 40u, 512u, 3000u}) {
    const DistantCells cells(sky, sky.grid(), count, context.scheduler);
    const CellPoints points = cells.draw_points(1u << 14, 1, context.scheduler);
    size_t left_out = 0, all = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const Vec3 mean = direction();
      const float sine = trial % 3 == 0 ? 0.f : trial % 3 == 1 ? 0.3f * random() : 1.2f * random();
      std::vector<uint32_t> blocks;
      cells.blocks().find_facing(mean, sine, blocks);
      ASSERT_TRUE(std::is_sorted(blocks.begin(), blocks.end()));
      ASSERT_TRUE(blocks.empty() || blocks.back() < cells.blocks().size());
      std::vector<bool> faces(cells.blocks().size());
      for (const uint32_t block : blocks) faces[block] = true;
      if (sine >= 1) {
        EXPECT_EQ(blocks.size(), faces.size());
      }
      for (const CellPoint& point : points.points) {
        if (faces[point.cell / kBlockLanes]) continue;
        // Maximum over the cone's normals of the direction's height above the horizon.
        EXPECT_LE(glm::dot(mean, point.d), -sine) << count;
      }
      if (count < 512 || sine > 0.1f) continue;
      all += faces.size();
      left_out += faces.size() - blocks.size();
    }
    if (count >= 512) {
      EXPECT_GT(static_cast<double>(left_out), 0.15 * static_cast<double>(all)) << count;
    }
  }
}

TEST(CellNeighbours, AreTheNearestCells) {
  RenderContext context({});
  const Sky sky;
  // All neighbours are found if there are few cells. If there are many, only those within reach
  // along the curve are found, which most of the nearest ones are.
  for (const auto& [count, min_found] : {std::pair(64u, 1.), {512u, 1.}, {1500u, 0.9}}) {
    const DistantCells cells(sky, sky.grid(), count, context.scheduler);
    const CellNeighbours neighbours = find_neighbours(cells, context.scheduler);
    for (const auto& column : neighbours.of) ASSERT_EQ(column.size(), cells.padded_size());
    const auto cosine = [&](size_t a, size_t b) {
      double sum = 0;
      for (const auto& axis : cells.axis()) sum += double{axis[a]} * axis[b];
      return sum;
    };
    size_t found = 0;
    for (uint32_t c = 0; c < cells.size(); ++c) {
      std::vector<double> all;
      for (uint32_t k = 0; k < cells.size(); ++k) {
        if (k != c) all.push_back(cosine(c, k));
      }
      std::sort(all.begin(), all.end(), std::greater());
      for (size_t i = 0; i < CellNeighbours::kCount; ++i) {
        const auto k = static_cast<uint32_t>(neighbours.of[i][c]);
        ASSERT_LT(k, cells.size());
        ASSERT_NE(k, c);
        if (i > 0) {
          EXPECT_NE(neighbours.of[i][c], neighbours.of[i - 1][c]);
        }
        found += std::abs(cosine(c, k) - all[i]) < 1e-6;
      }
    }
    EXPECT_GE(static_cast<double>(found),
              min_found * static_cast<double>(cells.size() * CellNeighbours::kCount));
  }
}

TEST(CellNeighbours, AreNoneWhereCellsAreFew) {
  RenderContext context({});
  const Sky sky;
  EnvironmentGrid grid = sky.grid();
  const DistantCells cells(sky, grid, 1, context.scheduler);
  const CellNeighbours neighbours = find_neighbours(cells, context.scheduler);
  for (const auto& of : neighbours.of) {
    for (const int32_t k : of) EXPECT_LE(static_cast<uint32_t>(k), cells.size());
  }
}

/// All records of the tree's parent of cells 96 to 103 are visible, and none around cell 100.
TEST(VisibilityLearner, PrefersSurroundingCellsToTheCurve) {
  CellNeighbours neighbours;
  for (size_t i = 0; i < CellNeighbours::kCount; ++i) {
    neighbours.of[i].resize(kCells);
    for (size_t c = 0; c < kCells; ++c) {
      neighbours.of[i][c] = static_cast<int32_t>((c + 200 + i) % kCells);
    }
  }
  std::vector<VisibilityRecord> records;
  for (int k = 0; k < 8; ++k) {
    for (uint32_t c = 96; c < 104; ++c) {
      if (c != 100) records.emplace_back(c, true);
    }
    for (uint32_t c = 300; c < 308; ++c) records.emplace_back(c, false);
  }
  Visibility by_tree(kCells), by_both(kCells);
  for (const auto& [given, out] : {std::pair<const CellNeighbours*, Visibility*>(nullptr, &by_tree),
                                   {&neighbours, &by_both}}) {
    VisibilityLearner learner(kCells, given);
    learner.begin();
    learner.add(records, 16);
    learner.finish(*out);
    expect_sane(*out);
  }
  EXPECT_GT(by_tree.v[100], 0.9f);
  EXPECT_LT(by_both.v[100], 0.1f);
  EXPECT_GT(by_both.v[101], 0.8f);  // its own eight records have more weight
}

}  // namespace
}  // namespace kinome::test::visibility_test
