#include "kinome/sensor.h"

#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test {
namespace {

struct ExpectedRay {
  Vec2 film_position;
  Vec2 aperture;
  Vec3 o;
  Vec3 d;
  float length;
};
struct Case {
  std::string xml;
  std::vector<ExpectedRay> rays;
};

/// Mitsuba 3.9.1, scalar_rgb: sensor.sample_ray(0, 0.5, (film_position - crop_offset) / crop_size,
/// aperture) of the very same sensors. Its rays begin on the near plane; `length` is their maxt.
const Case kCases[] = {
    {R"(<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="768"/><integer name="height" value="576"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.00294528459f, 0.0015909496f, 0.00999999978f},
          {0.279295236f, 0.150866449f, 0.948279262f},
          10545.4062f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.002289525f, 0.00105687743f, 0.00999999978f},
          {0.222002789f, 0.102479659f, 0.969645619f},
          10313.0361f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {0.00165855372f, 0.00124391529f, 0.00999999885f},
          {0.162401974f, 0.121801481f, 0.97917819f},
          10212.6357f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00334865553f, 7.09845772e-05f, 0.0100000007f},
          {0.31752789f, 0.00673093507f, 0.948225021f},
          10546.0098f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="40.0"/><transform name="to_world"><lookat origin="1 2 3" target="0.5 -0.25 -1" up="0.1 1 0.2"/></transform><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.996360719f, 1.99595332f, 2.99118972f},
          {-0.351431698f, -0.390772372f, -0.850760043f},
          10355.6484f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.997638047f, 1.99490499f, 2.99161983f},
          {-0.234139606f, -0.505063951f, -0.830715954f},
          10087.875f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {0.998916924f, 1.99512625f, 2.99133563f},
          {-0.108306102f, -0.487377316f, -0.866448581f},
          9999.99023f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.995443463f, 1.99335456f, 2.99276638f},
          {-0.420799077f, -0.613718629f, -0.668040037f},
          10828.2422f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="40.0"/><string name="fov_axis" value="y"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.0034637833f, 0.00093419035f, 0.00999999885f},
          {0.326032192f, 0.087931633f, 0.941260278f},
          10624.043f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.00169852807f, -0.000503491727f, 0.00999999978f},
          {0.167248547f, -0.0495771952f, 0.98466748f},
          10155.7021f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {5.96046434e-10f, 2.98023217e-10f, 0.00999999978f},
          {5.96046448e-08f, 2.98023224e-08f, 1.f},
          9999.99023f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00454962766f, -0.00315744104f, 0.00999999978f},
          {0.398006648f, -0.276216567f, 0.874811471f},
          11431.0234f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="40.0"/><string name="fov_axis" value="diagonal"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.00207826984f, 0.000560514221f, 0.00999999885f},
          {0.203173414f, 0.0547963418f, 0.977608323f},
          10229.0352f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.00101911696f, -0.000302095112f, 0.00999999978f},
          {0.101340801f, -0.0300402809f, 0.994398117f},
          10056.3242f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {2.98023217e-10f, 1.49011609e-10f, 0.00999999978f},
          {2.98023224e-08f, 1.49011612e-08f, 1.f},
          9999.99023f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00272977701f, -0.00189446483f, 0.00999999978f},
          {0.259051472f, -0.17978169f, 0.948984027f},
          10537.5742f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="40.0"/><string name="fov_axis" value="smaller"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.0034637833f, 0.00093419035f, 0.00999999885f},
          {0.326032192f, 0.087931633f, 0.941260278f},
          10624.043f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.00169852807f, -0.000503491727f, 0.00999999978f},
          {0.167248547f, -0.0495771952f, 0.98466748f},
          10155.7021f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {5.96046434e-10f, 2.98023217e-10f, 0.00999999978f},
          {5.96046448e-08f, 2.98023224e-08f, 1.f},
          9999.99023f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00454962766f, -0.00315744104f, 0.00999999978f},
          {0.398006648f, -0.276216567f, 0.874811471f},
          11431.0234f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="40.0"/><string name="fov_axis" value="larger"/><film type="hdrfilm"><integer name="width" value="300"/><integer name="height" value="400"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.00168791215f, 0.00161056838f, 0.0100000007f},
          {0.164376989f, 0.156844884f, 0.973848045f},
          10268.5322f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.000363970466f, 0.000532306731f, 0.00999999978f},
          {0.0363216102f, 0.0531203486f, 0.997927368f},
          10020.7598f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {-0.000909925206f, 0.00090992573f, 0.00999999885f},
          {-0.0902483761f, 0.0902484283f, 0.991821826f},
          10082.4453f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00250229519f, -0.00145815534f, 0.00999999885f},
          {0.240352467f, -0.140059903f, 0.960527956f},
          10410.9307f},
     }},
    {R"(<sensor type="perspective"><string name="focal_length" value="35mm"/><film type="hdrfilm"><integer name="width" value="300"/><integer name="height" value="400"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.00229313085f, 0.00218805508f, 0.00999999978f},
          {0.218595698f, 0.208579212f, 0.953263044f},
          10490.2734f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.000494475826f, 0.000723171222f, 0.00999999978f},
          {0.0492589213f, 0.0720411986f, 0.996184528f},
          10038.291f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {-0.00123618869f, 0.00123618951f, 0.00999999885f},
          {-0.121772021f, 0.121772103f, 0.985060036f},
          10151.6553f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00339951972f, -0.00198099227f, 0.00999999885f},
          {0.31634587f, -0.184343308f, 0.93056041f},
          10746.2012f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="60.0"/><float name="near_clip" value="0.5"/><float name="far_clip" value="20.0"/><float name="principal_point_offset_x" value="0.1"/><float name="principal_point_offset_y" value="-0.2"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.148306862f, 0.1421725f, 0.5f},
          {0.274356484f, 0.263008386f, 0.924962223f},
          21.0819435f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.0433013029f, 0.0566525012f, 0.5f},
          {0.0857351497f, 0.112170078f, 0.989983439f},
          19.697298f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {-0.0577350035f, 0.0866025463f, 0.5f},
          {-0.113046631f, 0.169570029f, 0.979012966f},
          19.9180202f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.212897927f, -0.101216689f, 0.49999997f},
          {0.385137528f, -0.183103457f, 0.904512167f},
          21.5585823f},
     }},
    {R"(<sensor type="perspective"><float name="fov" value="60.0"/><float name="principal_point_offset_x" value="0.1"/><float name="principal_point_offset_y" value="-0.2"/><transform name="to_world"><lookat origin="1 2 3" target="0.5 -0.25 -1" up="0.1 1 0.2"/></transform><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/><integer name="crop_offset_x" value="40"/><integer name="crop_offset_y" value="100"/><integer name="crop_width" value="120"/><integer name="crop_height" value="90"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.996070266f, 1.9978466f, 2.99016118f},
          {-0.363483012f, -0.199178755f, -0.910059333f},
          10811.2422f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.998096466f, 1.99618375f, 2.9908433f},
          {-0.188446075f, -0.377805293f, -0.906504989f},
          10101.168f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {1.00012517f, 1.99653471f, 2.99039221f},
          {0.0122529268f, -0.339258671f, -0.94061327f},
          10214.3594f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.994615376f, 1.99372423f, 2.99266171f},
          {-0.487047315f, -0.567647278f, -0.663748085f},
          11055.6719f},
     }},
    {R"(<sensor type="thinlens"><float name="fov" value="45.0"/><float name="aperture_radius" value="0.25"/><float name="focus_distance" value="3.0"/><float name="near_clip" value="0.5"/><float name="far_clip" value="20.0"/><transform name="to_world"><lookat origin="1 2 3" target="0.5 -0.25 -1" up="0.1 1 0.2"/></transform><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.963937461f, 1.8179096f, 2.5298655f},
          {-0.436168313f, -0.374617457f, -0.818180263f},
          20.7727261f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.740308285f, 1.69975793f, 2.62427926f},
          {-0.199862644f, -0.492794752f, -0.846881449f},
          19.5861282f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {1.01618564f, 1.91170824f, 2.47057271f},
          {-0.136024922f, -0.547857702f, -0.825438738f},
          19.5597343f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.748199821f, 1.65549636f, 2.64819002f},
          {-0.455299646f, -0.622924089f, -0.636135101f},
          21.5686703f},
     }},
    {R"(<sensor type="thinlens"><float name="fov" value="45.0"/><string name="fov_axis" value="y"/><float name="aperture_radius" value="0.25"/><float name="far_clip" value="50.0"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/><integer name="crop_offset_x" value="40"/><integer name="crop_offset_y" value="100"/><integer name="crop_width" value="120"/><integer name="crop_height" value="90"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {-0.19217591f, 0.0400734209f, 0.00999999885f},
          {0.368116289f, 0.0975818783f, 0.924644887f},
          54.0639954f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.159571037f, -0.0764874592f, 0.00999999885f},
          {0.186519518f, -0.0547170155f, 0.980926394f},
          50.9620285f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {-0.0770704299f, 0.221952841f, 0.00999999978f},
          {0.00154172629f, -0.00443991041f, 0.999988914f},
          49.9905548f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.00517766876f, -0.0035933021f, 0.0100000007f},
          {0.438031018f, -0.303993523f, 0.846000493f},
          59.0898018f},
     }},
    {R"(<sensor type="orthographic"><float name="near_clip" value="0.5"/><float name="far_clip" value="20.0"/><film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {0.713750005f, 0.192500025f, 0.5f},
          {0.f, 0.f, 1.f},
          19.5f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.350000083f, -0.103749916f, 0.5f},
          {0.f, 0.f, 1.f},
          19.5f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {1.1920929e-07f, 5.96046448e-08f, 0.5f},
          {0.f, 0.f, 1.f},
          19.5f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {0.93749994f, -0.650624812f, 0.5f},
          {0.f, 0.f, 1.f},
          19.5f},
     }},
    {R"(<sensor type="orthographic"><float name="near_clip" value="0.5"/><float name="far_clip" value="20.0"/><transform name="to_world"><scale value="2 3 4"/><lookat origin="1 2 3" target="0.5 -0.25 -1" up="0.1 1 0.2"/></transform><film type="hdrfilm"><integer name="width" value="300"/><integer name="height" value="400"/><integer name="crop_offset_x" value="40"/><integer name="crop_offset_y" value="100"/><integer name="crop_width" value="120"/><integer name="crop_height" value="90"/></film></sensor>)",
     {
         {{57.25f, 111.5f},
          {0.1f, 0.6f},
          {-0.382864773f, 2.66746068f, 0.489138246f},
          {-0.108306073f, -0.487377316f, -0.866448581f},
          19.5f},
         {{130.f, 170.75f},
          {0.85f, 0.3f},
          {0.539069057f, 1.55608439f, 0.99904573f},
          {-0.108306073f, -0.487377316f, -0.866448581f},
          19.5f},
         {{200.f, 150.f},
          {0.3f, 0.97f},
          {1.48095191f, 1.83841991f, 0.722496629f},
          {-0.108306073f, -0.487377316f, -0.866448581f},
          19.5f},
         {{12.5f, 280.125f},
          {0.5f, 0.5f},
          {-1.09448087f, -0.213639438f, 2.19870901f},
          {-0.108306073f, -0.487377316f, -0.866448581f},
          19.5f},
     }},
};

