// Tests the learned visibility of tiles, and the division of an image into tiles.
#include "clustered/product/pilot/tile_knowledge.h"

#include <gtest/gtest.h>

#include <set>

#include "support/render.h"
#include "kinome/clustered_light.h"

namespace kinome::test::tile_knowledge_test {
namespace {

TEST(TileGrid, CoversEveryPixelOnce) {
  const Rect crop{3, 5, 3 + 71, 5 + 34};
  const TileGrid grid(crop);
  std::multiset<size_t> pixels;
  std::set<int> tiles;
  for (int block = 0; block < grid.blocks_x() * grid.blocks_y(); ++block) {
    const Rect whole = grid.block(block);
    std::set<int> places;
    grid.for_each_tile(block, [&](const TileGrid::Tile& tile) {
      EXPECT_TRUE(tiles.insert(tile.index).second);
      EXPECT_TRUE(places.insert(tile.place).second);
      EXPECT_LT(tile.place, TileGrid::kMaxTilesOfBlock);
      for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
        for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x) {
          EXPECT_TRUE(x >= whole.x0 && x < whole.x1 && y >= whole.y0 && y < whole.y1);
          pixels.insert(grid.pixel(x, y));
        }
      }
    });
  }
  EXPECT_EQ(static_cast<int>(tiles.size()), grid.tiles());
  ASSERT_EQ(static_cast<int>(pixels.size()), crop.area());
  EXPECT_EQ(*pixels.begin(), 0u);
  EXPECT_EQ(static_cast<int>(*pixels.rbegin()), crop.area() - 1);
  EXPECT_EQ(std::set<size_t>(pixels.begin(), pixels.end()).size(), pixels.size());
}

/// Tiles in a row, each with a patch on one plane.
class Row {
 public:
  explicit Row(const std::string& material, const ProductSettings& settings = {}, int tiles = 7)
      : settings_(settings),
        grid_(Rect{0, 0, tiles * kTileSide, kTileSide}),
        shape_(make<Shape>("<shape type=\"rectangle\">" + material + "</shape>")),
        sky_(make<Emitter>("<emitter type=\"constant\"/>")),
        cells_(*sky_, *cell_grid_of(*sky_), 64, context_.scheduler),
        knowledge_(grid_, cells_, nullptr, settings_),
        learner_(knowledge_.padded_cells()),
        scratch_(knowledge_.padded_cells()),
        patches_(static_cast<size_t>(tiles)) {
    for (int tile = 0; tile < tiles; ++tile) {
      Patch patch;
      patch.bsdf = &shape_->bsdf();
      patch.tolerance = 0.1f;
      patch.lobe = {kAlpha, kAlpha};
      patches_[static_cast<size_t>(tile)].assign(1, patch);
      find(tile, {});
    }
  }

  Patch& patch(int tile) { return patches_[static_cast<size_t>(tile)].front(); }
  TileKnowledge& knowledge() { return knowledge_; }
  uint32_t cells() const { return cells_.size(); }

  void find(int tile, std::vector<VisibilityRecord> records) {
    const std::vector<std::vector<VisibilityRecord>> found{std::move(records)};
    knowledge_.keep(tile, patches_[static_cast<size_t>(tile)], found);
  }
  void find_all(int tile, bool visible, int times = 8) {
    std::vector<VisibilityRecord> records;
    for (int k = 0; k < times; ++k) {
      for (uint32_t c = 0; c < cells(); ++c) records.emplace_back(c, visible);
    }
    find(tile, std::move(records));
  }
  Visibility learn(int tile) {
    Visibility learned;
    knowledge_.learn(tile, patches_[static_cast<size_t>(tile)], learner_, scratch_,
                     [&](size_t, const Visibility& visibility) { learned = visibility; });
    return learned;
  }
  Visibility recall(int tile) {
    Visibility recalled = scratch_;
    knowledge_.recall(tile, 0, patch(tile), learner_, recalled);
    return recalled;
  }

 private:
  static constexpr float kAlpha = 0.02f;  // sharp, if there is no diffuse lobe
  const ProductSettings settings_;
  const TileGrid grid_;
  RenderContext context_{RenderOptions{.threads = 1}};
  std::shared_ptr<Shape> shape_;
  std::shared_ptr<Emitter> sky_;
  DistantCells cells_;
  TileKnowledge knowledge_;
  VisibilityLearner learner_;
  Visibility scratch_;
  std::vector<std::vector<Patch>> patches_;
};

