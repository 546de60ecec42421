/// `direct` against itself, and its parameters.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "direct_scenes.h"
#include "kinome/mesh_shape.h"
#include "kinome/bsdf.h"
#include "kinome/warp.h"

namespace kinome::test::direct_test {
namespace {

constexpr double kAlpha = 1e-4;

Rgb noise(int x, int y) {
  const auto unit = [&](int c) { return static_cast<float>((x * 7 + y * 13 + c * 5) % 11); };
  return 0.125f * Rgb(1 + unit(0), 1 + unit(1), 1 + unit(2));
}

/// Two glossy spheres on a diffuse floor: soft shadows, reflections, a silhouette.
std::string still_life(const std::string& turn = "") {
  const auto sphere = [&](const char* place, const char* bsdf) {
    return "<shape type=\"sphere\"><transform name=\"to_world\"><translate value=\"" +
           std::string(place) + "\"/>" + turn + "</transform>" + bsdf + "</shape>";
  };
  return sphere("-1.1 1 0",
                "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.3\"/></bsdf>") +
         sphere("1.1 1 0", "<bsdf type=\"plastic\"/>") +
         "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"50\"/>"
         "<rotate x=\"1\" angle=\"-90\"/>" +
         turn + "</transform>" + diffuse_xml("0.2 0.5 0.8") + "</shape>";
}

std::string view(const std::string& turn = "", const std::string& sampler = "independent",
                 const std::string& pixel_format = "rgb", int side = 6) {
  return sensor_xml("perspective", look_at("0 3 6", "0 0.8 0", "0 1 0") + turn, side, 16, sampler,
                    pixel_format);
}

TEST(Direct, TechniquesAgree) {
  const TemporaryFolder folder;
  const std::string scene = still_life() + envmap_xml(folder, 16, 9, noise);
  const auto render_with = [&](int emitter, int bsdf, uint64_t seed) {
    return estimate_pixels(*scene_from(scene + view() + direct_xml(samples_xml(emitter, bsdf))),
                           kRenders, seed);
  };
  // Each has its own seeds, because the test requires independent estimates.
  const auto both = render_with(1, 1, 1);
  expect_equal(both, render_with(0, 1, 10001), kAlpha, "BSDF sampling alone");
  expect_equal(both, render_with(3, 2, 30001), kAlpha, "3 + 2");
}

/// Emitter sampling alone can't find what a delta lobe shows: a scene without delta lobes.
TEST(Direct, EmitterSamplingAloneAgreesWithoutDeltaLobes) {
  const TemporaryFolder folder;
  const std::string scene = floor_xml(diffuse_xml("0.5")) + envmap_xml(folder, 16, 9, noise) +
                            "<shape type=\"cube\"><bsdf type=\"roughconductor\"><float "
                            "name=\"alpha\" value=\"0.3\"/></bsdf></shape>";
  const auto render_with = [&](int emitter, int bsdf, uint64_t seed) {
    return estimate_pixels(*scene_from(scene + view() + direct_xml(samples_xml(emitter, bsdf))),
                           kRenders, seed);
  };
  const auto both = render_with(1, 1, 1);
  expect_equal(both, render_with(1, 0, 20001), kAlpha, "emitter sampling alone");
  expect_equal(both, render_with(0, 1, 30001), kAlpha, "BSDF sampling alone");
}

TEST(Direct, CompensatedSamplingAgrees) {
  const TemporaryFolder folder;
  std::string map = envmap_xml(folder, 16, 9, noise);
  map.insert(map.rfind("</emitter>"), "<boolean name=\"mis_compensation\" value=\"true\"/>");
  // Without BSDF samples, many samples are needed to find the light that compensation leaves to
  // them. The spheres' delta lobes are missing on both sides.
  for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1024, 0}}) {
    const auto reference = scene_from(still_life() + envmap_xml(folder, 16, 9, noise) + view() +
                                      direct_xml(samples_xml(emitter, bsdf)));
    const auto compensated =
        scene_from(still_life() + map + view() + direct_xml(samples_xml(emitter, bsdf)));
    expect_equal(estimate_pixels(*reference, kRenders, 1),
                 estimate_pixels(*compensated, kRenders, 50001), kAlpha, "compensated");
  }
}

