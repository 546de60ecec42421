/// Compares `sunsky` with Mitsuba 3.9.1, and tests its parameters.
#include <gtest/gtest.h>

#include <cmath>

#include "kinome/clustered_light.h"
#include "kinome/emitter.h"
#include "kinome/sensor.h"
#include "support/render.h"

namespace kinome::test::sunsky_test {
namespace {

std::string vector_text(const Vec3& v) {
  return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z);
}
std::string vector_xml(const std::string& name, const Vec3& v) {
  return "<vector name=\"" + name + "\" value=\"" + vector_text(v) + "\"/>";
}
std::string number_xml(const std::string& name, double value) {
  return "<float name=\"" + name + "\" value=\"" + std::to_string(value) + "\"/>";
}
std::string whole_xml(const std::string& name, int value) {
  return "<integer name=\"" + name + "\" value=\"" + std::to_string(value) + "\"/>";
}
std::shared_ptr<Emitter> sky(const std::string& parameters, const std::string& type = "sunsky") {
  return make<Emitter>("<emitter type=\"" + type + "\">" + parameters + "</emitter>");
}

TEST(SunSky, IsMitsubas) {
  // Values of Mitsuba's eval() in scalar_rgb.
  const struct {
    float turbidity;
    Vec3 albedo, sun, d;
    Rgb radiance;
  } cases[] = {
      {3, Vec3(0.3f), {.6, 0, .8}, {0, 0, 1}, {0.02908008f, 0.04823563f, 0.0955867f}},
      {3, Vec3(0.3f), {.6, 0, .8}, {.6, 0, .8}, {21689.51f, 18034.7f, 13663.47f}},
      {1.5, {.1, .5, .9}, {.2, -.9, .1}, {.3, .4, .2}, {0.03145441f, 0.04732872f, 0.05832241f}},
      {9.75, {0, 1, .5}, {-.4, .3, .5}, {-.5, .2, .5}, {1.117129f, 1.050438f, 0.8573164f}},
      {10, Vec3(1), {0, 0, 1}, {.01, 0, 1}, {1.019602f, 0.9510259f, 0.9956315f}},
      {6, Vec3(0), {1, 0, .02}, {1, .1, .05}, {0.2000255f, 0.06963149f, 0.01493637f}},
      {6, Vec3(0), {1, 0, .02}, {1, 0, .02}, {584.119f, 133.1149f, -8.1258f}},
  };
  for (const auto& [turbidity, albedo, sun, d, radiance] : cases) {
    const auto emitter =
        sky(number_xml("turbidity", turbidity) + "<rgb name=\"albedo\" value=\"" +
            vector_text(albedo) + "\"/>" + vector_xml("sun_direction", sun));
    const Rgb found = emitter->eval_environment(glm::normalize(d));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(found[c], radiance[c], 3e-5f * max_component(radiance))
          << turbidity << ", channel " << c;
    }
    EXPECT_EQ(emitter->eval_environment(glm::normalize(Vec3(d.x, d.y, -0.01f))), Rgb(0.f));
  }
}

/// Means of 120 samples of Mitsuba's sun, in scalar_rgb. They are off by 0.06 degrees in the same
/// direction.
TEST(SunSky, HasMitsubasSunDirection) {
  const struct {
    std::string xml;
    Vec3 sun;
  } cases[] = {
      {"", {0.051407020f, 0.690990746f, 0.721033394f}},
      {number_xml("hour", 8), {-0.010875635f, -0.773520648f, 0.633677780f}},
      {number_xml("hour", 12) + number_xml("minute", 30) + number_xml("second", 15),
       {0.222820788f, 0.174358680f, 0.959140181f}},
      {number_xml("latitude", 47) + number_xml("longitude", 8) + number_xml("timezone", 2) +
           whole_xml("year", 2024) + whole_xml("month", 3) + whole_xml("day", 5) +
           number_xml("hour", 17),
       {0.534832298f, 0.763394773f, 0.362191915f}},
      {number_xml("latitude", -33) + number_xml("longitude", 151) + number_xml("timezone", 10) +
           whole_xml("month", 12) + whole_xml("day", 21) + number_xml("hour", 6.5),
       {0.254418492f, -0.906451165f, 0.337071985f}},
      {whole_xml("year", 1999) + whole_xml("month", 2) + whole_xml("day", 28) +
           number_xml("hour", 10),
       {0.623373210f, -0.472941577f, 0.622681379f}},
  };
  for (const auto& [xml, sun] : cases) {
    const auto emitter = sky(xml + number_xml("sky_scale", 0));
    Vec3 mean(0.f);
    constexpr int kSide = 16;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec2 u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                   (static_cast<float>(i / kSide) + 0.5f) / kSide);
      const auto sample = emitter->sample_direct(Vec3(0.f), u);
      ASSERT_TRUE(sample);
      mean += sample->d;
    }
    EXPECT_NEAR(glm::length(glm::normalize(mean) - sun) * 180 / kPi, 0.0603, 0.001) << xml;
  }
}

