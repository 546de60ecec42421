/// `depth` and `aov` on a scene whose first hits are known in closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "direct_scenes.h"

namespace kinome::test::aov_test {
namespace {

/// A unit sphere in front of a rectangle at z = -1 that covers the left half of the image, seen
/// along -z by parallel rays from z = 5. The rest is empty. One sample per pixel.
std::string scene_xml(const std::string& integrator, const std::string& pixel_format = "rgba") {
  return "<shape type=\"sphere\">" + diffuse_xml("0.2 0.4 0.6") +
         "</shape><shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"3\" y=\"6\" "
         "z=\"1\"/><translate x=\"-3\" z=\"-1\"/></transform><bsdf type=\"phong\"><rgb "
         "name=\"diffuse_reflectance\" value=\"0.1 0.2 0.3\"/><rgb name=\"specular_reflectance\" "
         "value=\"0.3\"/></bsdf></shape>" +
         constant_xml("1") +
         sensor_xml("orthographic", "<scale value=\"3\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 21,
                    4, "independent", pixel_format) +
         integrator;
}

/// Three pixels: the sphere's centre, the rectangle alone, nothing. The camera's +x is image left.
struct Pixel {
  int x;
  int y;
};
constexpr Pixel kSphere{10, 10}, kRectangle{3, 3}, kNothing{18, 3};
/// Distance of the camera's near plane, from which depth is measured. to_world scales the default
/// near_clip.
constexpr float kNear = 3 * 0.01f;

TEST(Depth, IsTheDistanceAlongTheRay) {
  const auto scene = scene_from(scene_xml("<integrator type=\"depth\"/>"));
  const Image image = render_scene(*scene);
  for (int c = 0; c < 3; ++c) {
    // The central pixel spans x, y in [-1/7, 1/7] of the sphere: z in [.979, 1].
    EXPECT_NEAR(image.at(kSphere.x, kSphere.y, c), 4.01 - kNear, 0.011);
    EXPECT_NEAR(image.at(kRectangle.x, kRectangle.y, c), 6 - kNear, 1e-5);
    EXPECT_EQ(image.at(kNothing.x, kNothing.y, c), 0);
  }
  EXPECT_EQ(image.at(kRectangle.x, kRectangle.y, 3), 1);
  EXPECT_EQ(image.at(kNothing.x, kNothing.y, 3), 0);
}

std::string aov_xml(const std::string& aovs, const std::string& nested = "") {
  return "<integrator type=\"aov\"><string name=\"aovs\" value=\"" + aovs + "\"/>" + nested +
         "</integrator>";
}

int channel_of(const Image& image, const std::string& name) {
  for (int c = 0; c < image.channel_count(); ++c) {
    if (image.channels[c] == name) return c;
  }
  ADD_FAILURE() << "no channel " << name;
  return 0;
}

constexpr const char* kAll =
    "dd:depth, pos:position,uv:uv,gn:geo_normal,sn:sh_normal,du:dp_du,dv:dp_dv,pi:prim_index,"
    "si:shape_index,al:albedo";

std::string named_direct_xml() { return "<integrator type=\"direct\" name=\"img\"/>"; }

/// A wall at a distance of 3 from the camera, whose near plane is at 1. As in Mitsuba 3.9.1, camera
/// rays begin on the near plane, and so do measured distances.
TEST(Depth, CountsFromTheNearPlane) {
  struct Camera {
    std::string xml;    ///< type and its own parameters
    std::string scale;  ///< in to_world
    bool is_parallel;
    float expected;  ///< along the axis
  };
  const std::string fov = R"(<float name="fov" value="60"/>)";
  const Camera cameras[] = {
      {"perspective\">" + fov, "", false, 2},
      // The aperture is negligible: all rays of a pixel begin at the same point.
      {"thinlens\"><float name=\"aperture_radius\" value=\"1e-5\"/>" + fov, "", false, 2},
      {"orthographic\">", "", true, 2},
      {"orthographic\">", "<scale value=\"2\"/>", true, 1},
      {"orthographic\">", "<scale value=\".5\"/>", true, 2.5},
  };
  for (const Camera& camera : cameras) {
    const std::string rest =
        "<sensor type=\"" + camera.xml +
        R"(<float name="near_clip" value="1"/><float name="far_clip" value="10"/>
        <transform name="to_world">)" +
        camera.scale + look_at("0 0 3", "0 0 0", "0 1 0") +
        R"(</transform><sampler type="independent"><integer name="sample_count" value="1"/></sampler>
        <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="4"/>
        <rfilter type="box"/></film></sensor><shape type="rectangle">
        <transform name="to_world"><scale value="20"/></transform></shape>)";
    const Image depth = render_scene(*scene_from("<integrator type=\"depth\"/>" + rest));
    const Image both = render_scene(*scene_from(aov_xml("d:depth,p:position") + rest));
    for (int i = 0; i < 16; ++i) {
      const int x = i % 4, y = i / 4;
      const Vec3 p(both.at(x, y, 4), both.at(x, y, 5), both.at(x, y, 6));
      const float cosine = camera.is_parallel ? 1 : 3 / glm::length(p - Vec3(0, 0, 3));
      EXPECT_NEAR(depth.at(x, y, 0), camera.expected / cosine, 1e-4f) << camera.xml;
      EXPECT_EQ(both.at(x, y, 3), depth.at(x, y, 0)) << camera.xml;
    }
  }
}

