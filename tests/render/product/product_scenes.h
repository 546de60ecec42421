#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "render/direct/direct_scenes.h"

/// Scenes for tests of learned product sampling.
namespace kinome::test {

/// False-alarm rate of each z-test.
inline constexpr double kAlpha = 1e-4;

inline const TemporaryFolder& folder() {
  static const TemporaryFolder instance;
  return instance;
}

/// A dim, coloured sky with a strong sun, a weaker one near the horizon, and one negative texel.
inline Rgb harsh(int x, int y) {
  if (x == 20 && y == 7) return {300, 270, 150};
  if (x == 3 && y == 14) return {10, 30, 70};
  if (x == 9 && y == 3) return Rgb(-0.01f);
  const float shade = 0.3f + 0.2f * std::sin(0.4f * static_cast<float>(x + 2 * y));
  return {shade, 0.8f * shade, 1.3f * shade};
}
inline std::string map_xml(const std::string& name, int width, int height, Rgb (*texel)(int, int),
                           const std::string& transform = "") {
  return envmap_xml(folder(), width, height, texel, transform, name);
}
inline std::string sun_xml() {
  return map_xml("sun", 32, 17, harsh);
}

inline std::string number(const std::string& name, double value) {
  return "<float name=\"" + name + "\" value=\"" + std::to_string(value) + "\"/>";
}
inline std::string integer(const std::string& name, int value) {
  return "<integer name=\"" + name + "\" value=\"" + std::to_string(value) + "\"/>";
}
inline std::string off(const std::string& name) {
  return "<boolean name=\"" + name + "\" value=\"false\"/>";
}
inline std::string bsdf(const std::string& type, const std::string& parameters = "") {
  return "<bsdf type=\"" + type + "\">" + parameters + "</bsdf>";
}
inline const std::string kGrey = diffuse_xml(".6 .5 .4");

/// Spheres and a box over a floor: shadows, grazing angles, cells partly below the horizon.
inline std::string shapes_xml(const std::string& material) {
  return R"(<shape type="sphere"><point name="center" x="-.7" y=".7" z="0"/>
      <float name="radius" value=".7"/>)" +
         material + R"(</shape><shape type="sphere"><point name="center" x="1" y=".4" z=".8"/>
      <float name="radius" value=".4"/>)" +
         material + R"(</shape><shape type="cube"><transform name="to_world">
      <scale x=".2" y="1.2" z=".5"/><rotate y="1" angle="30"/><translate x=".6" y="1" z="-1"/>
      </transform>)" +
         material + R"(</shape><shape type="rectangle"><transform name="to_world">
      <scale value="5"/><rotate x="1" angle="-90"/></transform>)" +
         material + "</shape>";
}

struct Arrangement {
  std::string shapes = shapes_xml(kGrey);
  std::string light = sun_xml();
  std::string parameters;  ///< of the integrator
  double rays = 12;
  std::string film = integer("width", 16) + integer("height", 12) + "<rfilter type=\"box\"/>";
  std::string sensor = "perspective";
  std::string optics = number("fov", 45);
  double scale = 1;  ///< of the world
  bool hide = true;
  int max_depth = 2;             ///< with 3, the reference is `bounces`
  std::string bounces = "path";  ///< integrator
  int direct_samples = 16;
  /// Power of the test: the relative error of the whole image that must be found with a probability
  /// of 90 %. Rays and samples must suffice for it. For single tiles it is a smaller fraction of
  /// the image.
  double finds = 0.12;
};

/// Returns the same scene with `times` as many rays and samples, for noisy images.
inline Arrangement often(Arrangement s, int times) {
  s.rays *= times;
  s.direct_samples *= times;
  return s;
}

inline std::unique_ptr<Scene> make_scene(const Arrangement& s, const std::string& integrator,
                                         int samples) {
  const std::string scaled =
      s.scale == 1 ? "" : "<scale value=\"" + std::to_string(s.scale) + "\"/>";
  const auto at = [&](double v) { return std::to_string(v * s.scale); };
  // The camera's clipping distances aren't scaled by the transform.
  const std::string clipped =
      s.scale == 1 ? "" : number("near_clip", .01 * s.scale) + number("far_clip", 1e4 * s.scale);
  return scene_from("<scene version=\"3.0.0\">" + integrator + "<sensor type=\"" + s.sensor +
                    "\">" + s.optics + clipped + "<transform name=\"to_world\"><lookat origin=\"" +
                    at(0) + "," + at(2) + "," + at(5) + "\" target=\"" + at(0) + "," + at(.4) +
                    "," + at(0) + "\" up=\"0,1,0\"/></transform><sampler type=\"independent\">" +
                    integer("sample_count", samples) + "</sampler><film type=\"hdrfilm\">" +
                    s.film + "</film></sensor>" + s.shapes + s.light + "</scene>");
}
inline std::string hidden(const Arrangement& s) {
  return s.hide ? "<boolean name=\"hide_emitters\" value=\"true\"/>" : "";
}
/// Parameter that leaves no image to `path`.
inline const std::string kNoTrial = "<boolean name=\"trial\" value=\"false\"/>";
inline std::unique_ptr<Scene> product_scene(const Arrangement& s) {
  return make_scene(
      s,
      "<integrator type=\"clustered\"><string name=\"importance\" value=\"product\"/>" +
          kNoTrial + number("rays_per_pixel", s.rays) + hidden(s) + integer("max_depth", s.max_depth) +
          s.parameters + "</integrator>",
      8);
}
/// The reference for `product`: `direct`, or `path` with a bounce.
inline std::unique_ptr<Scene> direct_scene(const Arrangement& s) {
  const std::string depth = integer("max_depth", s.max_depth) + integer("rr_depth", 100);
  const std::string integrator =
      s.max_depth == 2 ? "<integrator type=\"direct\">" + hidden(s)
                       : "<integrator type=\"" + s.bounces + "\">" + hidden(s) + depth;
  return make_scene(s, integrator + "</integrator>", s.direct_samples);
}

inline std::string checkerboard(const std::string& name) {
  return "<texture type=\"checkerboard\" name=\"" + name +
         "\"><rgb name=\"color0\" value=\"0 0 0\"/><rgb name=\"color1\" value=\".9 .5 .2\"/>"
         "<transform name=\"to_uv\"><scale value=\"7\"/></transform></texture>";
}
inline std::string metal(double alpha) {
  return bsdf("roughconductor", number("alpha", alpha));
}

inline void expect_unbiased(const Arrangement& s, int renders = kRenders, int tile = 4) {
  const auto product = estimate_tiles(*product_scene(s), renders, tile);
  const auto direct = estimate_tiles(*direct_scene(s), kRenders, tile, 5000);
  expect_equal(product, direct, kAlpha, "product");
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(detectable_bias(channel(product, c), channel(direct, c), kAlpha / 3), s.finds)
        << "channel " << c << ": too noisy to find an error of this size";
  }
}

}  // namespace kinome::test