/// The sky of 1 July 2025 at 7 in the morning in Mitsuba's llvm_ad_rgb.
TEST(SunSky, TimedIsItsFirstMoment) {
  const auto emitter = sky(whole_xml("start_month", 7), "timed_sunsky");
  const Rgb zenith = emitter->eval_environment(Vec3(0, 0, 1));
  const Rgb expected(0.01553428f, 0.02995661f, 0.05948135f);
  const Rgb sun = emitter->eval_environment(
      glm::normalize(Vec3(-0.146372488f, -0.871127640f, 0.468734178f)));
  const Rgb expected_sun(19839.0391f, 15327.2705f, 9791.498f);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(zenith[c], expected[c], 3e-5f * expected[c]);
    EXPECT_NEAR(sun[c], expected_sun[c], 3e-5f * expected_sun[c]);
  }
}

/// Returns a sky of ten days of July 2025, of which the sensor's shutter covers a part.
std::shared_ptr<Emitter> days(const std::string& parameters) {
  return sky(whole_xml("start_month", 7) + whole_xml("end_year", 2025) + whole_xml("end_month", 7) +
                 whole_xml("end_day", 11) + parameters,
             "timed_sunsky");
}

/// Means of eval() of Mitsuba 3.9.1's emitter in scalar_rgb at 3001 times.
TEST(SunSky, TimedIsTheMeanOverTheShutter) {
  const Vec3 directions[] = {{0, 0, 1}, {.6, 0, .8}, {0, -.8, .6}, {-.9, .1, .2}, {.3, .4, .1}};
  const struct {
    Shutter shutter;
    Rgb radiance[5];
    float tolerance;  ///< larger for few moments: a day is sampled at other hours
  } cases[] = {
      {{0, 1},
       {{0.035069f, 0.052128f, 0.090539f},
        {0.035054f, 0.056883f, 0.101754f},
        {0.062519f, 0.089745f, 0.137485f},
        {0.073303f, 0.116587f, 0.179911f},
        {0.094174f, 0.142196f, 0.208187f}},
       6e-3f},
      {{0.02f, 0.05f},
       {{0.067992f, 0.089310f, 0.137275f},
        {0.057246f, 0.084907f, 0.142825f},
        {0.053089f, 0.087095f, 0.153811f},
        {0.081632f, 0.132346f, 0.214116f},
        {0.091789f, 0.146520f, 0.232816f}},
       5e-4f},
  };
  for (const auto& [shutter, radiance, tolerance] : cases) {
    const auto emitter = days(number_xml("sun_scale", 0));
    emitter->set_shutter(shutter);
    for (int i = 0; i < 5; ++i) {
      const Rgb found = emitter->eval_environment(glm::normalize(directions[i]));
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(found[c], radiance[i][c], tolerance * radiance[i][c]) << shutter.close;
      }
    }
    EXPECT_EQ(emitter->eval_environment(glm::normalize(Vec3(1, 0, -0.1f))), Rgb(0.f));
  }
}

/// Returns the irradiance of the ground, by sampling.
Rgb irradiance(const Emitter& emitter) {
  constexpr int kSide = 64;
  Rgb sum(0.f);
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                 (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const auto sample = emitter.sample_direct(Vec3(0.f), u);
    if (sample && sample->d.z > 0) sum += sample->radiance * (sample->d.z / sample->pdf);
  }
  return sum / float(kSide * kSide);
}

/// The sun's light is the mean of that at single moments, which have Mitsuba's values.
TEST(SunSky, TimedKeepsTheLightOfTheSun) {
  const auto emitter = days(number_xml("sky_scale", 0));
  constexpr int kMoments = 100;
  Rgb expected(0.f);
  for (int i = 0; i < kMoments; ++i) {
    const float time = 0.02f + 0.03f * (static_cast<float>(i) + 0.5f) / kMoments;
    emitter->set_shutter({time, time});
    expected += irradiance(*emitter) / float(kMoments);
  }
  emitter->set_shutter({0.02f, 0.05f});
  const Rgb found = irradiance(*emitter);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 5e-3f * expected[c]);
}

