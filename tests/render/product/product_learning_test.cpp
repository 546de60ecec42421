// Errors in the learned visibility only increase the noise; the estimator stays unbiased. The tests
// run it as the renderer does, but with falsified visibilities. They use z-tests against `direct`,
// each with a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include "clustered/product/strata/estimator.h"
#include "product_scenes.h"
#include "kinome/clustered_light.h"

namespace kinome::test::product_learning_test {
namespace {

constexpr int kTile = 4;

/// Falsification of the learned visibilities, patch by patch.
enum class Lie { kNone, kAllVisible, kAllHidden, kOpposite, kShuffled, kOtherPatch, kPeeked };

void set_all(Visibility& visibility, float v, float sigma) {
  std::fill(visibility.v.begin(), visibility.v.end(), v);
  std::fill(visibility.sigma.begin(), visibility.sigma.end(), sigma);
  std::fill(visibility.sigma_mixed.begin(), visibility.sigma_mixed.end(), sigma);
}

void falsify(Lie lie, uint32_t cells, std::vector<Visibility>& learned) {
  std::mt19937 rng(7);
  std::vector<uint32_t> order(cells);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), rng);
  const std::vector<Visibility> truth = learned;
  for (size_t p = 0; p < learned.size(); ++p) {
    Visibility& visibility = learned[p];
    switch (lie) {
      case Lie::kNone:
      case Lie::kPeeked:
        break;
      case Lie::kAllVisible:
        set_all(visibility, 1, 0.01f);
        break;
      case Lie::kAllHidden:
        set_all(visibility, 0, 0.01f);
        break;
      case Lie::kOpposite:  // sigma stays the same
        for (float& v : visibility.v) v = 1 - v;
        break;
      case Lie::kShuffled:
        for (uint32_t c = 0; c < cells; ++c) {
          visibility.v[c] = truth[p].v[order[c]];
          visibility.sigma[c] = truth[p].sigma[order[c]];
          visibility.sigma_mixed[c] = truth[p].sigma_mixed[order[c]];
        }
        break;
      case Lie::kOtherPatch:
        visibility = truth[(p + 1) % truth.size()];
        break;
    }
  }
}

/// Renders like ProductRenderer: patches and visibilities from a pilot, then estimates.
class LyingRenderer {
 public:
  LyingRenderer(const Scene& scene, Lie lie, uint32_t max_depth)
      : scene_(scene),
        sensor_(*scene.sensors().front()),
        crop_(sensor_.film().crop()),
        primaries_({table_, sensor_, PathSettings{{}, true}}),
        cells_(scene.environment()
                   ? DistantCells(*scene.environment(), *cell_grid_of(*scene.environment()), 128,
                                  context_.scheduler)
                   : DistantCells()),
        lie_(lie) {
    LocalLight::Settings settings;
    settings.length.max_depth = max_depth;
    settings.bounce_cells = 64;
    settings.points = LocalLight::kMinPoints;
    const auto seen = places_seen(scene, sensor_, 128, 1, context_);
    local_ = std::make_unique<const LocalLight>(scene, settings, seen, 1, context_);
    if (local_->empty()) local_.reset();
    tiles_.resize(static_cast<size_t>(tiles_x()) * ((crop_.height() + kTile - 1) / kTile));
    const CellLight light = make_light(1);
    Estimator estimator(light);
    for (size_t i = 0; i < tiles_.size(); ++i) learn(i, estimator);
  }

  /// Sums over tiles, channel by channel.
  std::vector<double> render(uint64_t seed, uint32_t rays) {
    const CellLight light = make_light(hash_words(seed, 1));
    Estimator estimator(light);
    std::vector<double> values;
    for (size_t i = 0; i < tiles_.size(); ++i) {
      const Rgb sum = render_tile(i, seed, rays, estimator);
      values.insert(values.end(), {sum.x, sum.y, sum.z});
    }
    return values;
  }

 private:
  static constexpr uint16_t kPrimaries = 8;
  static constexpr uint16_t kPilotPrimaries = 8;
  static constexpr uint32_t kPilotRays = 4000;  ///< per tile
  static constexpr float kCandidates = 512;

  struct TileKnowledge {
    std::vector<Patch> patches;
    std::vector<Visibility> visibility;
  };