TEST(Sensor, RaysAreMitsubas) {
  for (const Case& c : kCases) {
    const auto sensor = make<Sensor>(c.xml);
    for (const ExpectedRay& e : c.rays) {
      const Ray ray = sensor->sample_ray(e.film_position, e.aperture);
      // Mitsuba goes through float matrices and their inverses: some ten roundings of 6e-8, at
      // coordinates up to 4.
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(ray.d[i], e.d[i], 2e-6f) << c.xml;
        EXPECT_NEAR(ray.at(ray.tmin)[i], e.o[i], 4e-6f) << c.xml;
      }
      EXPECT_NEAR(ray.tmax - ray.tmin, e.length, 4e-6f * e.length) << c.xml;
      EXPECT_NEAR(glm::length(ray.d), 1.f, 2e-7f);
    }
  }
}

std::shared_ptr<Sensor> make_sensor(const std::string& type, const std::string& body) {
  return make<Sensor>("<sensor type=\"" + type + "\">" + body + "</sensor>");
}

TEST(Sensor, LooksAlongZWithXToTheLeft) {
  for (const char* type : {"perspective", "orthographic"}) {
    const auto sensor = make_sensor(type, "");
    EXPECT_FALSE(sensor->needs_aperture_sample());
    const auto at = [&](float x, float y) {
      const Ray ray = sensor->sample_ray({x, y}, {0.5f, 0.5f});
      return ray.at(1.f);
    };
    EXPECT_GT(at(384, 288).z, 0.9f);
    EXPECT_GT(at(0, 288).x, 0.1f) << "the picture's left is +X";
    EXPECT_LT(at(768, 288).x, -0.1f);
    EXPECT_GT(at(384, 0).y, 0.1f) << "its top is +Y";
  }
}