/// The irradiance perpendicular to the sun's direction doesn't depend on its size.
TEST(SunSky, SizeOfTheSunKeepsItsLight) {
  const auto flux = [](double aperture) {
    const auto emitter = sky(number_xml("sky_scale", 0) + vector_xml("sun_direction", {1, 2, 3}) +
                             number_xml("sun_aperture", aperture));
    const auto sample = emitter->sample_direct(Vec3(0.f), Vec2(0.3f));
    EXPECT_TRUE(sample);
    return sample->radiance / sample->pdf;
  };
  const Rgb expected = flux(0.5358);
  for (const double aperture : {0.01, 2., 40.}) {
    const Rgb found = flux(aperture);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-4f * expected[c]) << aperture;
  }
}

TEST(SunSky, NightIsBlack) {
  const auto emitter = sky(number_xml("hour", 0));
  EXPECT_EQ(emitter->eval_environment(Vec3(0, 0, 1)), Rgb(0.f));
  EXPECT_FALSE(emitter->sample_direct(Vec3(0.f), Vec2(0.5f)));
  EXPECT_EQ(emitter->pdf_environment(Vec3(0, 0, 1)), 0);
}

/// Light points have the total power of the sky, and approximately the requested number.
TEST(SunSky, LightPointsAreTheWholeLight) {
  const auto scene = scene_from("<shape type=\"sphere\"/><emitter type=\"sunsky\"/>");
  const Emitter& emitter = *scene->environment();
  RenderContext context({.threads = 1});
  glm::dvec3 whole(0.);
  constexpr int kSide = 1024;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                 (static_cast<float>(i / kSide) + 0.5f) / kSide);
    const auto sample = emitter.sample_direct(Vec3(0.f), u);
    if (sample) whole += glm::dvec3(sample->radiance / sample->pdf) / double{kSide * kSide};
  }
  for (const uint32_t count : {64u, 1000u, 20000u}) {
    const auto points = light_points_of(emitter, *scene, context, count);
    ASSERT_TRUE(points);
    // A ring of cells may cross the horizon.
    EXPECT_NEAR(static_cast<double>(points->position.size()), count, count < 1000 ? 12 : 0.1 * count);
    glm::dvec3 sum(0.);
    for (const Rgb& power : points->power) sum += glm::dvec3(power);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / whole[c], 1, count < 1000 ? 0.05 : 0.01);
  }
}

std::string error_of(const std::string& parameters, const std::string& type = "sunsky") {
  try {
    sky(parameters, type);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SunSky, ChecksItsParameters) {
  const struct {
    std::string xml;
    std::string message;
  } cases[] = {
      {number_xml("turbidity", 0.5), "must be between 1 and 10"},
      {number_xml("turbidity", 11), "must be between 1 and 10"},
      {number_xml("sun_scale", -1), "'sun_scale' must be between 0"},
      {number_xml("sky_scale", -1), "'sky_scale' must be between 0"},
      {number_xml("sun_aperture", 0), "must be at least 0.001"},
      {number_xml("sun_aperture", 180), "below 180"},
      {vector_xml("sun_direction", Vec3(0)), "must be finite and not zero"},
      {vector_xml("sun_direction", {1, 2, 3}) + number_xml("hour", 3),
       "'hour' can't be combined with 'sun_direction'"},
      {whole_xml("year", 20000), "'year' must be between -9999"},
      {"<boolean name=\"complex_sun\" value=\"true\"/>", "'complex_sun' must be false"},
      {"<texture name=\"albedo\" type=\"checkerboard\"/>", "must be uniform"},
      {"<rgb name=\"albedo\" value=\"2 0 0\"/>", "'albedo'"},
      {number_xml("turbidty", 2), "did you mean 'turbidity'"},
  };
  for (const auto& [xml, message] : cases) {
    EXPECT_NE(error_of(xml).find(message), std::string::npos) << error_of(xml);
  }
  EXPECT_NE(error_of(number_xml("window_start_time", 25), "timed_sunsky").find("between 0 and 24"),
            std::string::npos);
  EXPECT_NE(error_of(number_xml("window_end_time", 3), "timed_sunsky").find("window_start_time"),
            std::string::npos);
}

}  // namespace
}  // namespace kinome::test::sunsky_test
