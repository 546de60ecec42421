// `clustered` with importance = product under local light has the expectation of `direct`, and with
// one bounce that of `path`: z-tests over tiles of pixels and over the image, for each kind of
// emitter and material. Each z-test has a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "render/paths/path_scenes.h"
#include "product_scenes.h"
#include "render/product/product_local.h"

namespace kinome::test {
namespace {

using namespace product_local;

TEST_P(Local, IsUnbiased) {
  expect_unbiased(GetParam().setup, kRenders, GetParam().tile);
}
Case often(Case c, int times) {
  c.setup = often(c.setup, times);
  return c;
}

/// With few rays, its images are mostly too dark and occasionally bright.
Case on_sharp_metal() {
  Case c = lit_by("LampOnSharpMetal", kLamp + kBall, 2, metal(.03));
  c.setup.rays = 64;
  c.setup.direct_samples = 64;
  return c;
}

/// Found by kinome-stress: the sky's flux, which is proportional to the area of the whole scene,
/// overflows.
Case under_a_vast_sky() {
  const std::string lamp =
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"90\"/><translate y=\"3\"/>",
                area_xml("1e20 1e20 1e20"));
  Case c = lit_by("LampUnderAVastSky", lamp + constant_xml("1e19"));
  c.setup.shapes +=
      "<shape type=\"sphere\"><point name=\"center\" value=\"3e11 0 0\"/>"
      "<float name=\"radius\" value=\"1e11\"/></shape>";
  return c;
}

std::vector<Case> direct() {
  return {
      under_a_vast_sky(),
      lit_by("Rectangle", kLamp),
      lit_by("Sphere", kBall),
      lit_by("Textured", textured_lamp()),
      lit_by("Cube", shape_xml("cube", "<scale value=\".2\"/><translate x=\"1\" y=\"2\"/>",
                               area_xml("9 9 9"))),
      lit_by("Point", kPoint),
      lit_by("Spot", kSpot),
      lit_by("Projector", projector()),
      lit_by("Directional", kDirectional),
      lit_by("SeveralLights", kLamp + kBall + kPoint + kSpot),
      lit_by("WithAnEnvironment", kLamp + kPoint + sun_xml()),
      lit_by("ManyPoints", many_points(9)),
      lit_by("ManyLamps", many_lamps(9)),
      on_sharp_metal(),
      often(lit_by("LampOnMirror", kLamp + kBall, 2, bsdf("conductor")), 8),
      often(lit_by("MirrorUnderTheSky", kLamp + sun_xml(), 2, bsdf("conductor")), 16),
      lit_by("LampOnPlastic", kLamp + kPoint, 2, bsdf("plastic")),
  };
}
INSTANTIATE_TEST_SUITE_P(Direct, Local, testing::ValuesIn(direct()), name_of);

/// A roof with a narrow slit: hardly any of the sun's light contributes, so that light points are
/// drawn with a guide.
Case slit() {
  Case c = lit_by("Slit", kDirectional, 3);
  for (const char* const x : {"-3.1", "3.1"}) {
    c.setup.shapes += shape_xml("rectangle",
                                "<scale x=\"3\" y=\"6\"/><rotate x=\"1\" angle=\"90\"/>"
                                "<translate x=\"" +
                                    std::string(x) + "\" y=\"3.5\"/>",
                                kGrey);
  }
  c.setup.finds = 0.2;
  return c;
}

/// Found by kinome-stress: light arrives from behind a board, passes because of its shading
/// normals, and lights the floor. The board is so high that rounding makes it thick.
Case through_a_board(const char* name, const std::string& material) {
  const std::string spot =
      "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"90 80 70\"/>" +
      number("cutoff_angle", 15) +
      "<transform name=\"to_world\"><lookat origin=\"4,1.2,-1.8\" target=\"0,1,-1\" "
      "up=\"0,1,0\"/></transform></emitter>";
  Case c = lit_by(name, spot, 3);
  const std::string file =
      folder().write("board.obj",
                     "v -2 0 -1\nv 2 0 -1\nv 2 3000 -1\nv -2 3000 -1\nvn 0.9 -0.1 0.42\n"
                     "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n");
  c.setup.shapes =
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"-90\"/><scale value=\"5\"/>", kGrey) +
      "<shape type=\"obj\"><string name=\"filename\" value=\"" + file + "\"/>" + material +
      "</shape>";
  return c;
}

