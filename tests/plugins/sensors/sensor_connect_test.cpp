/// Tests that Sensor::connect is the inverse of Sensor::sample_ray.
#include <gtest/gtest.h>

#include <random>

#include "kinome/film.h"
#include "kinome/sensor.h"
#include "support/render.h"

namespace kinome::test::sensor_connect_test {
namespace {

constexpr const char* kView =
    R"(<lookat origin="1 2 3" target="0.5 -0.25 -1" up="0.1 1 0.2"/></transform>)";
constexpr const char* kCrop =
    R"(<film type="hdrfilm"><integer name="width" value="300"/><integer name="height" value="200"/>)"
    R"(<integer name="crop_offset_x" value="40"/><integer name="crop_offset_y" value="100"/>)"
    R"(<integer name="crop_width" value="120"/><integer name="crop_height" value="90"/>)"
    R"(<rfilter type="gaussian"/>)";
constexpr const char* kBorder = R"(<boolean name="sample_border" value="true"/>)";

std::shared_ptr<Sensor> camera(const std::string& type, const std::string& body,
                               const std::string& scale = "", const std::string& film = kBorder) {
  return make<Sensor>(
      "<sensor type=\"" + type + "\">" + body +
      R"(<float name="near_clip" value="0.5"/><float name="far_clip" value="20"/>)" +
      "<transform name=\"to_world\">" + scale + kView + kCrop + film + "</film></sensor>");
}

std::vector<std::shared_ptr<Sensor>> cameras() {
  return {
      camera("perspective", R"(<float name="fov" value="40"/>)"),
      camera("perspective", R"(<float name="principal_point_offset_x" value="0.2"/>)"
                            R"(<float name="principal_point_offset_y" value="-0.1"/>)"),
      camera("thinlens",
             R"(<float name="fov" value="60"/><float name="aperture_radius" value="0.3"/>)"
             R"(<float name="focus_distance" value="4"/>)"),
      camera("thinlens", R"(<float name="aperture_radius" value="0.05"/>)"),
      camera("orthographic", ""),
      camera("orthographic", "", R"(<scale value="2 3 4"/>)"),
      camera("orthographic", "", R"(<scale value="-1 1 2"/>)"),
  };
}

class Random {
 public:
  float between(float low, float high) {
    return low + (high - low) * static_cast<float>(bits_() >> 8) * 0x1p-24f;
  }
  Vec2 unit2() {
    const float x = between(0, 1);
    return {x, between(0, 1)};
  }

