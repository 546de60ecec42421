#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "product_scenes.h"

/// Small subjects on ground planes and under lamps of any size and distance. A method that draws
/// light regardless of where it contributes to the image is wrong at nearly every seed for some of
/// these.
namespace kinome::test {

enum class Subject { kCourt, kBox, kStillLife, kMetalCorner };
enum class Lamp { kSky, kPoint, kSpot, kPanel, kBall };
enum class View { kNear, kFar };

struct SeedScene {
  const char* name;
  Subject subject;
  Lamp lamp;
  double distance = 1;  ///< of the lamp, in units of the subject's size
  double plane = 0;     ///< size of the ground plane, in the same unit; 0: none
  View view = View::kNear;
  double scale = 1;  ///< factor of all lengths
  int max_depth = -1;
  /// Limit for the median error of product sampling, in units of that of `path` with as many
  /// samples.
  double max_error = 1e30;
};

struct FilmSize {
  int width, height;
};

/// Returns the XML of a SeedScene. Lengths inside are in units of the subject's size, half of its
/// width.
class SeedSceneXml {
 public:
  explicit SeedSceneXml(const SeedScene& scene) : scene_(scene) {}

  std::string operator()(const std::string& integrator, const std::string& parameters,
                         const FilmSize& size, int samples) const {
    return "<scene version=\"3.0.0\"><integrator type=\"" + integrator + "\">" +
           integer("max_depth", scene_.max_depth) + parameters + "</integrator>" +
           camera(size, samples) + subject() + ground() + lamp() + "</scene>";
  }

 private:
  std::string vector(double x, double y, double z) const {
    return fmt::format("{:.9g} {:.9g} {:.9g}", x * scene_.scale, y * scene_.scale,
                       z * scene_.scale);
  }
  std::string shape(const char* type, const std::string& operations,
                    const std::string& content) const {
    return fmt::format(
        "<shape type=\"{}\"><transform name=\"to_world\">{}<scale value=\"{:.9g}\"/></transform>"
        "{}</shape>",
        type, operations, scene_.scale, content);
  }
  static std::string walls(const std::string& bsdf) {
    return "<bsdf type=\"twosided\">" + bsdf + "</bsdf>";
  }
  static std::string turned(const char* axis, int angle) {
    return fmt::format("<rotate {}=\"1\" angle=\"{}\"/>", axis, angle);
  }
  static std::string moved(double x, double y, double z) {
    return fmt::format("<translate x=\"{:.9g}\" y=\"{:.9g}\" z=\"{:.9g}\"/>", x, y, z);
  }
  static std::string sized(double x, double y, double z) {
    return fmt::format("<scale x=\"{:.9g}\" y=\"{:.9g}\" z=\"{:.9g}\"/>", x, y, z);
  }

  std::string camera(const FilmSize& size, int samples) const {
    std::string from = vector(0, .95, .9), to = vector(0, .4, -1);
    if (scene_.subject == Subject::kBox) from = vector(.1, .6, 1.4), to = vector(0, .5, -1);
    if (scene_.subject == Subject::kStillLife || scene_.subject == Subject::kMetalCorner) {
      from = vector(.4, .9, 2.4), to = vector(0, .3, 0);
    }
    double angle = 60;
    if (scene_.view == View::kFar) from = vector(1, 6, 12), angle = 25;
    return fmt::format(
        "<sensor type=\"perspective\">{}<float name=\"near_clip\" value=\"{:.9g}\"/><float "
        "name=\"far_clip\" value=\"{:.9g}\"/><transform name=\"to_world\"><lookat origin=\"{}\" "
        "target=\"{}\" up=\"0 1 0\"/></transform><sampler type=\"independent\">{}</sampler>"
        "<film type=\"hdrfilm\">{}<rfilter type=\"box\"/></film></sensor>",
        number("fov", angle), .01 * scene_.scale, 1e5 * scene_.scale, from, to,
        integer("sample_count", samples),
        integer("width", size.width) + integer("height", size.height));
  }

