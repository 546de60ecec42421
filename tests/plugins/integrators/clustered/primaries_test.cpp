// Tests camera rays of tiles. The rays of a tile don't depend on other tiles in the same batch.
// Columns have the values of the shapes and BSDFs.
#include "clustered/product/tiles/primaries.h"

#include <numeric>

#include "plugins/integrators/estimators/stage_tile.h"

namespace kinome::test::primaries_test {
namespace {

std::unique_ptr<Scene> scene_of(const std::string& sensor, const std::string& shapes) {
  const std::string optics = sensor == "thinlens"
                                 ? R"(<float name="aperture_radius" value=".2"/>
                                      <float name="focus_distance" value="3.6"/>)"
                                 : "";
  return scene_from("<sensor type=\"" + sensor + "\">" + optics +
                    R"(<float name="fov" value="30"/>
      <transform name="to_world"><lookat origin="0,3,2" target="0,0,0" up="0,1,0"/></transform>
      <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
      <rfilter type="box"/></film></sensor>)" +
                    shapes);
}

/// Returns shapes of several materials, one of which emits, under a sky.
std::string things() {
  return ball_xml(rough_xml("roughplastic", .2)) + floor_xml(kGrey) +
         R"(<shape type="sphere"><point name="center" x=".8" y=".2" z=".3"/>
            <float name="radius" value=".25"/><emitter type="area"><rgb name="radiance"
            value="3 2 1"/></emitter></shape><shape type="sphere"><point name="center" x="-.7"
            y=".3" z=".4"/><float name="radius" value=".3"/>)" +
         normal_map_xml({0.6f, 0.45f, 0.98f}, rough_xml("roughconductor", .1)) + "</shape>" +
         sky_xml();
}

/// All data of a ray that stages use.
struct Ray1 {
  bool hit;
  Rgb emitted;
  Vec3 p{0.f}, n{0.f}, normal{0.f}, viewer{0.f}, diffuse{0.f}, specular{0.f};
  float distance = 0, error = 0;
  bool operator==(const Ray1&) const = default;
};
std::vector<Ray1> rays_of(const TilePrimaries& tile) {
  std::vector<Ray1> rays;
  for (size_t i = 0; i < tile.size(); ++i) {
    Ray1 r{tile.hit(i), tile.emitted(i)};
    if (r.hit && any(tile.shape(i).bsdf().lobes())) {
      r.normal = tile.normal(i), r.viewer = tile.viewer(i);
      r.diffuse = tile.diffuse(i), r.specular = tile.specular(i);
    }
    if (r.hit) {
      const SurfaceInteraction place = tile.place(i);
      r.p = place.p, r.n = place.n, r.error = place.p_error;
      r.distance = tile.distance(i);
    }
    rays.push_back(r);
  }
  return rays;
}

class PrimariesTest : public testing::Test {
 protected:
  explicit PrimariesTest(const std::string& sensor = "perspective")
      : scene_(scene_of(sensor, things())), table_(*scene_) {}

  const Film& film() const { return scene_->sensors().front()->film(); }
  std::unique_ptr<Primaries> make(bool hide_emitters = false) const {
    return std::make_unique<Primaries>(
        Primaries::View{table_, *scene_->sensors().front(), PathSettings{{}, hide_emitters}});
  }
  void expect_independent();
  static Rect tile_at(int x, int y) { return {4 * x, 4 * y, 4 * x + 4, 4 * y + 4}; }
  /// Returns 0 to 6 rays for each pixel of a tile.
  static std::vector<uint16_t> counts_of(int x, int y) {
    std::vector<uint16_t> counts(16);
    for (size_t i = 0; i < 16; ++i) counts[i] = static_cast<uint16_t>((i * 5 + 3 * x + y) % 7);
    return counts;
  }

  std::unique_ptr<Scene> scene_;
  transport::SceneTable table_;
  RenderCounters counters_;
};
class PrimariesThroughALens : public PrimariesTest {
 protected:
  PrimariesThroughALens() : PrimariesTest("thinlens") {}
};

void PrimariesTest::expect_independent() {
  const auto both = make(), single = make();
  Primaries &all = *both, &alone = *single;
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(all.add(tile_at(i % 4, i / 4), counts_of(i % 4, i / 4)));
  all.trace(9, counters_);
  ASSERT_EQ(all.tile_count(), 16u);
  for (int i = 0; i < 16; ++i) {
    alone.clear();
    const auto counts = counts_of(i % 4, i / 4);
    ASSERT_TRUE(alone.add(tile_at(i % 4, i / 4), counts));
    alone.trace(9, counters_);
    const TilePrimaries a = all.tile(i), b = alone.tile(0);
    EXPECT_EQ(a.size(), std::accumulate(counts.begin(), counts.end(), size_t{0}));
    for (size_t p = 0; p < 16; ++p) EXPECT_EQ(a.first(p + 1) - a.first(p), counts[p]);
    EXPECT_TRUE(rays_of(a) == rays_of(b)) << "tile " << i;
    EXPECT_EQ(a.width_at(2), b.width_at(2));
  }
}