 private:
  std::mt19937 bits_{7};
};

/// Returns a film position in the crop window.
Vec2 random_position(Random& random) {
  const float x = random.between(40, 160);
  return {x, random.between(100, 190)};
}

TEST(SensorConnect, FindsThePixelsThatRaysComeFrom) {
  Random random;
  for (const auto& sensor : cameras()) {
    for (int i = 0; i < 1000; ++i) {
      const Vec2 position = random_position(random);
      const Vec2 aperture = random.unit2();
      const Ray ray = sensor->sample_ray(position, aperture);
      const float t = ray.tmin + (ray.tmax - ray.tmin) * random.between(0.01f, 0.99f);
      const auto connection = sensor->connect(ray.at(t), aperture);
      ASSERT_TRUE(connection);
      // Coordinates up to 4 have some five rounding errors (6e-8 of them each), and pixels are 1e-3
      // wide at the near clip.
      EXPECT_LT(glm::distance(connection->film_position, position), 0.002f);
      EXPECT_LT(glm::distance(connection->d, -ray.d), 1e-5f);
      EXPECT_NEAR(connection->distance, t - ray.tmin, 1e-5f);
      EXPECT_NEAR(glm::length(connection->d), 1.f, 1e-6f);
    }
  }
}

/// A plane with radiance 1 gives every pixel the value 1. The intensity of a piece of the plane is
/// its area times the cosine. The map from film to plane gives the area that it covers on the film.
TEST(SensorConnect, WeightsGiveAnImageOfOneForAPlaneOfRadianceOne) {
  Random random;
  const Vec3 normal = glm::normalize(Vec3(0.3f, 0.2f, 1.f));
  const Vec3 origin(0.2f, 0.5f, -1.5f);
  for (const auto& sensor : cameras()) {
    for (int i = 0; i < 200; ++i) {
      const Vec2 position = random_position(random);
      const Vec2 aperture = random.unit2();
      const auto on_plane = [&](const Vec2& at) {
        const Ray ray = sensor->sample_ray(at, aperture);
        const auto d = glm::dvec3(ray.d), o = glm::dvec3(ray.o), n = glm::dvec3(normal);
        return o + d * (glm::dot(n, glm::dvec3(origin) - o) / glm::dot(n, d));
      };
      // Central differences over 16 pixels, which are some .1 on the plane. Directions in single
      // precision cause errors of 1e-6 on it.
      constexpr float kStep = 8;
      const glm::dvec3 dx =
          on_plane(position + Vec2(kStep, 0)) - on_plane(position - Vec2(kStep, 0));
      const glm::dvec3 dy =
          on_plane(position + Vec2(0, kStep)) - on_plane(position - Vec2(0, kStep));
      const double area = glm::length(glm::cross(dx, dy)) / (4.0 * kStep * kStep);
      const auto connection = sensor->connect(Vec3(on_plane(position)), aperture);
      ASSERT_TRUE(connection);
      const double cosine = std::abs(glm::dot(connection->d, normal));
      EXPECT_NEAR(connection->weight * cosine * area, 1, 2e-4) << i;
    }
  }
}

TEST(SensorConnect, SeesNothingOutsideItsImage) {
  for (const auto& sensor : cameras()) {
    const Vec2 middle(0.5f);
    const auto sees = [&](const Vec2& position, float t) {
      const Ray ray = sensor->sample_ray(position, middle);
      return sensor->connect(ray.at(ray.tmin + t * (ray.tmax - ray.tmin)), middle).has_value();
    };
    EXPECT_TRUE(sees({100, 150}, 0.5f));
    EXPECT_FALSE(sees({100, 150}, -0.01f)) << "nearer than the near clip";
    EXPECT_FALSE(sees({100, 150}, -0.5f)) << "behind the camera";
    EXPECT_FALSE(sees({100, 150}, 1.01f)) << "beyond the far clip";
    // The Gaussian of radius 2 adds two pixels around the crop window.
    EXPECT_EQ(sensor->film().reach().x0, 38);
    EXPECT_EQ(sensor->film().reach().y1, 192);
    EXPECT_TRUE(sees({38.1f, 150}, 0.5f));
    EXPECT_TRUE(sees({161.9f, 191.9f}, 0.5f));
    EXPECT_FALSE(sees({37.9f, 150}, 0.5f));
    EXPECT_FALSE(sees({162.1f, 150}, 0.5f));
    EXPECT_FALSE(sees({100, 97.9f}, 0.5f));
    EXPECT_FALSE(sees({100, 192.1f}, 0.5f));
    EXPECT_FALSE(sensor->connect(Vec3(std::numeric_limits<float>::quiet_NaN()), middle));
  }
}

TEST(SensorConnect, SeesTheCropWindowAloneWhereNoBorderIsSampled) {
  for (const char* type : {"perspective", "thinlens", "orthographic"}) {
    const std::string lens =
        type == std::string("thinlens") ? R"(<float name="aperture_radius" value="0.05"/>)" : "";
    const auto sensor = camera(type, lens, "", "");
    const auto sees = [&](const Vec2& position) {
      const Ray ray = sensor->sample_ray(position, Vec2(0.5f));
      return sensor->connect(ray.at(0.5f * (ray.tmin + ray.tmax)), Vec2(0.5f)).has_value();
    };
    EXPECT_TRUE(sees({40.1f, 100.1f}));
    EXPECT_TRUE(sees({159.9f, 189.9f}));
    EXPECT_FALSE(sees({39.9f, 150}));
    EXPECT_FALSE(sees({160.1f, 150}));
    EXPECT_FALSE(sees({100, 99.9f}));
    EXPECT_FALSE(sees({100, 190.1f}));
  }
}

}  // namespace
}  // namespace kinome::test::sensor_connect_test
