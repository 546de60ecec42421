/// `direct` against radiances in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "direct_scenes.h"
#include "kinome/bsdf.h"

namespace kinome::test::closed_form_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 60 z-tests
constexpr double kPiD = std::numbers::pi;

/// A diffuse plane of any orientation turns a constant radiance L into reflectance x L.
TEST(ClosedForm, ConstantEnvironmentOnADiffusePlane) {
  for (const char* sampler : kSamplers) {
    for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {0, 1}, {3, 2}}) {
      const auto scene =
          scene_from(floor_xml(diffuse_xml("0.2 0.5 0.8")) + constant_xml("1 2 3") +
                     direct_xml(samples_xml(emitter, bsdf)) +
                     sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 3, 16, sampler));
      const auto rendered = estimate_pixels(*scene, kRenders);
      // BSDF sampling of a diffuse surface is exact: only rounding errors remain.
      if (emitter == 0) {
        for (size_t i = 0; i < rendered.size(); ++i) {
          EXPECT_NEAR(rendered[i].mean, Rgb(0.2, 1, 2.4)[static_cast<int>(i % 3)], 1e-5) << sampler;
        }
        continue;
      }
      expect_equal(rendered, exactly(Rgb(0.2, 1, 2.4), 9), kAlpha,
                   sampler + (", " + std::to_string(emitter)) + " + " + std::to_string(bsdf));
    }
  }
}

/// A single bright texel is a tent of radiance, as wide as two texels. Its irradiance on a plane
/// under the pole is L dphi (sin 2 theta0) / 2 dtheta (sin dtheta / dtheta)².
struct Sun {
  static constexpr int kWidth = 64, kHeight = 33, kX = 0, kY = 7;
  static constexpr float kRadiance = 5000;
  static Rgb texel(int x, int y) { return x == kX && y == kY ? Rgb(kRadiance) : Rgb(0.f); }
  static double irradiance() {
    const double dphi = 2 * kPiD / kWidth, dtheta = kPiD / (kHeight - 1);
    const double theta = kY * dtheta;
    return kRadiance * dphi * 0.5 * std::sin(2 * theta) * dtheta *
           std::pow(std::sin(dtheta) / dtheta, 2);
  }
};

TEST(ClosedForm, SingleTexelAsASun) {
  const TemporaryFolder folder;
  const double expected = 0.5 * Sun::irradiance() / kPiD;
  for (const char* sampler : kSamplers) {
    for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {4, 4}}) {
      const auto scene =
          scene_from(floor_xml(diffuse_xml("0.5")) +
                     envmap_xml(folder, Sun::kWidth, Sun::kHeight, Sun::texel) +
                     direct_xml(samples_xml(emitter, bsdf)) +
                     sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 3, 16, sampler));
      expect_equal(estimate_pixels(*scene, kRenders), exactly(Rgb(expected), 9), kAlpha,
                   sampler + (", " + std::to_string(emitter)) + " + " + std::to_string(bsdf));
    }
  }
}

/// The map is rotated, so that the floor faces its column -1/2. A sun at phi0 then shines with the
/// cosine cos phi sin theta. The irradiance is L dphi cos phi0 (sin(dphi/2) / (dphi/2))²
/// dtheta (1 - cos(2 theta0) (sin dtheta / dtheta)²) / 2. This value differs between columns.
TEST(ClosedForm, SingleTexelOfARotatedMap) {
  constexpr int kWidth = 64, kHeight = 33, kX = 12, kY = 14;
  const double dphi = 2 * kPiD / kWidth, dtheta = kPiD / (kHeight - 1);
  const double phi = (kX + 0.5) * dphi, theta = kY * dtheta;
  const double expected = 0.5 / kPiD * Sun::kRadiance * dphi * std::cos(phi) *
                          std::pow(std::sin(dphi / 2) / (dphi / 2), 2) * 0.5 * dtheta *
                          (1 - std::cos(2 * theta) * std::pow(std::sin(dtheta) / dtheta, 2));
  const TemporaryFolder folder;
  const auto sun = [](int x, int y) { return x == kX && y == kY ? Rgb(Sun::kRadiance) : Rgb(0.f); };
  for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {0, 8}}) {
    const auto scene = scene_from(
        floor_xml(diffuse_xml("0.5")) +
        envmap_xml(folder, kWidth, kHeight, sun, "<rotate x=\"1\" angle=\"90\"/>") +
        direct_xml(samples_xml(emitter, bsdf)) +
        sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 3, bsdf == 8 ? 256 : 16, "sobol"));
    expect_equal(estimate_pixels(*scene, kRenders), exactly(Rgb(expected), 9), kAlpha,
                 std::to_string(emitter) + " + " + std::to_string(bsdf));
  }
}

/// The sun and a wall are on the same side of the zenith: the wall's shadow is black, the rest is
/// lit.
TEST(ClosedForm, ShadowsAreBlack) {
  const TemporaryFolder folder;
  // Column 0 of 64 is near -z: the wall at z = -1 hides the sun from the floor in front of it.
  const std::string wall =
      "<shape type=\"cube\"><transform name=\"to_world\"><scale x=\"50\" y=\"50\" z=\"0.1\"/>"
      "<translate x=\"0\" y=\"0\" z=\"-1\"/></transform></shape>";
  for (const bool is_shadowed : {true, false}) {
    const auto scene =
        scene_from((is_shadowed ? wall : "") + floor_xml(diffuse_xml("0.5")) +
                   envmap_xml(folder, Sun::kWidth, Sun::kHeight, Sun::texel) + direct_xml() +
                   sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 4, 16));
    const Image image = render_scene(*scene);
    for (const float value : image.data) EXPECT_EQ(value == 0, is_shadowed);
  }
}

