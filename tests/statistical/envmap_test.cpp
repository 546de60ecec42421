/// Tests of environment maps: their radiance, light points, and invalid input.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "envmap_cases.h"
#include "kinome/image_files.h"
#include "kinome/color.h"
#include "kinome/sphere_partition.h"
#include "support/statistics.h"

namespace kinome::test::envmap_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of the only statistical test here

struct Reference {
  Vec3 d;
  Rgb radiance;
};

/// Values of Mitsuba 3.9.1, scalar_rgb: `envmap` of the 5 x 4 bitmap noise(x, y), scale 2, without
/// and with to_world = rotate(x, -50) rotate(y, 30). eval() was called for interactions whose wi is
/// -d, with eight normally distributed random directions each. All values are rounded to six
/// digits.
const Reference kPlain[] = {
    {{0.618984f, -0.775100f, 0.126804f}, {0.512654f, 1.677556f, 1.898463f}},
    {{-0.749577f, -0.597593f, -0.284634f}, {1.833304f, 1.767022f, 1.583304f}},
    {{-0.914149f, -0.104961f, -0.391554f}, {1.801274f, 1.478170f, 1.551274f}},
    {{0.992154f, 0.067414f, -0.105286f}, {1.335459f, 1.551919f, 1.883057f}},
    {{-0.219732f, -0.521855f, -0.824248f}, {2.275893f, 1.608448f, 2.025893f}},
    {{-0.587884f, 0.724993f, -0.358857f}, {1.800392f, 0.926642f, 1.550392f}},
    {{0.978625f, -0.204155f, 0.024788f}, {0.971155f, 1.578015f, 2.195933f}},
    {{0.901241f, 0.317806f, -0.294557f}, {1.456047f, 1.596958f, 1.468170f}},
};
const Reference kTurned[] = {
    {{-0.090628f, 0.267923f, 0.959168f}, {1.531195f, 1.417396f, 1.281195f}},
    {{-0.252895f, -0.228450f, 0.940136f}, {1.410663f, 2.221484f, 1.160663f}},
    {{-0.690153f, -0.227119f, 0.687100f}, {1.544524f, 1.979826f, 1.294524f}},
    {{0.651207f, 0.102690f, 0.751920f}, {1.538720f, 0.772278f, 2.014165f}},
    {{-0.896026f, 0.323573f, -0.304037f}, {1.617249f, 1.161845f, 1.367249f}},
    {{-0.911463f, 0.151005f, 0.382664f}, {1.484873f, 1.728147f, 1.234873f}},
    {{-0.381785f, -0.923979f, 0.022425f}, {1.869612f, 1.777668f, 1.619612f}},
    {{-0.033115f, 0.882453f, 0.469233f}, {1.206453f, 1.997232f, 0.956453f}},
};

TEST(EnvironmentMap, EvaluatesAsMitsubaDoes) {
  const Map map{"noise", 5, 4, noise};
  const std::string scale = "<float name=\"scale\" value=\"2\"/>";
  const auto plain = envmap(map, scale), turned = envmap(map, scale + kRotation);
  const auto compare = [](const Emitter& emitter, const Reference& reference) {
    const Rgb radiance = emitter.eval_environment(glm::normalize(reference.d));
    // Six printed digits move d by less than 1e-6; the gradient is below 2.75 x 5 / 2 pi.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], reference.radiance[c], 1e-5);
  };
  for (const Reference& reference : kPlain) compare(*plain, reference);
  for (const Reference& reference : kTurned) compare(*turned, reference);
}

TEST(EnvironmentMap, HitsEachTexelAtItsCentre) {
  const Map map{"noise", 6, 5, noise};
  const auto emitter = envmap(map);
  for (int y = 1; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) {
      const Rgb radiance = emitter->eval_environment(Vec3(direction((x + 0.5) / 6, y / 4.)));
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(radiance[c], noise(x, y)[c], 1e-5) << x << "," << y;
    }
  }
}

/// Returns a Radiance file (Ward's RGBE) without run-length encoding: one byte per mantissa and for
/// the exponent.
std::string radiance_file(const Image& image) {
  std::string file = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(image.height) +
                     " +X " + std::to_string(image.width) + "\n";
  for (size_t i = 0; i < image.data.size(); i += 3) {
    int exponent = 0;
    std::frexp(std::max({image.data[i], image.data[i + 1], image.data[i + 2]}), &exponent);
    for (size_t c = i; c < i + 3; ++c) {
      file += static_cast<char>(static_cast<int>(std::ldexp(image.data[c], 8 - exponent)));
    }
    file += static_cast<char>(exponent + 128);
  }
  return file;
}