TEST(Direct, TurningEverythingChangesNothing) {
  const TemporaryFolder plain_folder, turned_folder;
  const std::string turn = "<rotate y=\"1\" angle=\"77\"/><rotate x=\"1\" angle=\"40\"/>";
  const auto plain =
      scene_from(still_life() + envmap_xml(plain_folder, 16, 9, noise) + view() + direct_xml());
  const auto turned = scene_from(still_life(turn) + envmap_xml(turned_folder, 16, 9, noise, turn) +
                                 view(turn) + direct_xml());
  expect_equal(estimate_pixels(*plain, kRenders, 1), estimate_pixels(*turned, kRenders, 70001),
               kAlpha, "turned");
}

TEST(Direct, SameBitsAtAnyThreadCount) {
  const TemporaryFolder folder;
  for (const char* sampler : kSamplers) {
    const auto scene =
        scene_from(still_life() + envmap_xml(folder, 16, 9, noise) + view("", sampler, "rgba", 40) +
                   direct_xml("<integer name=\"shading_samples\" value=\"2\"/>"));
    const Image one = render_scene(*scene, 5, 1), two = render_scene(*scene, 5, 2);
    EXPECT_EQ(one.data, two.data) << sampler;
    EXPECT_NE(one.data, render_scene(*scene, 6, 2).data) << sampler;
  }
}

/// The sky is visible unless hidden, and then has an alpha of 1, as with Mitsuba's `path`.
/// (Mitsuba's `direct` gives the background 0 in either case.)
TEST(Direct, HidesEmitters) {
  const std::string scene =
      "<shape type=\"sphere\">" + diffuse_xml("0.5") + "</shape>" + constant_xml("1") +
      sensor_xml("orthographic", "<scale value=\"3\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"), 9, 16,
                 "independent", "rgba");
  for (const bool hide : {false, true}) {
    const auto loaded =
        scene_from(scene + direct_xml(std::string("<boolean name=\"hide_emitters\" value=\"") +
                                      (hide ? "true" : "false") + "\"/>"));
    const Image image = render_scene(*loaded);
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    EXPECT_EQ(image.at(0, 0, 0), hide ? 0 : 1);
    EXPECT_EQ(image.at(0, 0, 3), hide ? 0 : 1);
    EXPECT_NEAR(image.at(4, 4, 0), 0.5, 0.2);
    EXPECT_EQ(image.at(4, 4, 3), 1);
  }
}

TEST(Direct, CountsItsRays) {
  const auto scene = scene_from(floor_xml(diffuse_xml("0.5")) + constant_xml("1") + view() +
                                direct_xml(samples_xml(3, 2)));
  RenderContext context({});
  render(*scene, *scene->sensors()[0], context);
  const RenderCounters& counters = context.job.stats().counters;
  const uint64_t primaries = 6 * 6 * 16;
  EXPECT_EQ(counters.rays[static_cast<int>(RayKind::kCamera)], primaries);
  const uint64_t shadow = counters.rays[static_cast<int>(RayKind::kShadow)];
  const uint64_t bsdf = counters.rays[static_cast<int>(RayKind::kBsdf)];
  EXPECT_EQ(bsdf + shadow + counters.skipped_shadow_rays, primaries * 5);
  EXPECT_EQ(bsdf, primaries * 2);
  // Half of the sky is below the floor: no ray goes there.
  EXPECT_NEAR(double(shadow), primaries * 1.5, 5 * std::sqrt(primaries * 3 * 0.25));
  for (const char* stage : {"primary", "shade", "shadow", "film"}) {
    EXPECT_GT(counters.stage_seconds.at(stage), 0) << stage;
  }
  EXPECT_FALSE(context.job.stats().skipped.empty());
}