const std::string kDiffuse = "<bsdf type=\"diffuse\"/>";
const std::string kMetal =
    "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\".02\"/></bsdf>";

/// The own rays of tile 3 have the largest weight, and nearby tiles have larger weights than
/// others.
TEST(TileKnowledge, LearnsFromTilesAround) {
  std::vector<float> v;
  for (int from = 4; from < 7; ++from) {
    Row row(kDiffuse);
    row.find_all(3, false);
    row.find_all(from, true);
    v.push_back(row.learn(3).v[5]);
  }
  EXPECT_LT(v[0], 0.5f);
  EXPECT_GT(v[0], 1.2f * v[1]);
  EXPECT_GT(v[1], 1.2f * v[2]);
  Row alone(kDiffuse);
  alone.find_all(3, false);
  EXPECT_EQ(v[2], alone.learn(3).v[5]);  // out of reach
}

TEST(TileKnowledge, LearnsOnlyAcrossContinuousSurfaces) {
  const auto learned_from = [](const auto& change) {
    Row row(kDiffuse);
    change(row.patch(4));
    row.find_all(4, true);
    return row.learn(3).v[5];
  };
  const float same = learned_from([](Patch&) {});
  EXPECT_GT(same, 0.5f);
  EXPECT_EQ(same, learned_from([](Patch& other) { other.position.x = 5; }));
  EXPECT_EQ(learned_from([](Patch& other) { other.position.z = 5; }), 0);
  EXPECT_EQ(learned_from([](Patch& other) { other.normal = {1, 0, 0}; }), 0);
  EXPECT_EQ(learned_from([](Patch& other) { other.bsdf = nullptr; }), 0);
}

/// For large images, each pass learns again what is stored for small ones.
TEST(TileKnowledge, RecallsTheSameIfItLearnsAgain) {
  ProductSettings forgetful;
  forgetful.remembered_pixels = 0;
  Row kept(kDiffuse), again(kDiffuse, forgetful);
  for (Row* row : {&kept, &again}) {
    std::vector<VisibilityRecord> records;
    for (uint32_t i = 0; i < 500; ++i) records.emplace_back(i * i % row->cells(), i % 3 > 0);
    row->find(3, records);
  }
  const Visibility learned = kept.learn(3);
  again.learn(3);
  const Visibility a = kept.recall(3), b = again.recall(3);
  for (size_t c = 0; c < kept.cells(); ++c) {
    EXPECT_EQ(a.v[c], b.v[c]);
    EXPECT_EQ(a.sigma[c], b.sigma[c]);
    EXPECT_EQ(a.sigma_mixed[c], b.sigma_mixed[c]);
    EXPECT_NEAR(a.v[c], learned.v[c], 0.51 / 255);
    EXPECT_NEAR(std::sqrt(a.sigma[c]), std::min(1.f, std::sqrt(learned.sigma[c])), 1.5 / 255);
  }
}

/// A sharp lobe uses the learned visibility only if it predicts the pilot's own rays.
TEST(TileKnowledge, TrustsValuesThatPredictTheRays) {
  Row row(kMetal);
  row.find_all(3, true);
  Visibility known = row.learn(3);
  EXPECT_TRUE(row.patch(3).trust);
  EXPECT_GT(row.patch(3).mean_visibility, 0.9f);
  const Column<float> v = known.v;
  row.knowledge().restrict(row.patch(3), known);
  EXPECT_EQ(known.v, v);

  std::vector<VisibilityRecord> records;
  for (uint32_t i = 0; i < 16 * row.cells(); ++i) records.emplace_back(i / 16, i % 2 == 0);
  row.find(3, std::move(records));
  known = row.learn(3);
  EXPECT_FALSE(row.patch(3).trust);
  row.knowledge().restrict(row.patch(3), known);
  EXPECT_EQ(known.v, Column<float>(known.v.size(), 0.f));
  EXPECT_EQ(known.sigma, known.sigma_mixed);
}

/// If the surrounding tiles predict a tile's rays, sigma and hence the number of rays decrease;
/// otherwise they increase.
TEST(TileKnowledge, ChecksSigmaByThePilotsRays) {
  const auto sigma_of = [](bool alternates, bool is_checked) {
    ProductSettings settings;
    settings.checked_sigma = is_checked;
    constexpr int kTiles = 90;
    Row row(kDiffuse, settings, kTiles);
    for (int tile = 0; tile < kTiles; ++tile) {
      row.find_all(tile, alternates && tile % 2 == 0, 25);
    }
    for (int tile = 0; tile < kTiles; ++tile) row.learn(tile);
    row.knowledge().finish(nullptr);
    return row.recall(1).sigma[5];
  };
  EXPECT_LT(sigma_of(false, true), 0.8f * sigma_of(false, false));
  EXPECT_GT(sigma_of(true, true), 1.02f * sigma_of(true, false));
}