/// Mitsuba 3.9.1 shows the same light for all of these files, too.
TEST(EnvironmentMap, ReadsFilesOfOtherFormats) {
  const TemporaryFolder folder;
  // Exact both in eighths with a shared exponent and in bytes that sRGB encodes.
  const Image eighths = image_of(5, 4, noise);
  const Image bytes = image_of(5, 4, [](int x, int y) {
    return Rgb(srgb_to_linear(noise(x, y).x / 2), srgb_to_linear(noise(x, y).y / 2), 1);
  });
  write_pfm(folder.path("eighths.pfm"), eighths);
  write_pfm(folder.path("bytes.pfm"), bytes);
  write_png(folder.path("bytes.png"), bytes, 0);
  const auto expect_same = [&](const std::string& file, const std::string& pfm, float tolerance) {
    const auto map = envmap(file), expected = envmap(folder.path(pfm));
    for (const Reference& reference : kPlain) {
      const Vec3 d = glm::normalize(reference.d);
      const Rgb a = map->eval_environment(d), b = expected->eval_environment(d);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << file;
    }
  };
  expect_same(folder.write("map.hdr", radiance_file(eighths)), "eighths.pfm", 0);
  // noise / 2 in bytes has an error of half of 1/255, and the slope of sRGB is below 2.3.
  expect_same(folder.path("bytes.png"), "bytes.pfm", 2.3f / 510);
}

/// A direction that isn't finite gives a value that isn't finite, which the film reports. It must
/// not read outside the map.
TEST(EnvironmentMap, PassesOnDirectionsThatAreNoNumbers) {
  const auto emitter = envmap(Map{"noise", 6, 5, noise});
  for (int axis = 0; axis < 3; ++axis) {
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      Vec3 d(0.6f, 0.6f, 0.5f);
      d[axis] = bad;
      EXPECT_FALSE(is_finite(emitter->eval_environment(d))) << axis << " " << bad;
    }
  }
}

TEST(EnvironmentMap, BlackHasNothingToSample) {
  const auto emitter = envmap(Map{"black", 4, 3, [](int, int) { return Rgb(0.f); }});
  EXPECT_FALSE(emitter->sample_direct(Vec3(0.f), Vec2(0.5f)));
  EXPECT_EQ(emitter->pdf_environment(Vec3(0, 1, 0)), 0);
  const auto points = light_points_of(*emitter, 10, 0);
  ASSERT_TRUE(points);
  for (const Rgb& power : points->power) EXPECT_TRUE(is_black(power));
}

TEST(EnvironmentMap, LightPointsKeepTheFlux) {
  for (const Map& map : maps()) {
    const auto emitter = envmap(map);
    // Within the grid's cells the map is linear in u and v, times sin theta: use a fine grid.
    const Grid grid(map.width, map.height, 4);
    glm::dvec3 expected(0), magnitude(0);
    for (int c = 0; c < 3; ++c) {
      const auto channel = [&](const glm::dvec3& d) {
        return static_cast<double>(emitter->eval_environment(Vec3(d))[c]);
      };
      expected[c] = grid.integrate(channel);
      magnitude[c] = grid.integrate([&](const glm::dvec3& d) { return std::abs(channel(d)); });
    }
    for (const uint32_t count : {1u, 2u, 100u, 3000u}) {
      const auto points = light_points_of(*emitter, count, 1);
      ASSERT_TRUE(points);
      ASSERT_EQ(points->kind, LightPoints::Kind::kDistant);
      ASSERT_EQ(points->size(), count);
      ASSERT_EQ(points->power.size(), count);
      ASSERT_EQ(points->extent.size(), count);
      ASSERT_TRUE(points->normal.empty());
      glm::dvec3 sum(0);
      for (const Rgb& power : points->power) sum += glm::dvec3(power);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sum[c], expected[c], 1e-5 * magnitude[c]) << map.name << ", " << count;
      }
    }
  }
}

/// Each point has the light of its own cell: the mean over the cell times its solid angle.
TEST(EnvironmentMap, LightPointsHaveTheLightOfTheirCells) {
  const Map map{"noise", 9, 6, noise};
  const auto emitter = envmap(map, kRotation);
  for (const uint32_t count : {1u, 5u, 64u, 2000u}) {
    const SpherePartition cells(count);
    const auto points = light_points_of(*emitter, count, 1);
    const int steps = count < 100 ? 300 : 40;
    for (uint32_t i = 0; i < count; ++i) {
      const Vec3 centre(rotated(glm::dvec3(cells.centre(i))));
      ASSERT_LT(glm::length(points->position[i] - centre), 1e-5);
      glm::dvec3 mean(0);
      for (int y = 0; y < steps; ++y) {
        for (int x = 0; x < steps; ++x) {
          const Vec3 d = cells.sample(i, Vec2(x + 0.5f, y + 0.5f) / static_cast<float>(steps));
          mean += glm::dvec3(emitter->eval_environment(Vec3(rotated(glm::dvec3(d)))));
        }
      }
      mean /= steps * steps;
      // The midpoint rule has an error in proportion to the squared step. The largest step, for one
      // cell that covers the sphere, is 9 / 300 texels along phi.
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(points->power[i][c] / (mean[c] * points->extent[i]), 1, 5e-4)
            << "cell " << i << " of " << count;
      }
    }
  }
}