TEST(Aov, NamesChannelsAsMitsubaDoes) {
  const auto scene = scene_from(scene_xml(aov_xml(kAll, named_direct_xml()), "rgba"));
  const Image image = render_scene(*scene);
  const std::vector<std::string> expected{
      "R",    "G",     "B",     "A",     "img.R", "img.G", "img.B", "img.A", "dd.T", "pos.X", "pos.Y",
      "pos.Z", "uv.U", "uv.V", "gn.X", "gn.Y", "gn.Z", "sn.X", "sn.Y", "sn.Z", "du.X", "du.Y",
      "du.Z", "dv.X",  "dv.Y",  "dv.Z",  "pi.I",  "si.I",  "al.R",  "al.G",  "al.B"};
  EXPECT_EQ(image.channels, expected);
}

TEST(Aov, ShowsTheFirstHit) {
  const auto scene = scene_from(scene_xml(aov_xml(kAll, direct_xml()), "rgba"));
  const Image image = render_scene(*scene);
  const auto value = [&](const Pixel& at, const std::string& name) {
    return image.at(at.x, at.y, channel_of(image, name));
  };
  EXPECT_NEAR(value(kRectangle, "dd.T"), 6 - kNear, 1e-5);
  // Pixel 3 of 21, whose width is 2/7: x from -3 + 6/7. Rows count from the top, y = 3.
  EXPECT_NEAR(value(kRectangle, "pos.X"), -2, 1.01 / 7);
  EXPECT_NEAR(value(kRectangle, "pos.Y"), 2, 1.01 / 7);
  EXPECT_NEAR(value(kRectangle, "pos.Z"), -1, 1e-5);
  EXPECT_NEAR(value(kRectangle, "uv.U"), (value(kRectangle, "pos.X") + 6) / 6, 1e-5);
  EXPECT_NEAR(value(kRectangle, "uv.V"), (value(kRectangle, "pos.Y") + 6) / 12, 1e-5);
  EXPECT_NEAR(value(kRectangle, "du.X"), 6, 1e-4);
  EXPECT_NEAR(value(kRectangle, "dv.Y"), 12, 1e-4);
  for (const char* normal : {"gn", "sn"}) {
    EXPECT_NEAR(value(kRectangle, normal + std::string(".Z")), 1, 1e-6);
    EXPECT_NEAR(value(kRectangle, normal + std::string(".X")), 0, 1e-6);
  }
  EXPECT_EQ(value(kRectangle, "si.I"), 2);
  EXPECT_EQ(value(kSphere, "si.I"), 1);
  EXPECT_EQ(value(kSphere, "pi.I"), 0);
  EXPECT_NEAR(value(kSphere, "al.G"), 0.4, 1e-6);
  EXPECT_NEAR(value(kRectangle, "al.G"), 0.5, 1e-6);
  EXPECT_GT(value(kSphere, "gn.Z"), 0.97);
  // All channels of a pixel without a hit are 0, except the sky's colour and alpha of the nested
  // integrator.
  EXPECT_EQ(value(kNothing, "_arg_0.G"), 1);
  EXPECT_EQ(value(kNothing, "_arg_0.A"), 1);
  for (int c = 8; c < image.channel_count(); ++c) {
    EXPECT_EQ(image.at(kNothing.x, kNothing.y, c), 0) << image.channels[c];
  }
  EXPECT_EQ(image.at(kNothing.x, kNothing.y, 0), 1);
}

