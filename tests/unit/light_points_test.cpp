// Points of local light: what each pass draws has numbers that estimators can use.
#include <gtest/gtest.h>

#include <cmath>

#include "light_point_draw.h"
#include "support/render.h"

namespace kinome::test {
namespace {

/// In a spot as narrow as a float's rounding, many rays that were drawn come out beyond its rim,
/// where no ray is drawn: light of such points is the eye rays' alone. Their ratio of densities
/// must stay a number, by any density that it is multiplied by, 0 included.
TEST(LightPoints, OfANarrowSpotHaveFiniteRatios) {
  size_t eye_rays = 0;
  for (const char* const angle : {"20", ".2", ".02", ".005"}) {
    const auto scene = scene_from(std::string(R"(<scene version="3.0.0"><emitter type="spot">
        <float name="cutoff_angle" value=")") +
                                  angle + R"("/><float name="beam_width" value=")" + angle + R"("/>
        <transform name="to_world"><lookat origin="1,2,3" target="0,0,.1" up="0,1,0"/></transform>
        </emitter><shape type="rectangle"><transform name="to_world"><scale value="9"/></transform></shape></scene>)");
    size_t count = 0;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
      RenderContext context({.threads = 1, .seed = seed});
      const LocalLight light(*scene, {.max_depth = 3}, {}, seed, context);
      for (const LightPoint& p : light.draw(seed, context).points) {
        ++count;
        EXPECT_TRUE(std::isfinite(p.eye_ratio) && std::isfinite(p.eye_ratio * 0.f)) << angle;
        EXPECT_GE(p.eye_ratio, 0) << angle;
        eye_rays += p.eye_ratio > 1e20f;
      }
    }
    EXPECT_GT(count, 1000) << angle;
  }
  EXPECT_GT(eye_rays, 0) << "no ray came out beyond the rim: this test is of no use";
}

}  // namespace
}  // namespace kinome::test
