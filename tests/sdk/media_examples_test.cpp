// Renders media, phase functions and volumes of tests/sdk/project.

#include <cmath>

#include "sdk.h"

namespace kinome::test::media_examples_test {
namespace {

constexpr int kSamples = 4096;

/// Returns a ray along +x at the height y through the unit cube, which a medium fills, under a
/// white sky.
std::string ray_scene(double y, const std::string& medium) {
  return "<scene version='3.0.0'><integrator type='volpath'/><sensor type='radiancemeter'>"
         "<point name='origin' x='-3' y='" +
         std::to_string(y) +
         "' z='0.4'/><vector name='direction' x='1' y='0' z='0'/><sampler type='independent'>"
         "<integer name='sample_count' value='" +
         std::to_string(kSamples) +
         "'/></sampler><film type='hdrfilm'><integer name='width' value='1'/><integer "
         "name='height' value='1'/><string name='component_format' value='float32'/><rfilter "
         "type='box'/></film></sensor><emitter type='constant'/><shape type='cube'><transform "
         "name='to_world'><scale value='0.5'/><translate x='0.5' y='0.5' z='0.5'/></transform>"
         "<bsdf type='null'/>" +
         medium + "</shape></scene>";
}

/// The radiance behind a black medium is its transmittance T. A sample is between 0 and 1, so that
/// the standard deviation of the mean is at most sqrt(T (1 - T) / kSamples).
void expect_transmittance(const Image& image, double depth) {
  ASSERT_EQ(image.width, 1);
  const double expected = std::exp(-depth);
  EXPECT_NEAR(image.at(0, 0, 0), expected, 5 * std::sqrt(expected * (1 - expected) / kSamples));
}

TEST_F(Sdk, MistIsTransparentAsDerived) {
  const std::string mist =
      "<medium type='mist' name='interior'><float name='albedo' value='0'/></medium>";
  expect_transmittance(render_text(ray_scene(0.25, mist)), 2 * std::exp(-0.25 / 0.5));
}

TEST_F(Sdk, HazeIsTransparentAsDerived) {
  const std::string haze =
      "<medium type='heterogeneous' name='interior'><float name='albedo' value='0'/><volume "
      "type='haze' name='sigma_t'/><float name='scale' value='3'/></medium>";
  expect_transmittance(render_text(ray_scene(0.25, haze)), 3 * std::exp(-0.25 / 0.3));
}

/// A white medium under a white sky is as bright as the sky, whatever its phase function.
TEST_F(Sdk, SchlickScattersAllLight) {
  const Image image = render_text(
      ray_scene(0.3,
                "<medium type='homogeneous' name='interior'><float name='albedo' value='1'/><float "
                "name='sigma_t' value='2'/><phase type='schlick'/></medium>"));
  ASSERT_EQ(image.width, 1);
  // Weights of emitter and phase samples add up to 1 only on average; samples are below 3.
  EXPECT_NEAR(image.at(0, 0, 0), 1, 5 * std::sqrt(2. / kSamples));
}

}  // namespace
}  // namespace kinome::test::media_examples_test
