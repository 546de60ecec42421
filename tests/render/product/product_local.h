#pragma once

#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "render/paths/path_scenes.h"
#include "product_scenes.h"

/// Cases of product sampling under local light, with the fixture that compares them.
namespace kinome::test::product_local {

struct Case {
  const char* name;
  Arrangement setup;
  int tile = 4;
};

class Local : public testing::TestWithParam<Case> {};
inline std::string name_of(const testing::TestParamInfo<Case>& info) {
  return info.param.name;
}

inline Case lit_by(const char* name, const std::string& light, int max_depth = 2,
                   const std::string& material = kGrey) {
  Case c{name, {}, 4};
  c.setup.light = light;
  c.setup.max_depth = max_depth;
  c.setup.shapes = shapes_xml(material);
  // Where there is hardly any light, `path` would hardly ever find it.
  if (max_depth == 3) {
    c.setup.shapes += shape_xml("rectangle", "<scale value=\"6\"/><translate z=\"-3\"/>", kGrey);
  }
  c.setup.direct_samples = max_depth == 2 ? 16 : 32;
  return c;
}

inline const std::string kLamp = shape_xml(
    "rectangle", "<scale value=\".4\"/><rotate x=\"1\" angle=\"90\"/><translate x=\".3\" y=\"2\"/>",
    area_xml("6 5 4"));
inline const std::string kBall =
    "<shape type=\"sphere\"><point name=\"center\" x=\".2\" y=\".25\" z=\"1\"/>"
    "<float name=\"radius\" value=\".2\"/>" +
    area_xml("3 4 6") + "</shape>";
inline const std::string kPoint = point_xml("-1.5,2,1", "5 4 3");
inline const std::string kSpot =
    "<emitter type=\"spot\"><rgb name=\"intensity\" value=\"30 25 20\"/>" +
    number("cutoff_angle", 25) + number("beam_width", 15) +
    "<transform name=\"to_world\"><lookat origin=\"2,3,2\" target=\".5,0,.3\" up=\"0,1,0\"/>"
    "</transform></emitter>";
inline const std::string kDirectional =
    "<emitter type=\"directional\"><vector name=\"direction\" x=\"-1\" y=\"-2\" z=\"-.5\"/>"
    "<rgb name=\"irradiance\" value=\"2 1.8 1.5\"/></emitter>";

inline std::string projector() {
  Image image{8, 6, {"R", "G", "B"}, {}};
  for (int i = 0; i < 48; ++i) {
    const float v = i == 19 ? 20.f : 0.2f * static_cast<float>(i % 5);
    image.data.insert(image.data.end(), {v, 0.5f * v, 0.3f});
  }
  const std::string path = folder().path("slide.exr");
  write_exr(path, image, ExrSampleType::kFloat, {});
  return "<emitter type=\"projector\"><texture name=\"irradiance\" type=\"bitmap\">"
         "<string name=\"filename\" value=\"" +
         path + "\"/><boolean name=\"raw\" value=\"true\"/></texture>" + number("scale", 10) +
         number("fov", 40) +
         "<transform name=\"to_world\"><lookat origin=\"1,2.5,3\" target=\"0,.3,0\" up=\"0,1,0\"/>"
         "</transform></emitter>";
}
inline std::string textured_lamp() {
  return shape_xml("rectangle",
                   "<scale value=\"1\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"2.5\"/>",
                   "<emitter type=\"area\">" + checkerboard("radiance") + "</emitter>");
}
/// Small emitters all over the ceiling.
inline std::string many(int side, const std::function<std::string(double, double)>& one) {
  std::string all;
  for (int i = 0; i < side * side; ++i) {
    all += one(4. * (i % side + .5) / side - 2, 4. * (i / side + .5) / side - 2);
  }
  return all;
}
inline std::string many_points(int side) {
  return many(side, [](double x, double z) {
    return point_xml(std::to_string(x) + ",1.9," + std::to_string(z), ".2 .15 .1");
  });
}
inline std::string many_lamps(int side) {
  return many(side, [](double x, double z) {
    return shape_xml("rectangle",
                     "<scale value=\".05\"/><rotate x=\"1\" angle=\"90\"/><translate x=\"" +
                         std::to_string(x) + "\" y=\"1.9\" z=\"" + std::to_string(z) + "\"/>",
                     area_xml("6 5 4"));
  });
}

/// An edge between floor and wall, both lit at a low angle. The lamp is so close to the visible
/// points that they have hardly any light points nearby.
inline Case corner(const char* name, const std::string& parameters) {
  Case c = lit_by(name, point_xml("1.2,.9,.25", "5 4 3"), 3);
  c.setup.parameters = parameters;
  c.setup.shapes = shape_xml("rectangle", "<scale value=\"6\"/>", diffuse_xml(".9 .8 .7")) +
                   shape_xml("rectangle",
                             "<rotate x=\"1\" angle=\"-90\"/><scale value=\"6\"/>"
                             "<translate y=\".4\"/>",
                             diffuse_xml(".8 .9 .8"));
  c.setup.optics = number("fov", 2);
  c.setup.rays = 48;
  c.setup.direct_samples = 256;
  return c;
}

}  // namespace kinome::test::product_local