TEST(EnvironmentMap, LightPointsOfAUniformMapAreEqual) {
  const auto emitter = envmap(Map{"white", 64, 32, [](int, int) { return Rgb(1, 2, 3); }});
  const auto points = light_points_of(*emitter, 777, 0);
  for (size_t i = 0; i < points->size(); ++i) {
    EXPECT_NEAR(points->power[i].y, 2 * points->extent[i], 1e-5 * points->extent[i]);
    EXPECT_NEAR(points->extent[i], 4 * kPi / 777, 1e-8);
  }
}

// ---- invalid input ----

std::string error_of(const std::function<void()>& make) {
  try {
    make();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(EnvironmentMap, NamesTheTexelThatIsTooLarge) {
  const Map map{"bad", 6, 4,
                [](int x, int y) { return x == 4 && y == 2 ? Rgb(1, 1e37f, 1) : Rgb(1.f); }};
  const std::string message = error_of([&] { envmap(map); });
  EXPECT_NE(message.find(": has a texel that is too large at x = 4, y = 2, channel G; "),
            std::string::npos)
      << message;
  EXPECT_NE(message.find("stay below 1e36"), std::string::npos) << message;
  EXPECT_NE(message.find(" (referenced by test.xml:1:"), std::string::npos) << message;
}

TEST(EnvironmentMap, ReplacesNanWithAWarning) {
  testing::internal::CaptureStderr();
  const auto map =
      envmap(Map{"nan", 4, 4, [](int x, int y) {
                   return Rgb(1, x == 1 ? std::nanf("") : 2.f, x == 2 && y == 2 ? -INFINITY : 3.f);
                 }});
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find(": 4 texels with NaN, which becomes 0"), std::string::npos) << log;
  EXPECT_NE(log.find(": 1 texel with infinity, which becomes 65504"), std::string::npos) << log;
}

TEST(EnvironmentMap, WarnsOnceOfNegativeTexels) {
  testing::internal::CaptureStderr();
  envmap(Map{"negative", 4, 4, [](int x, int) { return Rgb(x == 1 ? -0.25f : 1.f); }});
  const std::string warning = testing::internal::GetCapturedStderr();
  EXPECT_NE(warning.find("4 texels are negative, with 7.7 % of the image's energy, and are kept"),
            std::string::npos)
      << warning;
  EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
}

TEST(EnvironmentMap, RefusesUnreadableFiles) {
  const TemporaryFolder folder;
  const std::string message = error_of([&] { envmap(folder.write("sky.png", "PNG")); });
  EXPECT_NE(message.find("can't be read as an image"), std::string::npos) << message;
  EXPECT_NE(error_of([&] { envmap(folder.write("sky.exr", "no image")); }), "");
  EXPECT_NE(error_of([&] { envmap(folder.path("missing.exr")); }), "");
  const Map map{"noise", 4, 3, noise};
  EXPECT_NE(error_of([&] { envmap(map, "<float name=\"scale\" value=\"-1\"/>"); }), "");
  const std::string sheared = error_of([&] {
    envmap(map, "<transform name=\"to_world\"><matrix value=\"1 1 0 0 1 0 0 0 1\"/></transform>");
  });
  EXPECT_NE(sheared.find("rotation"), std::string::npos) << sheared;
  // A scale is ignored.
  const auto scaled =
      envmap(map, "<transform name=\"to_world\"><scale x=\"2\" y=\"2\" z=\"3\"/></transform>");
  const Vec3 d = glm::normalize(Vec3(.3f, .8f, .5f));
  EXPECT_EQ(scaled->eval_environment(d), envmap(map, "")->eval_environment(d));
}

// ---- constant ----

TEST(ConstantEnvironment, IsUniform) {
  const auto emitter = make<Emitter>(
      "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1 2 3\"/></emitter>");
  SphereChi2 chi2;
  chi2.sample = [&](float, Vec2 u) { return std::optional(emitter->sample_direct({}, u)->d); };
  chi2.pdf = [&](const Vec3& d) { return emitter->pdf_environment(d); };
  chi2.samples = 200000;
  const auto verdict = sphere_chi2_test(chi2, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
  EXPECT_EQ(emitter->eval_environment(Vec3(0, 0, 1)), Rgb(1, 2, 3));
  const auto points = light_points_of(*emitter, 1000, 0);
  Rgb sum(0.f);
  for (const Rgb& power : points->power) sum += power;
  EXPECT_NEAR(sum.z, 12 * kPi, 1e-4 * 12 * kPi);
}

TEST(ConstantEnvironment, BlackHasNothingToSample) {
  const auto emitter =
      make<Emitter>("<emitter type=\"constant\"><float name=\"radiance\" value=\"0\"/></emitter>");
  EXPECT_FALSE(emitter->sample_direct({}, Vec2(0.5f)));
  EXPECT_EQ(emitter->pdf_environment(Vec3(0, 0, 1)), 0);
}

}  // namespace
}  // namespace kinome::test::envmap_test