/// The colour is identical with and without variables, because the rays are the same.
TEST(Aov, LeavesTheNestedImageUnchanged) {
  const Image plain = render_scene(*scene_from(scene_xml(direct_xml())), 9);
  const Image with = render_scene(*scene_from(scene_xml(aov_xml("d:depth", direct_xml()))), 9);
  const Image depth = render_scene(*scene_from(scene_xml("<integrator type=\"depth\"/>")), 9);
  const Image alone = render_scene(*scene_from(scene_xml(aov_xml("d:depth"))), 9);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 21; ++x) {
      for (int c = 0; c < 4; ++c) ASSERT_EQ(plain.at(x, y, c), with.at(x, y, c));
      ASSERT_EQ(depth.at(x, y, 0), with.at(x, y, 8));
      ASSERT_EQ(depth.at(x, y, 0), alone.at(x, y, 4));
      ASSERT_EQ(alone.at(x, y, 0), 0);
    }
  }
}

/// Derivatives of uv per pixel, divided by the square root of the samples per pixel. For a pinhole,
/// they use the distance beyond the near plane, as in Mitsuba 3.9.1.
TEST(Aov, RendersUvDerivativesByPixel) {
  constexpr float kTan = 0.363970234f;  // tangent of 20 degrees
  struct Camera {
    std::string type;
    float near;
    float width;  ///< of the wall across the image's 21 pixels
  };
  const std::string fov = R"(<float name="fov" value="40"/>)";
  const std::string lens =
      R"(<float name="aperture_radius" value="0.2"/><float name="focus_distance" value="5"/>)";
  const Camera cameras[] = {{"perspective\">" + fov, 0.01f, 2 * kTan * 4.99f},
                            {"perspective\">" + fov, 1, 2 * kTan * 4},
                            {"thinlens\">" + lens + fov, 1, 2 * kTan * 5},
                            {"orthographic\">", 1, 2}};
  for (const Camera& camera : cameras) {
    for (const int samples : {1, 4, 16}) {
      const Image image = render_scene(*scene_from(
          aov_xml("x:duv_dx,y:duv_dy") + "<sensor type=\"" + camera.type +
          "<float name=\"near_clip\" value=\"" + std::to_string(camera.near) + "\"/>" +
          "<transform name=\"to_world\">" + look_at("0 0 5", "0 0 0", "0 1 0") +
          "</transform><sampler type=\"independent\"><integer name=\"sample_count\" value=\"" +
          std::to_string(samples) +
          R"("/></sampler><film type="hdrfilm"><integer name="width" value="21"/>
          <integer name="height" value="21"/><rfilter type="box"/></film></sensor>
          <shape type="rectangle"><transform name="to_world"><scale x="4" y="8"/></transform>
          </shape>)"));
      const float step = camera.width / 21 / std::sqrt(static_cast<float>(samples));
      const float expected[] = {step / 8, 0, 0, -step / 16};
      for (int c = 0; c < 4; ++c) {
        EXPECT_NEAR(image.at(10, 10, 3 + c), expected[c], 3e-3f * step / 8)
            << camera.type << ", channel " << c << ", " << samples << " samples";
      }
    }
  }
}

/// Albedos of Mitsuba 3.9.1 for each material: the colour of its diffuse part, coated or not.
TEST(Aov, AlbedoIsMitsubas) {
  const std::string grey = "<bsdf type=\"diffuse\"><float name=\"reflectance\" value=\"0.4\"/></bsdf>";
  const struct {
    std::string bsdf;
    Rgb albedo;
  } cases[] = {
      {"<bsdf type=\"plastic\"/>", Rgb(0.5f)},
      {"<bsdf type=\"roughplastic\"/>", Rgb(0.5f)},
      {"<bsdf type=\"conductor\"/>", Rgb(0)},
      {"<bsdf type=\"dielectric\"/>", Rgb(0)},
      {"<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.3\"/>" + grey + "</bsdf>", Rgb(0.4f)},
      {"<bsdf type=\"twosided\">" + grey + "</bsdf>", Rgb(0.4f)},
      {"<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/>" + grey +
           "<bsdf type=\"diffuse\"><float name=\"reflectance\" value=\"0.8\"/></bsdf></bsdf>",
       Rgb(0.5f)},
      // pi f toward the normal.
      {"<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/><float "
       "name=\"alpha\" value=\"0.4\"/></bsdf>",
       Rgb(1.5104364f, 1.2531406f, 0.5064398f)},
  };
  for (const auto& [bsdf, albedo] : cases) {
    const Image image = render_scene(*scene_from(
        aov_xml("a:albedo") + "<shape type=\"rectangle\">" + bsdf + "</shape>" +
        sensor_xml("orthographic", look_at("0 0 5", "0 0 0", "0 1 0"), 1, 4)));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(0, 0, 3 + c), albedo[c], 2e-3f) << bsdf;
  }
}

