// One ray determines a lamp's light at a point. In the shadow of a strong lamp, a fainter one must
// be free of the noise of the strong one's control terms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/paths/path_scenes.h"
#include "product_scenes.h"

namespace kinome::test::product_lamps_test {
namespace {

constexpr int kWidth = 64, kHeight = 48;
const std::string kSun =
    "<emitter type=\"directional\"><vector name=\"direction\" x=\"-1\" y=\"-2\" z=\"-.5\"/>"
    "<rgb name=\"irradiance\" value=\"40\"/></emitter>";
const std::string kFaint = point_xml("0,3,3", ".05");

Arrangement lit_by(const std::string& light) {
  Arrangement s;
  s.light = light;
  s.rays = 96;
  s.film = integer("width", kWidth) + integer("height", kHeight) + "<rfilter type=\"box\"/>";
  return s;
}

std::vector<float> picture(const Scene& scene, uint64_t seed) {
  const Image image = render_scene(scene, seed, 2);
  std::vector<float> red;
  for (size_t i = 0; i < image.data.size(); i += image.channels.size()) {
    red.push_back(image.data[i]);
  }
  return red;
}

template <class Function>
void for_neighbours(int x, int y, const Function& fn) {
  for (int j = std::max(0, y - 1); j <= std::min(kHeight - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(kWidth - 1, x + 1); ++i) fn(j * kWidth + i);
  }
}

TEST(ProductLamps, ShadeOfOneIsFreeOfItsNoise) {
  Arrangement exact = lit_by(kSun);
  exact.direct_samples = 64;
  const std::vector<float> sun = picture(*direct_scene(exact), 1);
  exact.light = kFaint;
  const std::vector<float> faint = picture(*direct_scene(exact), 1);
  std::vector<int> shaded;  // not lit by the sun, and evenly lit by the faint lamp
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float max_sun = 0, least = INFINITY, most = 0;
      for_neighbours(x, y, [&](int i) {
        max_sun = std::max(max_sun, sun[i]);
        least = std::min(least, faint[i]);
        most = std::max(most, faint[i]);
      });
      if (max_sun == 0 && least > 0 && most < 1.5f * least) shaded.push_back(y * kWidth + x);
    }
  }
  ASSERT_GT(shaded.size(), 50u);
  const auto both = product_scene(lit_by(kSun + kFaint));
  float worst = 0;
  for (uint64_t seed = 1; seed <= 16; ++seed) {
    const std::vector<float> found = picture(*both, seed);
    for (const int i : shaded) worst = std::max(worst, std::abs(found[i] / faint[i] - 1));
  }
  EXPECT_LT(worst, 0.2f);
}

/// The pilot's rays to a lamp show which pixels are on edges of its shadows. These get camera rays.
TEST(ProductLamps, EdgesOfShadowsGetCameraRays) {
  Arrangement s = lit_by(kSun);
  s.direct_samples = 256;
  const std::vector<float> sun = picture(*direct_scene(s), 1);
  const auto scene = product_scene(s);
  constexpr int kSeeds = 16;
  std::vector<double> sum(sun.size()), squares(sun.size());
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<float> found = picture(*scene, seed);
    for (size_t i = 0; i < sun.size(); ++i) {
      sum[i] += found[i];
      squares[i] += found[i] * found[i];
    }
  }
  const float lit = *std::max_element(sun.begin(), sun.end());
  double variance = 0, edges = 0;
  for (size_t i = 0; i < sun.size(); ++i) {
    if (sun[i] < 0.02f * lit || sun[i] > 0.5f * lit) continue;
    edges += 1;
    variance += (squares[i] - sum[i] * sum[i] / kSeeds) / (kSeeds - 1) / (sun[i] * sun[i]);
  }
  ASSERT_GT(edges, 30);
  // The variance is .0013 if they do and .012 if they don't. It is measured with about 380 pixels
  // and 16 seeds, so that its own standard deviation is a few percent.
  EXPECT_LT(variance / edges, 0.004);
}

}  // namespace
}  // namespace kinome::test::product_lamps_test