  std::string subject() const {
    switch (scene_.subject) {
      case Subject::kCourt:
        return shape("rectangle", turned("x", -90), walls(diffuse_xml(".8 .75 .7"))) + sides() +
               shape("rectangle", sized(1, .6, 1) + moved(0, .6, 1),
                     walls(diffuse_xml(".8 .8 .8")));
      case Subject::kBox:
        return shape("rectangle", turned("x", -90), walls(diffuse_xml(".7 .7 .7"))) + sides() +
               shape("rectangle", turned("x", 90) + moved(0, 1.2, 0),
                     walls(diffuse_xml(".8 .8 .8"))) +
               shape("cube", sized(.25, .35, .25) + turned("y", 20) + moved(.4, .35, -.3),
                     diffuse_xml(".6 .6 .3"));
      case Subject::kStillLife:
        return shape("disk", sized(1.2, 1.2, 1) + turned("x", -90),
                     walls(diffuse_xml(".5 .4 .3"))) +
               shape("sphere", sized(.35, .35, .35) + moved(-.45, .35, -.1), metal(.15)) +
               shape("cube", sized(.2, .3, .2) + turned("y", 30) + moved(.35, .3, -.35),
                     bsdf("roughplastic", number("alpha", .1))) +
               shape("sphere", sized(.2, .2, .2) + moved(.25, .2, .35), bsdf("dielectric"));
      case Subject::kMetalCorner:
        return shape("rectangle", turned("x", -90), walls(metal(.2))) +
               shape("rectangle", moved(0, 1, -.8), walls(metal(.2))) +
               shape("sphere", sized(.3, .3, .3) + moved(.1, .3, 0), diffuse_xml(".6 .5 .4"));
    }
    return "";
  }
  /// Walls at the left, at the right and at the back.
  std::string sides() const {
    return shape("rectangle", sized(1, .6, 1) + turned("y", 90) + moved(-1, .6, 0),
                 walls(diffuse_xml(".7 .3 .2"))) +
           shape("rectangle", sized(1, .6, 1) + turned("y", 90) + moved(1, .6, 0),
                 walls(diffuse_xml(".3 .6 .3"))) +
           shape("rectangle", sized(1, .6, 1) + moved(0, .6, -1), walls(diffuse_xml(".8 .8 .8")));
  }
  std::string ground() const {
    if (scene_.plane == 0) return "";
    return shape("rectangle",
                 sized(scene_.plane, scene_.plane, 1) + turned("x", -90) + moved(0, -.003, 0),
                 diffuse_xml(".5 .5 .5"));
  }

  /// A lamp whose irradiance at the subject doesn't depend on its distance.
  std::string lamp() const {
    const double d = scene_.distance, x = .3 * d, y = .8 * d, z = .5 * d;
    const double intensity = 3 * d * d * scene_.scale * scene_.scale;
    const std::string rgb = fmt::format(
        "<rgb name=\"intensity\" value=\"{0:.9g} {0:.9g} {1:.9g}\"/>", intensity, .8 * intensity);
    const std::string aimed = fmt::format(
        "<lookat origin=\"{:.9g} {:.9g} {:.9g}\" target=\"0 .3 0\" up=\"0 1 0\"/>", x, y, z);
    switch (scene_.lamp) {
      case Lamp::kSky:
        return constant_xml("1 1 1.1");
      case Lamp::kPoint:
        return "<emitter type=\"point\"><point name=\"position\" value=\"" + vector(x, y, z) +
               "\"/>" + rgb + "</emitter>";
      case Lamp::kSpot:
        return "<emitter type=\"spot\">" + rgb + number("cutoff_angle", 20) +
               "<transform name=\"to_world\"><lookat origin=\"" + vector(x, y, z) + "\" target=\"" +
               vector(0, .3, 0) + "\" up=\"0 1 0\"/></transform></emitter>";
      case Lamp::kPanel:
        return constant_xml(".05 .06 .1") +
               shape("rectangle", sized(.15 * d, .15 * d, 1) + aimed, area_xml("30 28 25"));
      case Lamp::kBall:
        return shape("sphere", sized(.1 * d, .1 * d, .1 * d) + moved(x, y, z),
                     area_xml("90 80 70"));
    }
    return "";
  }
  static std::string area_xml(const std::string& radiance) {
    return "<emitter type=\"area\"><rgb name=\"radiance\" value=\"" + radiance + "\"/></emitter>";
  }

  const SeedScene& scene_;
};

}  // namespace kinome::test