/// Shading normals below the surface: visible from only one side, and flipped for viewers on the
/// other.
Case normals_below_the_surface() {
  const std::string spot =
      "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"90 80 70\"/>" +
      number("cutoff_angle", 12) +
      "<transform name=\"to_world\"><lookat origin=\"4,1.5,1\" target=\"-.5,1,-1\" "
      "up=\"0,1,0\"/></transform></emitter>";
  Case c = lit_by("NormalsBelowTheSurface", spot, 3);
  c.setup.shapes =
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"-90\"/><scale value=\"5\"/>", kGrey) +
      shape_xml("rectangle", "<scale value=\"6\"/><translate z=\"-1\"/>",
                bsdf("normalmap",
                     "<texture name=\"normalmap\" type=\"checkerboard\"><rgb name=\"color0\" "
                     "value=\".9 .6 .4\"/><rgb name=\"color1\" value=\".95 .45 .45\"/>"
                     "</texture>" +
                         kGrey));
  return c;
}

/// Hardly any of the light falls where it contributes to the image.
Case far(const char* name, const std::string& light) {
  Case c = lit_by(name, light, 3);
  c.setup.shapes += shape_xml("rectangle",
                              "<scale value=\"300\"/><rotate x=\"1\" angle=\"-90\"/>"
                              "<translate y=\"-.01\"/>",
                              kGrey);
  return c;
}

/// Most of the noise is from the light points, which all tiles of an image share. The test of the
/// sum assumes independent tiles, so that one tile is the whole image here.
Case textured_bounce() {
  Case c = lit_by("Textured", textured_lamp(), 3);
  c.tile = 16;
  return c;
}

std::vector<Case> bounces() {
  return {
      far("FarPoint", point_xml("300,800,500", "4e6 3e6 2e6")),
      far("FarSpot",
          "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"4e6 3e6 2e6\"/>" +
              number("cutoff_angle", 10) +
              "<transform name=\"to_world\"><lookat origin=\"300,800,500\" target=\"20,0,0\" "
              "up=\"0,1,0\"/></transform></emitter>"),
      far("FarBall",
          "<shape type=\"sphere\"><point name=\"center\" x=\"60\" y=\"160\" z=\"100\"/>"
          "<float name=\"radius\" value=\"20\"/><emitter type=\"area\"><rgb "
          "name=\"radiance\" value=\"90 80 70\"/></emitter></shape>"),
      far("SkyOnALargePlane", constant_xml("1 .9 .8")),
      far("SunOnALargePlane", sun_xml() + kDirectional),
      through_a_board("ThroughADiffuseBoard", kGrey),
      through_a_board("ThroughAPlasticBoard",
                      bsdf("twosided", bsdf("roughplastic", number("alpha", .4)))),
      normals_below_the_surface(),
      corner("Corner", ""),
      // Fewer points are near, so that eye rays find more of the light.
      corner("CornerNotGuided", off("light_guide")),
      slit(),
      lit_by("Rectangle", kLamp, 3),
      lit_by("Sphere", kBall, 3),
      textured_bounce(),
      lit_by("Point", kPoint, 3),
      lit_by("Spot", kSpot, 3),
      lit_by("Projector", projector(), 3),
      lit_by("Directional", kDirectional, 3),
      lit_by("Environment", sun_xml(), 3),
      lit_by("Everything", kLamp + kPoint + kSpot + sun_xml(), 3),
      lit_by("ManyPoints", many_points(5), 3),
  };
}
INSTANTIATE_TEST_SUITE_P(Bounce, Local, testing::ValuesIn(bounces()), name_of);

std::vector<Case> materials() {
  const auto made_of = [](const char* name, const std::string& material) {
    return lit_by(name, kSpot + kBall, 3, material);
  };
  return {
      made_of("RoughPlastic", bsdf("roughplastic", number("alpha", .1))),
      often(made_of("SharpMetal", metal(.05)), 32),
      made_of("WideMetal", metal(.4)),
      made_of("Phong", bsdf("phong", number("exponent", 40))),
      made_of("WardAnisotropic", bsdf("ward", number("alpha_u", .05) + number("alpha_v", .3))),
      made_of("Twosided", bsdf("twosided", kGrey)),
      made_of("Textured", bsdf("diffuse", checkerboard("reflectance"))),
      // `path` finds no light of lamps by way of mirrors.
      often(lit_by("Mirror", kBall, 3, bsdf("conductor")), 8),
      lit_by("Plastic", kBall, 3, bsdf("plastic")),
  };
}
INSTANTIATE_TEST_SUITE_P(Materials, Local, testing::ValuesIn(materials()), name_of);

}  // namespace
}  // namespace kinome::test