TEST(TileKnowledge, LeavesOutExcludedRecords) {
  ProductSettings settings;
  settings.control_variate = false;
  Row without_control(kDiffuse, settings);
  without_control.find_all(3, true);
  Visibility known = without_control.learn(3);
  without_control.knowledge().restrict(without_control.patch(3), known);
  EXPECT_EQ(known.v[5], 0);
  EXPECT_GT(known.sigma[5], 0.9f);

  settings = {};
  settings.learned_sigma = false;
  Row without_sigma(kDiffuse, settings);
  without_sigma.find_all(3, true);
  known = without_sigma.learn(3);
  without_sigma.knowledge().restrict(without_sigma.patch(3), known);
  EXPECT_GT(known.v[5], 0.9f);
  EXPECT_EQ(known.sigma[5], 1);
}

TEST(TileKnowledge, Forgets) {
  Row row(kDiffuse);
  row.find_all(3, true);
  row.knowledge().forget();
  std::vector<Patch> patches;
  row.knowledge().patches(3, patches);
  EXPECT_TRUE(patches.empty());
  EXPECT_EQ(row.knowledge().main_bsdf(3), nullptr);
}

/// All that passes use of a patch survives its storage.
TEST(TileKnowledge, StoredPatchesAreRestored) {
  SharedOfPatches shared;
  Patch patch;
  patch.normal = {0.6f, 0, 0.8f};
  patch.position = {1, 2, 3};
  patch.viewer = {0, 0.8f, 0.6f};
  patch.cone_cosine = 0.7f;
  patch.tolerance = 0.3f;
  patch.diffuse = {0.1f, 0.2f, 0.3f};
  patch.glossy_reflectance = 0.4f;
  patch.is_uniform = true;
  patch.lobe = {0.25f, 0.35f};
  patch.count = 9;
  patch.records_end = 27;
  patch.glossy = 0.5f;
  patch.cell_share = 0.6f;
  patch.mean_visibility = 0.45f;
  patch.lamp_visibility = 0.55f;
  patch.eye_rays = 0.65f;
  patch.trust = false;
  patch.probed = std::make_shared<const SharedOfPatches::Probed>();
  const auto expect_restored = [&] {
    const Patch back = StoredPatch(patch, shared).restored(shared);
    for (const auto member : {&Patch::normal, &Patch::position, &Patch::viewer, &Patch::diffuse}) {
      EXPECT_EQ(back.*member, patch.*member);
    }
    for (const auto member :
         {&Patch::cone_cosine, &Patch::tolerance, &Patch::glossy_reflectance, &Patch::glossy,
          &Patch::cell_share, &Patch::mean_visibility, &Patch::lamp_visibility, &Patch::eye_rays}) {
      EXPECT_EQ(back.*member, patch.*member);
    }
    for (const auto member : {&Patch::is_described, &Patch::is_uniform, &Patch::trust}) {
      EXPECT_EQ(back.*member, patch.*member);
    }
    EXPECT_EQ(back.count, patch.count);
    EXPECT_EQ(back.records_end, patch.records_end);
    EXPECT_EQ(back.probed, patch.probed);
    EXPECT_EQ(back.lobe.alpha_u, patch.lobe.alpha_u);
    EXPECT_EQ(back.lobe.alpha_v, patch.lobe.alpha_v);
    EXPECT_TRUE(back.form.same_kind(patch.form));
    EXPECT_EQ(back.form.specular, patch.form.specular);
    EXPECT_EQ(back.form.glossy, patch.form.glossy);
  };
  expect_restored();
  patch.probed = nullptr;
  patch.is_described = true;
  patch.form.glossy = BsdfForm::Glossy::kGgx;
  patch.form.specular = {0.7f, 0.8f, 0.9f};
  patch.form.alpha_u = 0.1f;
  patch.form.alpha_v = 2e3f;
  patch.lobe = microfacet_lobe(patch.form);
  expect_restored();
  EXPECT_EQ(StoredPatch(patch, shared).restored(shared).form.alpha_v, 2e3f);
}

}  // namespace
}  // namespace kinome::test::tile_knowledge_test