  int tiles_x() const { return (crop_.width() + kTile - 1) / kTile; }
  Rect pixels(size_t tile) const {
    const int x = static_cast<int>(tile) % tiles_x() * kTile;
    const int y = static_cast<int>(tile) / tiles_x() * kTile;
    return {crop_.x0 + x, crop_.y0 + y, std::min(crop_.x0 + x + kTile, crop_.x1),
            std::min(crop_.y0 + y + kTile, crop_.y1)};
  }
  CellLight make_light(uint64_t seed) {
    CellPoints points;
    if (cells_.size() > 0) points = cells_.draw_points(1 << 13, seed, context_.scheduler);
    LocalPoints local_points;
    if (local_) local_points = local_->draw(hash_words(seed, 8), context_);
    return {cells_, scene_.environment(), std::move(points), local_.get(), std::move(local_points)};
  }
  /// Number of all cells.
  uint32_t padded_size() const {
    return cells_.padded_size() + (local_ ? local_->padded_size() : 0);
  }
  TilePrimaries trace(size_t tile, uint16_t count, uint64_t seed) {
    const std::vector<uint16_t> counts(pixels(tile).area(), count);
    primaries_.clear();
    primaries_.add(pixels(tile), counts);
    primaries_.trace(seed, counters_);
    return primaries_.tile(0);
  }

  void learn(size_t tile, Estimator& estimator) {
    TileKnowledge& known = tiles_[tile];
    TilePrimaries primaries = trace(tile, kPilotPrimaries, 1000);
    make_patches(primaries, known.patches);
    known.visibility.assign(known.patches.size(), Visibility(padded_size()));
    std::vector<std::vector<VisibilityRecord>> records(known.patches.size());
    std::vector<PointPlan> points(primaries.size());
    Unit unit;
    unit.end = static_cast<uint32_t>(primaries.size());
    unit.rays = kPilotRays;
    unit.seed = hash_words(tile, 5);
    estimator.begin_tile(scene_, primaries, known.patches, known.visibility, unit.seed, counters_);
    estimator.probe(unit, points, records);
    estimator.flush();
    VisibilityLearner learner(padded_size());
    for (size_t p = 0; p < records.size(); ++p) {
      learner.begin();
      learner.add(records[p], 16);
      learner.finish(known.visibility[p]);
    }
    falsify(lie_, local_ ? padded_size() : cells_.size(), known.visibility);
  }

  /// Learns from the same rays that the unit is going to weight. Only sigma determines where these
  /// go, and it doesn't change.
  void peek(const Unit& unit, const TilePrimaries& primaries, TileKnowledge& known,
            Estimator& estimator) {
    std::vector<std::vector<VisibilityRecord>> records(known.patches.size());
    std::vector<PointPlan> points(primaries.size());
    estimator.probe(unit, points, records);
    estimator.flush();
    for (size_t p = 0; p < records.size(); ++p) {
      for (const VisibilityRecord record : records[p]) {
        known.visibility[p].v[record.cell()] = record.visible() ? 1.f : 0.f;
      }
    }
    estimator.begin_tile(scene_, primaries, known.patches, known.visibility, unit.seed, counters_);
  }

  Rgb render_tile(size_t tile, uint64_t seed, uint32_t rays, Estimator& estimator) {
    TilePrimaries primaries = trace(tile, kPrimaries, hash_words(seed, 2));
    TileKnowledge known = tiles_[tile];
    assign_patches(primaries, known.patches);
    while (known.visibility.size() < known.patches.size()) {  // missed by the pilot
      known.visibility.emplace_back(padded_size());
    }
    estimator.begin_tile(scene_, primaries, known.patches, known.visibility, hash_words(seed, tile),
                         counters_);
    Rgb sum(0.f);
    for (int i = 0; i < pixels(tile).area(); ++i) {
      Unit unit;
      unit.first = primaries.first(i);
      unit.end = primaries.first(i + 1);
      unit.rays = rays;
      unit.candidates = kCandidates;
      unit.seed = hash_words(seed, tile, i);
      if (lie_ == Lie::kPeeked) peek(unit, primaries, known, estimator);
      estimator.estimate(unit, {&sum});
    }
    estimator.flush();
    return sum / static_cast<float>(kPrimaries);
  }

  const Scene& scene_;
  const Sensor& sensor_;
  RenderContext context_{RenderOptions{.threads = 1}};
  const Rect crop_;
  const transport::SceneTable table_{scene_};
  Primaries primaries_;
  const DistantCells cells_;
  std::unique_ptr<const LocalLight> local_;
  const Lie lie_;
  RenderCounters counters_;
  std::vector<TileKnowledge> tiles_;
};

std::vector<Estimate> estimate_lie(const Scene& scene, Lie lie, uint32_t max_depth = 2,
                                   uint32_t renders = kRenders) {
  constexpr uint32_t kRays = 12;
  LyingRenderer renderer(scene, lie, max_depth);
  std::vector<Moments> moments;
  for (uint64_t seed = 1; seed <= renders; ++seed) {
    const std::vector<double> values = renderer.render(seed, kRays);
    moments.resize(values.size());
    for (size_t i = 0; i < values.size(); ++i) moments[i].add(values[i]);
  }
  std::vector<Estimate> estimates;
  for (const Moments& m : moments) estimates.push_back({m.mean(), m.variance_of_mean()});
  return estimates;
}