std::string error_of(const std::string& parameters) {
  try {
    make<Integrator>(direct_xml(parameters));
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Direct, ChecksItsParameters) {
  const std::string shading = "<integer name=\"shading_samples\" value=\"2\"/>";
  EXPECT_EQ(error_of(shading), "");
  EXPECT_EQ(error_of("<integer name=\"emitter_samples\" value=\"3\"/>"), "");
  EXPECT_EQ(error_of(samples_xml(0, 1)), "");
  EXPECT_NE(error_of(shading + "<integer name=\"bsdf_samples\" value=\"1\"/>").find("together"),
            std::string::npos);
  EXPECT_NE(error_of(samples_xml(0, 0)).find("at least one"), std::string::npos);
  EXPECT_NE(error_of(samples_xml(-1, 1)).find("got -1"), std::string::npos);
}

// ---- emitters for which the project has no plugin ----

/// A horizontal square of side 2 `half` at height `height`, which emits downward.
struct SquareLight final : Emitter {
  float half = 1, height = 2;
  Rgb radiance{3, 2, 1};
  bool is_surface() const override { return true; }
  Rgb eval_surface(const SurfaceInteraction& si) const override {
    return si.wi.z > 0 ? radiance : Rgb(0.f);
  }
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const override {
    const Vec3 to(half * (2 * u.x - 1) - p.x, height - p.y, half * (2 * u.y - 1) - p.z);
    DirectSample sample;
    sample.distance = glm::length(to);
    sample.d = to / sample.distance;
    sample.pdf = density(sample.distance, sample.d.y);
    sample.radiance = radiance;
    return sample;
  }
  float pdf_surface(const Vec3& p, const SurfaceInteraction& si) const override {
    const Vec3 to = si.p - p;
    return density(glm::length(to), to.y / glm::length(to));
  }
  float density(float distance, float cosine) const {
    return distance * distance / (cosine * 4 * half * half);
  }
};

/// Parallel light from straight above.
struct SunAbove final : Emitter {
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override {
    DirectSample sample;
    sample.d = Vec3(0, 1, 0);
    sample.pdf = 1;
    sample.radiance = Rgb(0.5, 1, 1.5);
    sample.is_delta = true;
    return sample;
  }
};

/// Light from the whole upper hemisphere that belongs to no surface and no environment: no ray
/// hits it.
struct GlowAbove final : Emitter {
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2& u) const override {
    DirectSample sample;
    sample.d = square_to_uniform_sphere(u);
    sample.d.y = std::abs(sample.d.y);
    sample.pdf = 2 * kUniformSpherePdf;
    sample.radiance = Rgb(1, 2, 3);
    return sample;
  }
};

struct SquareShape final : MeshShape {
  explicit SquareShape(const Properties& props, const SquareLight& light) : MeshShape(props) {
    const float h = light.half, y = light.height;
    mesh_.positions = {{-h, y, -h}, {h, y, -h}, {h, y, h}, {-h, y, h}};
    mesh_.triangles = {{0, 1, 2}, {0, 2, 3}};  // counter-clockwise from below
    finish(props, Transform(), true, false);
  }
};

struct Lights {
  bool square = false, sun = false, glow = false;
  std::string environment;  ///< XML
};

/// A diffuse floor under several emitters. The camera looks at its centre, past them.
std::unique_ptr<Scene> lit_floor(const Lights& lights, int emitter_samples, int bsdf_samples) {
  Scene::Contents contents;
  contents.shapes.push_back(make<Shape>(floor_xml(diffuse_xml("0.5"))));
  if (lights.square) {
    const auto light = std::make_shared<SquareLight>();
    Properties props(Category::kShape, "square", {});
    props.set("light", std::static_pointer_cast<Object>(light), {});
    contents.shapes.push_back(std::make_shared<SquareShape>(props, *light));
    contents.shapes.back()->set_bsdf(make<Bsdf>("<bsdf type=\"diffuse\"/>"));
  }
  if (lights.sun) contents.emitters.push_back(std::make_shared<SunAbove>());
  if (lights.glow) contents.emitters.push_back(std::make_shared<GlowAbove>());
  if (!lights.environment.empty()) contents.emitters.push_back(make<Emitter>(lights.environment));
  contents.integrator = make<Integrator>(direct_xml(samples_xml(emitter_samples, bsdf_samples)));
  // The view is so narrow that the irradiance is that of the origin.
  contents.sensors.push_back(make<Sensor>(
      sensor_xml("orthographic", "<scale value=\"0.01\"/>" + look_at("3 0.5 0", "0 0 0"), 3, 16)));
  return std::make_unique<Scene>(std::move(contents), 1);
}

/// Form factor from a point to a parallel square above it: four right-angled corners (Howell,
/// Catalog of radiation heat transfer configuration factors, B-3).
double square_form_factor(double half, double height) {
  const double a = half / height, r = std::sqrt(1 + a * a);
  return 4 / (2 * std::numbers::pi) * 2 * (a / r) * std::atan(a / r);
}