TEST(Sensor, ThinLensIsSharpAtItsFocus) {
  const auto sensor =
      make_sensor("thinlens",
                  "<float name=\"fov\" value=\"50\"/><float name=\"aperture_radius\" value=\".3\"/>"
                  "<float name=\"focus_distance\" value=\"4\"/>");
  const auto pinhole = make_sensor("perspective", "<float name=\"fov\" value=\"50\"/>");
  EXPECT_TRUE(sensor->needs_aperture_sample());
  const Ray straight = pinhole->sample_ray({100, 50}, {});
  const Vec3 focus = straight.at(4 / straight.d.z);
  float spread = 0;
  for (const Vec2 u : {Vec2(0.f), Vec2(0.5f), Vec2(0.9f, 0.2f), Vec2(0.1f, 0.7f)}) {
    const Ray ray = sensor->sample_ray({100, 50}, u);
    EXPECT_LE(glm::length(ray.o), 0.3f * 1.000001f);
    EXPECT_NEAR(ray.o.z, 0.f, 1e-7f);
    spread = std::max(spread, glm::length(ray.o));
    EXPECT_LT(glm::length(ray.at(4 / ray.d.z) - focus), 4e-6f);
    EXPECT_NEAR(ray.tmin * ray.d.z, 0.01f, 1e-7f);
  }
  EXPECT_NEAR(spread, 0.3f, 1e-6f) << "the square's corner lies on the lens's edge";
}

