#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "kinome/image_files.h"
#include "kinome/image.h"
#include "support/render.h"

/// Parts of scenes for tests that render.
namespace kinome::test {

inline const char* const kSamplers[] = {"independent", "halton", "sobol", "stratified"};

/// A sensor that looks from `origin` to `target`, with `side`² pixels and a box filter, which makes
/// neighbouring pixels independent.
inline std::string sensor_xml(const std::string& type, const std::string& transform, int side,
                              int samples, const std::string& sampler = "independent",
                              const std::string& pixel_format = "rgb") {
  const std::string n = std::to_string(side);
  return "<sensor type=\"" + type + "\"><transform name=\"to_world\">" + transform +
         "</transform><sampler type=\"" + sampler + "\"><integer name=\"sample_count\" value=\"" +
         std::to_string(samples) + "\"/></sampler><film type=\"hdrfilm\"><integer name=\"width\" " +
         "value=\"" + n + "\"/><integer name=\"height\" value=\"" + n +
         "\"/><string name=\"pixel_format\" value=\"" + pixel_format +
         "\"/><rfilter type=\"box\"/></film></sensor>";
}

inline std::string look_at(const std::string& origin, const std::string& target,
                           const std::string& up = "0 0 1") {
  return "<lookat origin=\"" + origin + "\" target=\"" + target + "\" up=\"" + up + "\"/>";
}

/// A large diffuse rectangle in the plane y = 0 that faces up.
inline std::string floor_xml(const std::string& bsdf) {
  return "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"50\"/><rotate "
         "x=\"1\" "
         "angle=\"-90\"/></transform>" +
         bsdf + "</shape>";
}

inline std::string direct_xml(const std::string& parameters = "") {
  return "<integrator type=\"direct\">" + parameters + "</integrator>";
}
inline std::string samples_xml(int emitter, int bsdf) {
  return "<integer name=\"emitter_samples\" value=\"" + std::to_string(emitter) +
         "\"/><integer name=\"bsdf_samples\" value=\"" + std::to_string(bsdf) + "\"/>";
}

inline std::string constant_xml(const std::string& rgb) {
  return "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"" + rgb + "\"/></emitter>";
}

inline std::string diffuse_xml(const std::string& rgb) {
  return "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"" + rgb + "\"/></bsdf>";
}

/// Writes a map and returns its emitter.
inline std::string envmap_xml(const TemporaryFolder& folder, int width, int height,
                              const std::function<Rgb(int x, int y)>& texel,
                              const std::string& transform = "", const std::string& name = "map") {
  Image image{width, height, {"R", "G", "B"}, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = texel(x, y);
      image.data.insert(image.data.end(), {c.x, c.y, c.z});
    }
  }
  const std::string path = folder.path(name + ".pfm");
  write_pfm(path, image);
  return "<emitter type=\"envmap\"><string name=\"filename\" value=\"" + path +
         "\"/><transform name=\"to_world\">" + transform + "</transform></emitter>";
}

/// Returns one channel of estimate_pixels(). The channels of grey light are dependent, but a z-test
/// requires independent values.
inline std::vector<Estimate> channel(const std::vector<Estimate>& pixels, int c) {
  std::vector<Estimate> one;
  for (size_t i = c; i < pixels.size(); i += 3) one.push_back(pixels[i]);
  return one;
}

/// Renders of one estimate: enough for z values that are nearly normal.
inline constexpr int kRenders = 64;

/// z-tests of all pixels, channel by channel, with a total false-alarm rate of `alpha`.
inline void expect_equal(const std::vector<Estimate>& a, const std::vector<Estimate>& b,
                         double alpha, const std::string& name) {
  for (int c = 0; c < 3; ++c) {
    const Verdict verdict = z_test(channel(a, c), channel(b, c), alpha / 3);
    EXPECT_TRUE(verdict.passed) << name << ", channel " << c << ": " << verdict.text;
  }
}

/// `pixels` times the same exact colour.
inline std::vector<Estimate> exactly(const Rgb& colour, int pixels) {
  std::vector<Estimate> estimates;
  for (int i = 0; i < pixels; ++i) {
    for (int c = 0; c < 3; ++c) estimates.push_back({colour[c], 0});
  }
  return estimates;
}

}  // namespace kinome::test