struct Material {
  const char* name;
  const char* xml;
};

constexpr Material kMaterials[] = {
    {"diffuse", "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.2 0.5 0.9\"/></bsdf>"},
    {"two-sided", "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf>"},
    {"phong",
     "<bsdf type=\"phong\"><float name=\"exponent\" value=\"20\"/><rgb "
     "name=\"specular_reflectance\" "
     "value=\"0.3 0.2 0.1\"/></bsdf>"},
    {"ward",
     "<bsdf type=\"ward\"><float name=\"alpha_u\" value=\"0.2\"/><float name=\"alpha_v\" "
     "value=\"0.2\"/></bsdf>"},
    {"conductor", "<bsdf type=\"conductor\"><string name=\"material\" value=\"Cu\"/></bsdf>"},
    {"roughconductor, Beckmann",
     "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/><float name=\"alpha\" "
     "value=\"0.3\"/></bsdf>"},
    {"roughconductor, GGX",
     "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/><string "
     "name=\"distribution\" value=\"ggx\"/><float name=\"alpha\" value=\"0.2\"/></bsdf>"},
    {"plastic", "<bsdf type=\"plastic\"/>"},
    {"roughplastic", "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.2\"/></bsdf>"},
};

/// Returns the albedo of a material seen at cos theta: its values integrated over the hemisphere by
/// midpoints in (cos theta, phi), plus the weights of its delta lobes.
Rgb albedo(const Bsdf& bsdf, float cos_theta) {
  SurfaceInteraction si;
  si.wi = Vec3(std::sqrt(1 - cos_theta * cos_theta), 0, cos_theta);
  glm::dvec3 sum(0);
  constexpr int kSteps = 100;
  for (int i = 0; i < kSteps; ++i) {
    const float z = (i + 0.5f) / kSteps, r = std::sqrt(1 - z * z);
    for (int j = 0; j < 2 * kSteps; ++j) {
      const float phi = kPi * (j + 0.5f) / kSteps;
      sum += glm::dvec3(
          bsdf.eval_pdf(si, Lobe::kAll, Vec3(r * std::cos(phi), r * std::sin(phi), z)).f);
    }
  }
  sum *= kPiD / (double(kSteps) * kSteps);
  if (any(bsdf.lobes() & Lobe::kDelta)) {
    const auto sample = bsdf.sample(si, Lobe::kDelta, 0.5f, Vec2(0.5f));
    if (sample) sum += glm::dvec3(sample->weight);
  }
  return Rgb(sum);
}

/// A sphere in a white furnace shows each material's albedo at the angle of every point.
TEST(ClosedForm, FurnaceShowsTheAlbedo) {
  constexpr int kSide = 5, kSubpixels = 60;
  for (const Material& material : kMaterials) {
    const auto bsdf = make<Bsdf>(material.xml);
    std::vector<Rgb> table;  // over cos theta, at midpoints
    for (int i = 0; i < 64; ++i) table.push_back(albedo(*bsdf, (i + 0.5f) / 64));
    const auto value = [&](float cos_theta) {
      const float at = std::clamp(cos_theta * 64 - 0.5f, 0.f, 62.999f);
      const int i = static_cast<int>(at);
      return glm::mix(table[i], table[i + 1], at - static_cast<float>(i));
    };
    std::vector<Estimate> expected;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        glm::dvec3 sum(0);
        for (int k = 0; k < kSubpixels * kSubpixels; ++k) {
          // Orthographic, [-1, 1] at scale 1.25.
          const double px = x + (k % kSubpixels + 0.5) / kSubpixels;
          const double py = y + (k / kSubpixels + 0.5) / kSubpixels;
          const double a = 1.25 * (2 * px / kSide - 1), b = 1.25 * (2 * py / kSide - 1);
          const double r2 = a * a + b * b;
          sum += r2 < 1 ? glm::dvec3(value(static_cast<float>(std::sqrt(1 - r2)))) : glm::dvec3(1);
        }
        sum /= kSubpixels * kSubpixels;
        for (int c = 0; c < 3; ++c) expected.push_back({sum[c], 0});
      }
    }
    const auto scene = scene_from(
        "<shape type=\"sphere\">" + std::string(material.xml) + "</shape>" + constant_xml("1") +
        direct_xml() +
        sensor_xml("orthographic", "<scale value=\"1.25\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"),
                   kSide, 16));
    expect_equal(estimate_pixels(*scene, kRenders), expected, kAlpha, material.name);
  }
}

TEST(ClosedForm, NoLightIsBlack) {
  const TemporaryFolder folder;
  const std::string black = envmap_xml(folder, 4, 3, [](int, int) { return Rgb(0.f); });
  for (const std::string& light : {std::string(), constant_xml("0"), black}) {
    const auto scene = scene_from(floor_xml(diffuse_xml("0.5")) + light + direct_xml() +
                                  sensor_xml("perspective", look_at("0 3 1", "0 0 0"), 4, 4));
    RenderContext context({});
    const Image image = render(*scene, *scene->sensors()[0], context);
    for (const float value : image.data) EXPECT_EQ(value, 0);
    EXPECT_EQ(context.job.stats().counters[RayKind::kShadow], 0u);
    EXPECT_EQ(context.job.stats().counters[RayKind::kBsdf], 0u);
    EXPECT_EQ(context.job.stats().non_finite_samples, 0u);
  }
}

}  // namespace
}  // namespace kinome::test::closed_form_test