TEST_F(PrimariesTest, OfTilesDoNotDependOnOneAnother) {
  expect_independent();
}
TEST_F(PrimariesThroughALens, OfTilesDoNotDependOnOneAnother) {
  expect_independent();
}

TEST_F(PrimariesTest, ArePrefixesOfOneSequence) {
  const auto few = make(), many = make();
  few->add(tile_at(1, 2), std::vector<uint16_t>(16, 3));
  many->add(tile_at(1, 2), std::vector<uint16_t>(16, 40));
  few->trace(4, counters_);
  many->trace(4, counters_);
  const auto a = rays_of(few->tile(0)), b = rays_of(many->tile(0));
  for (size_t pixel = 0; pixel < 16; ++pixel) {
    // The tile sorts its rays along a curve: the points are equal, but in another order.
    for (size_t i = 0; i < 3; ++i) {
      const auto begin = b.begin() + static_cast<ptrdiff_t>(40 * pixel);
      EXPECT_NE(std::find(begin, begin + 40, a[3 * pixel + i]), begin + 40);
    }
  }
}

TEST_F(PrimariesTest, AcceptOneTileOfAnySizeOrALimitedNumberOfTiles) {
  const auto primaries = make();
  const std::vector<uint16_t> huge(16, 700), few(16, 10);
  EXPECT_TRUE(primaries->add(tile_at(0, 0), huge));
  EXPECT_FALSE(primaries->add(tile_at(1, 0), few));
  primaries->trace(1, counters_);
  EXPECT_EQ(primaries->tile(0).size(), 16u * 700);
  size_t hits = 0;
  for (const Ray1& ray : rays_of(primaries->tile(0))) hits += ray.hit;
  EXPECT_GT(hits, 16u * 600);
  primaries->clear();
  EXPECT_TRUE(primaries->add(tile_at(1, 0), few));
  EXPECT_TRUE(primaries->add(tile_at(2, 0), few));
  primaries->trace(1, counters_);
  EXPECT_EQ(primaries->tile(1).size(), 160u);
}

TEST_F(PrimariesTest, MatchTheBsdfsAtTheirPoints) {
  const auto primaries = make();
  for (int i = 0; i < 16; ++i) primaries->add(tile_at(i % 4, i / 4), std::vector<uint16_t>(16, 4));
  primaries->trace(2, counters_);
  size_t with_form = 0, turned = 0;
  for (size_t t = 0; t < 16; ++t) {
    const TilePrimaries tile = primaries->tile(t);
    for (size_t i = 0; i < tile.size(); ++i) {
      if (!tile.hit(i) || !any(tile.shape(i).bsdf().lobes())) continue;
      const SurfaceInteraction si = tile.interaction(i);
      const Bsdf& bsdf = si.shape->bsdf();
      EXPECT_LT(glm::length(tile.viewer(i) - si.frame.to_world(si.wi)), 1e-6f);
      if (glm::dot(bsdf.reflection_frame(si).n, tile.viewer(i)) < 1e-3f) continue;
      EXPECT_LT(glm::length(tile.normal(i) - bsdf.reflection_frame(si).n), 1e-5f);
      const auto form = bsdf.form(si);
      ASSERT_EQ(tile.form_kind(i) != nullptr, form.has_value());
      if (!form) continue;
      ++with_form;
      turned += form->has_perturbed_normal;
      const BsdfForm own = tile.form(i);
      EXPECT_TRUE(own.same_kind(*form));
      EXPECT_LT(glm::length(own.diffuse - form->diffuse), 1e-5f);
      if (form->has_perturbed_normal) {
        EXPECT_LT(glm::length(own.surface_normal - form->surface_normal), 1e-5f);
      }
    }
  }
  EXPECT_GT(with_form, 500u);
  EXPECT_GT(turned, 50u);
}

TEST_F(PrimariesTest, SeeEmittersOrTheSurfaceBehind) {
  const auto seeing = make(), hiding = make(true);
  for (Primaries* primaries : {seeing.get(), hiding.get()}) {
    for (int i = 0; i < 16; ++i)
      primaries->add(tile_at(i % 4, i / 4), std::vector<uint16_t>(16, 4));
    primaries->trace(2, counters_);
  }
  size_t lamps = 0;
  for (size_t t = 0; t < 16; ++t) {
    const TilePrimaries a = seeing->tile(t), b = hiding->tile(t);
    for (size_t i = 0; i < a.size(); ++i) {
      const bool is_lamp = a.hit(i) && a.shape(i).emitter();
      lamps += is_lamp;
      if (a.hit(i)) {
        EXPECT_EQ(a.emitted(i), is_lamp ? Rgb(3, 2, 1) : Rgb(0.f));
      }
      EXPECT_EQ(b.emitted(i), Rgb(0.f));
      EXPECT_FALSE(b.hit(i) && b.shape(i).emitter());
    }
  }
  EXPECT_GT(lamps, 10u);
}

}  // namespace
}  // namespace kinome::test::primaries_test