double noise(const std::vector<Estimate>& estimates) {
  double sum = 0;
  for (const Estimate& e : estimates) sum += e.variance_of_mean;
  return sum;
}

class WrongLearning : public testing::TestWithParam<std::pair<std::string, std::string>> {};

Arrangement arrangement(const std::string& material) {
  Arrangement s;
  s.shapes = shapes_xml(material);
  s.direct_samples = 64;
  return s;
}

void expect_slower_and_unbiased(const Arrangement& s) {
  const auto scene = direct_scene(s);
  const auto reference = estimate_tiles(*scene, kRenders, kTile, 5000);
  const auto estimate = [&](Lie lie) {
    return estimate_lie(*scene, lie, static_cast<uint32_t>(s.max_depth));
  };
  const auto learned = estimate(Lie::kNone);
  expect_equal(learned, reference, kAlpha, "learned");
  constexpr std::pair<Lie, const char*> kLies[] = {{Lie::kAllVisible, "all visible"},
                                                   {Lie::kAllHidden, "all hidden"},
                                                   {Lie::kOpposite, "the opposite"},
                                                   {Lie::kShuffled, "shuffled"},
                                                   {Lie::kOtherPatch, "another patch's"}};
  for (const auto& [lie, name] : kLies) {
    const auto wrong = estimate(lie);
    expect_equal(wrong, reference, kAlpha, name);
    // For lamps, neighbouring patches have nearly the same visibility.
    if (lie == Lie::kOtherPatch && s.max_depth > 2) continue;
    EXPECT_GT(noise(wrong), noise(learned)) << name;
  }
}

TEST_P(WrongLearning, IsSlowerAndUnbiased) {
  expect_slower_and_unbiased(arrangement(GetParam().second));
}
INSTANTIATE_TEST_SUITE_P(Materials, WrongLearning,
                         testing::Values(std::pair("Diffuse", kGrey),
                                         std::pair("RoughPlastic",
                                                   bsdf("roughplastic", number("alpha", .1))),
                                         std::pair("Metal", metal(.2))),
                         [](const auto& c) { return c.param.first; });

/// A spot, a bright ball, and a floor in front of a wall that they light.
Arrangement local_arrangement() {
  Arrangement s = arrangement(bsdf("roughplastic", number("alpha", .2)));
  s.max_depth = 3;
  s.light =
      "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"30 25 20\"/>" +
      number("cutoff_angle", 25) +
      "<transform name=\"to_world\"><lookat origin=\"2,3,2\" target=\".5,0,.3\" up=\"0,1,0\"/>"
      "</transform></emitter><shape type=\"sphere\"><point name=\"center\" x=\".2\" y=\".25\" "
      "z=\"1.2\"/><float name=\"radius\" value=\".1\"/><emitter type=\"area\"><rgb "
      "name=\"radiance\" value=\"9 12 16\"/></emitter></shape>";
  s.shapes +=
      "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"6\"/>"
      "<translate z=\"-3\"/></transform>" +
      kGrey + "</shape>";
  return s;
}

TEST(Learning, OfLocalLightMayBeWrong) {
  expect_slower_and_unbiased(local_arrangement());
}

/// A test of the tests: visibility that changes after its rays are drawn causes a bias, which must
/// be found.
TEST(Learning, FromTheRaysThatItWeighsIsCaught) {
  const auto scene = direct_scene(arrangement(kGrey));
  // Enough renders that all channels show the bias with any seed.
  const auto direct = estimate_tiles(*scene, 4 * kRenders, kTile, 5000);
  const auto peeked = estimate_lie(*scene, Lie::kPeeked, 2, 4 * kRenders);
  for (int c = 0; c < 3; ++c) {
    EXPECT_FALSE(z_test(channel(peeked, c), channel(direct, c), kAlpha / 3).passed);
  }
}

TEST(Learning, OfLocalLightFromTheRaysThatItWeighsIsCaught) {
  const auto scene = direct_scene(local_arrangement());
  const auto path = estimate_tiles(*scene, kRenders, kTile, 5000);
  const auto peeked = estimate_lie(*scene, Lie::kPeeked, 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_FALSE(z_test(channel(peeked, c), channel(path, c), kAlpha / 3).passed);
  }
}

}  // namespace
}  // namespace kinome::test::product_learning_test
