#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "kinome/image_files.h"
#include "kinome/output_files.h"
#include "matrix.h"
#include "xml.h"

/// Parts of the scenes of surface_cases.cpp.
namespace kinome::test {

/// A still life: a ball and a block on a floor, seen from the front.
inline std::string still_life(const std::string& bsdf, const std::string& operations = "") {
  const auto placed = [&](const std::string& type, const std::string& own) {
    return xml::shape(type, xml::to_world(own + operations) + bsdf);
  };
  return placed("sphere", xml::scale(.5) + xml::translate({-.5f, 0, .5f})) +
         placed("cube", xml::scale(Vec3(.25f, .3f, .4f)) + xml::rotate({0, 0, 1}, 30) +
                            xml::translate({.6f, .2f, .4f})) +
         placed("rectangle", xml::scale(Vec3(2, 2, 1)));
}
/// `scale` and `offset` of the world: the camera must not be scaled itself.
inline std::string front_view(double scale = 1, const Vec3& offset = Vec3(0.f),
                              const std::string& sampler = "independent", int samples = 1) {
  const auto at = [&](const Vec3& p) { return p * static_cast<float>(scale) + offset; };
  return xml::sensor("perspective", xml::look_at(at({0, -4, 2}), at({0, 0, .4f}), {0, 0, 1}), 12,
                     12, samples, sampler,
                     xml::number("fov", 35) + xml::number("near_clip", .01 * scale) +
                         xml::number("far_clip", 1e7 * scale));
}
inline std::string constant(const Rgb& radiance = Rgb(1, .8f, .6f)) {
  return xml::emitter("constant", xml::color("radiance", radiance));
}
inline std::string lamp(const Vec3& position = Vec3(-.8f, -1, 2), double scale = 1) {
  return xml::emitter(
      "point", xml::point("position", position * static_cast<float>(scale)) +
                   xml::color("intensity", Rgb(9, 7, 5) * static_cast<float>(scale * scale)));
}
inline std::string panel(const std::string& operations = "") {
  return xml::shape("rectangle", xml::to_world(xml::scale(.4) + xml::rotate({1, 0, 0}, 200) +
                                               xml::translate({.3f, -.4f, 2}) + operations) +
                                     xml::emitter("area", xml::color("radiance", Rgb(8, 9, 10))));
}
inline std::string integrator_of_depth(const std::string& type, int max_depth) {
  return xml::integrator(type, xml::integer("max_depth", max_depth));
}
inline std::string samples(int emitter, int bsdf) {
  return xml::integrator(
      "direct", xml::integer("emitter_samples", emitter) + xml::integer("bsdf_samples", bsdf));
}

/// Compares an image with another integrator's image of the same scene.
inline Trial picture(const std::string& name,
                     const std::function<std::string(const std::string& bsdf)>& scene,
                     const std::string& reference, bool has_environment, bool has_lamps) {
  Trial t;
  t.name = name;
  t.scene = scene;
  t.expectation.integrator = reference;
  t.has_environment = has_environment;
  t.has_lamps = has_lamps;
  return t;
}

/// A ball of 20 x 10 faces with its own normals; `bend` turns them toward +z.
inline std::string ball_obj(float bend) {
  constexpr int kColumns = 20, kRows = 10;
  std::string text;
  const auto at = [](int column, int row) {
    const float theta = kPi * static_cast<float>(row) / kRows;
    const float phi = 2 * kPi * static_cast<float>(column) / kColumns;
    return Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  };
  for (int row = 0; row <= kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Vec3 p = at(column, row);
      text += "v " + xml::digits(p) + "\nvn " + xml::digits(glm::normalize(p + Vec3(0, 0, bend))) +
              "\n";
    }
  }
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int a = row * kColumns + column + 1;
      const int b = row * kColumns + (column + 1) % kColumns + 1;
      text +=
          fmt::format("f {0}//{0} {1}//{1} {2}//{2} {3}//{3}\n", a, a + kColumns, b + kColumns, b);
    }
  }
  return text;
}

/// Writes files of meshes and images into a folder.
class Files {
 public:
  explicit Files(std::string folder) : folder_(std::move(folder)) {}
  /// Returns a shape with these faces. The file name is a hash of the text, so that concurrent
  /// processes write the same file.
  std::string mesh(const std::string& text, const std::string& inner) const {
    const std::string file =
        fmt::format("{}/mesh{:x}.obj", folder_, std::hash<std::string>()(text));
    write_text(file, text);
    return xml::shape("obj", xml::text("filename", file) + inner);
  }
  std::string image(const Image& image) const {
    static int count = 0;
    const std::string file = folder_ + "/image" + std::to_string(count++) + ".exr";
    write_exr(file, image, ExrSampleType::kFloat, {});
    return file;
  }

 private:
  std::string folder_;
};

}  // namespace kinome::test