TEST(Direct, LightsAFloorFromASquare) {
  const Rgb expected = 0.5f * Rgb(3, 2, 1) * static_cast<float>(square_form_factor(1, 2));
  for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {0, 1}, {2, 3}}) {
    const auto scene = lit_floor({true, false, false, ""}, emitter, bsdf);
    expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 9), kAlpha,
                 std::to_string(emitter) + " + " + std::to_string(bsdf));
  }
}

/// The light is alone, or beside light that rays hit.
TEST(Direct, LightThatNoRayMeetsIsTheEmitterSamplesAlone) {
  for (const bool sky : {false, true}) {
    const Rgb expected = 0.5f * (Rgb(1, 2, 3) + (sky ? Rgb(1, 1, 2) : Rgb(0.f)));
    for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {2, 3}}) {
      const auto scene =
          lit_floor({false, false, true, sky ? constant_xml("1 1 2") : ""}, emitter, bsdf);
      expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 9), kAlpha,
                   std::to_string(emitter) + " + " + std::to_string(bsdf));
    }
  }
}

/// The square hides part of the sky and emits itself. Delta light is only sampled by emitters.
TEST(Direct, PicksAmongManyEmitters) {
  const auto f = static_cast<float>(square_form_factor(1, 2));
  const auto expected = [&](bool square, bool sun, bool sky) {
    Rgb irradiance(0.f);
    if (square) irradiance += kPi * f * Rgb(3, 2, 1);
    if (sun && !square) irradiance += Rgb(0.5, 1, 1.5);
    if (sky) irradiance += kPi * (square ? 1 - f : 1) * Rgb(1, 1, 2);
    return 0.5f * irradiance / kPi;
  };
  for (int mask = 1; mask < 8; ++mask) {
    const bool square = mask & 1, sun = mask & 2, sky = mask & 4;
    const auto scene = lit_floor({square, sun, false, sky ? constant_xml("1 1 2") : ""}, 2, 1);
    if (mask == 2) {  // one delta emitter: exact
      for (const Estimate& pixel : channel(estimate_pixels(*scene, 2), 1)) {
        EXPECT_NEAR(pixel.mean, expected(square, sun, sky).y, 1e-6);
      }
      continue;
    }
    expect_equal(estimate_pixels(*scene, kRenders), exactly(expected(square, sun, sky), 9), kAlpha,
                 "lights " + std::to_string(mask));
  }
}

/// For neighbouring points of a lamp, rounding decides on which side of one the other is.
TEST(Direct, LampsThatShineInwardAreBlackFromOutside) {
  const auto clustered = [](const std::string& importance, int max_depth) {
    return "<integrator type=\"clustered\"><string name=\"importance\" value=\"" + importance +
           "\"/><boolean name=\"trial\" value=\"false\"/><integer name=\"max_depth\" value=\"" +
           std::to_string(max_depth) + "\"/></integrator>";
  };
  const auto picture = [](const std::string& shape, bool shines_inward,
                          const std::string& integrator) {
    const std::string lamp = "<shape type=\"" + shape +
                             "\"><boolean name=\"flip_normals\" value=\"" +
                             (shines_inward ? "true" : "false") +
                             "\"/><transform name=\"to_world\"><rotate y=\"1\" angle=\"90\"/>"
                             "<translate x=\"0.4\" y=\"0.6\" z=\"-0.5\"/></transform>"
                             "<bsdf type=\"twosided\">" +
                             diffuse_xml("0.5") + "</bsdf><emitter type=\"area\"/></shape>";
    return render_scene(*scene_from(
        lamp + sensor_xml("perspective", look_at("1 4 2", "0.9 0.6 -0.5", "0 0 1"), 16, 64) +
        integrator));
  };
  for (const char* shape : {"sphere", "cylinder"}) {
    EXPECT_GE(picture(shape, false, direct_xml()).at(8, 8, 0), 1) << shape;
    for (const std::string& integrator :
         {direct_xml(), std::string("<integrator type=\"path\"/>"), clustered("product", 2),
          clustered("product", 3), clustered("joint", 2), clustered("joint", 3)}) {
      for (const float value : picture(shape, true, integrator).data) {
        ASSERT_EQ(value, 0) << shape << integrator;
      }
    }
  }
}

}  // namespace
}  // namespace kinome::test::direct_test