/// A mirror at z = 0 shows two walls behind the camera, at z = 9: a red one at x > 0, a blue one at
/// x < 0. `in_front`: shapes between the camera and the mirror.
std::string guide_scene_xml(const std::string& in_front) {
  const auto wall = [](const std::string& x, const std::string& reflectance) {
    return R"(<shape type="rectangle"><transform name="to_world"><rotate y="1" angle="180"/>
        <scale value="4"/><translate x=")" + x + R"(" z="9"/></transform>)" +
           diffuse_xml(reflectance) + "</shape>";
  };
  return wall("4", "0.5 0.1 0.1") + wall("-4", "0.1 0.1 0.5") +
         R"(<shape type="rectangle"><transform name="to_world"><scale value="4"/>
            </transform><bsdf type="conductor"><string name="material" value="none"/>
            <rgb name="specular_reflectance" value="0.8"/></bsdf></shape>)" +
         in_front + constant_xml("1") +
         sensor_xml("orthographic", look_at("0 0 5", "0 0 0", "0 1 0"), 4, 64, "independent",
                    "rgb") +
         aov_xml("a:guide_albedo,n:guide_normal,f:sh_normal,g:guide_albedo");
}

TEST(Aov, GuidesShowTheFirstRoughSurfaceInAMirror) {
  const Image image = render_scene(*scene_from(guide_scene_xml("")));
  const int a = channel_of(image, "a.R"), n = channel_of(image, "n.X"), f = channel_of(image, "f.X"),
            g = channel_of(image, "g.R");
  for (int x = 0; x < 4; ++x) {
    const bool is_red = x >= 2;
    EXPECT_NEAR(image.at(x, 1, a), 0.8 * (is_red ? 0.5 : 0.1), 1e-5) << x;
    EXPECT_NEAR(image.at(x, 1, a + 2), 0.8 * (is_red ? 0.1 : 0.5), 1e-5) << x;
    EXPECT_NEAR(image.at(x, 1, n + 2), -1, 1e-5) << "toward the mirror";
    EXPECT_NEAR(image.at(x, 1, f + 2), 1, 1e-5) << "the mirror's own normal";
    EXPECT_EQ(image.at(x, 1, g), image.at(x, 1, a));
  }
}

/// Thin glass reflects a share R of the rays, which reach the walls without the mirror, and passes
/// the others twice. A ray that is reflected between glass and mirror leaves by the glass at last.
/// The mean over 64 independent samples and 16 pixels, whose choices have a probability of about
/// 0.08, is within 4.5 standard deviations (a false alarm in 1e5).
TEST(Aov, GuidesFollowTheRaysInGlass) {
  const Image image = render_scene(*scene_from(guide_scene_xml(
      R"(<shape type="rectangle"><transform name="to_world"><scale value="4"/><translate z="2"/>
         </transform><bsdf type="thindielectric"/></shape>)")));
  const int a = channel_of(image, "a.R");
  double red = 0;
  for (int y = 0; y < 4; ++y) red += (image.at(2, y, a) + image.at(3, y, a)) / 8;
  const double normal = std::pow((1.5046 - 1.000277) / (1.5046 + 1.000277), 2);
  const double reflected = 2 * normal / (1 + normal);
  // Sum over k reflections at the glass's back: T² R^(k-1) 0.8^k, and R for none.
  const double expected =
      0.5 * (reflected + std::pow(1 - reflected, 2) * 0.8 / (1 - 0.8 * reflected));
  EXPECT_NEAR(red, expected, 4.5 * 0.5 * 0.2 * std::sqrt(0.15 / (64 * 8)));
  EXPECT_NE(red, 0.4);
}

/// The environment and emitters have the albedo min(radiance, 1). Rays that pass the holes of a
/// mask show what is behind it.
TEST(Aov, GuidesShowEmittersAndSurfacesBehindHoles) {
  const std::string lamp = R"(<shape type="sphere"><point name="center" x="0" y="0" z="2"/>
      <float name="radius" value="0.6"/><emitter type="area"><rgb name="radiance"
      value="7 0.25 0.5"/></emitter></shape>)";
  const std::string mask = R"(<shape type="rectangle"><transform name="to_world"><scale value="4"/>
      <translate z="3"/></transform><bsdf type="mask"><float name="opacity" value="0"/>
      <bsdf type="diffuse"/></bsdf></shape>)";
  const Image image = render_scene(*scene_from(
      lamp + mask + constant_xml("0.25") +
      sensor_xml("orthographic", look_at("0 0 5", "0 0 0", "0 1 0"), 9, 4, "independent", "rgb") +
      aov_xml("a:guide_albedo,n:guide_normal")));
  const int a = channel_of(image, "a.R"), n = channel_of(image, "n.X");
  const Vec3 lit(image.at(4, 4, a), image.at(4, 4, a + 1), image.at(4, 4, a + 2));
  EXPECT_EQ(lit, Vec3(1, 0.25f, 0.5f));
  EXPECT_GT(image.at(4, 4, n + 2), 0.9);
  EXPECT_EQ(image.at(0, 0, a), 0.25f);
  EXPECT_EQ(image.at(0, 0, n + 2), 0);
}