void expect_error(const std::string& type, const std::string& body, const std::string& part) {
  try {
    make_sensor(type, body);
    ADD_FAILURE() << "no error for " << type << body;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    EXPECT_NE(e.where().line, 0) << e.what();
  }
}
std::string number(const char* name, const char* value) {
  return std::string("<float name=\"") + name + "\" value=\"" + value + "\"/>";
}
std::string text(const char* name, const char* value) {
  return std::string("<string name=\"") + name + "\" value=\"" + value + "\"/>";
}

TEST(Sensor, RefusesWhatItCannotBe) {
  const std::string scale = "<transform name=\"to_world\"><scale value=\"2\"/></transform>";
  expect_error("perspective", number("fov", "0"), "fov");
  expect_error("perspective", number("fov", "180"), "fov");
  expect_error("perspective", number("fov", "30") + text("focal_length", "50mm"), "together");
  expect_error("perspective", text("focal_length", "wide"), "focal_length");
  expect_error("perspective", text("focal_length", "-3mm"), "focal_length");
  expect_error("perspective", number("fov", "30") + text("fov_axis", "z"), "fov_axis");
  expect_error("perspective", number("near_clip", "0"), "near_clip");
  expect_error("perspective", number("far_clip", ".001"), "far_clip");
  expect_error("perspective", scale, "to_world");
  expect_error("thinlens", scale + number("aperture_radius", "1"), "to_world");
  expect_error("perspective", number("shutter_open", "1"), "shutter_close");
  expect_error("thinlens", "", "aperture_radius");
  expect_error("thinlens", number("aperture_radius", "0"), "aperture_radius");
  expect_error("thinlens", number("aperture_radius", "1") + number("focus_distance", "-1"),
               "focus_distance");
  expect_error("orthographic", number("fov", "30"), "fov");
  make_sensor("orthographic", scale);
  make_sensor("perspective", "<transform name=\"to_world\"><scale value=\"-1 1 1\"/></transform>");
}

TEST(Sensor, HasAFilmAndASamplerOfItsOwnWhereTheSceneNamesNone) {
  const auto sensor = make_sensor("perspective", "");
  EXPECT_EQ(sensor->film().width(), 768);
  EXPECT_EQ(sensor->sampler().sample_count(), 4u);
}

}  // namespace
}  // namespace kinome::test