TEST(Aov, Nests) {
  const auto scene =
      scene_from(scene_xml(aov_xml("outer:depth", "<integrator type=\"aov\" name=\"in\"><string name=\"aovs\" value=\"inner:uv\"/>" +
                                           named_direct_xml() + "</integrator>"),
                           "rgb"));
  const Image image = render_scene(*scene);
  EXPECT_EQ(image.channels,
            (std::vector<std::string>{"R", "G", "B", "in.R", "in.G", "in.B", "in.A", "in.img.R",
                                      "in.img.G", "in.img.B", "in.img.A", "in.inner.U",
                                      "in.inner.V", "outer.T"}));
  EXPECT_NEAR(image.at(kRectangle.x, kRectangle.y, 13), 6 - kNear, 1e-5);
  EXPECT_GT(image.at(kRectangle.x, kRectangle.y, 11), 0);
}

std::string error_of(const std::string& xml) {
  try {
    make<Integrator>(xml);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Aov, ChecksItsList) {
  EXPECT_EQ(error_of(aov_xml("a:depth, b:uv")), "");
  EXPECT_EQ(error_of(aov_xml("a:depth b:uv,,c:uv")), "");
  EXPECT_NE(error_of(aov_xml("a:dept"))
                .find("'aovs' has the unknown type 'dept' (did you mean 'depth'?)"),
            std::string::npos);
  EXPECT_NE(error_of(aov_xml("a:nonsense")).find("unknown type 'nonsense'"), std::string::npos);
  EXPECT_NE(error_of(aov_xml("depth")).find("NAME:TYPE"), std::string::npos);
  EXPECT_NE(error_of(aov_xml("")).find("NAME:TYPE"), std::string::npos);
  EXPECT_NE(error_of(aov_xml("a: depth")).find("NAME:TYPE"), std::string::npos);
  EXPECT_NE(error_of(aov_xml("a:depth,a:depth")).find("names two channels 'a.T'"),
            std::string::npos);
  EXPECT_NE(error_of("<integrator type=\"aov\"/>"), "");
}

/// The program adds channels of these names to the finished image.
TEST(Aov, RefusesReservedNames) {
  for (const char* const name : {"variance", "tile_variance", "noisy", "denoised", "lights",
                                 "variance.x", "CryptoAsset00"}) {
    const std::string quoted = "'" + std::string(name) + "'";
    const std::string listed = error_of(aov_xml(std::string(name) + ":albedo"));
    EXPECT_NE(listed.find("'aovs' must not use the name " + quoted), std::string::npos) << listed;
    const std::string path = "\n <integrator type=\"path\" name=\"" + std::string(name) + "\"/>";
    for (const std::string& xml :
         {aov_xml("d:depth", path), "<integrator type=\"moment\">" + path + "</integrator>"}) {
      const std::string nested = error_of(xml);
      EXPECT_NE(nested.find("the name " + quoted + " is reserved"), std::string::npos) << nested;
      EXPECT_NE(nested.find(":2:2: "), std::string::npos) << nested;
    }
  }
  EXPECT_EQ(error_of(aov_xml("noisy_albedo:albedo,variances:uv,a.variance:depth")), "");
}

}  // namespace
}  // namespace kinome::test::aov_test
