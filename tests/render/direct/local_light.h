#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "direct_scenes.h"
#include "kinome/image_files.h"

/// Floors and emitters for closed forms of irradiance.
namespace kinome::test::local_light {

constexpr double kAlpha = 1e-4;  // level of each of about 60 z-tests
constexpr double kPiD = std::numbers::pi;
constexpr double kAlbedo = 0.5;

/// A diffuse floor of albedo 1/2 at y = 0, in a close-up around (x, 0, z), so that its irradiance
/// is that of the point itself.
inline std::string floor_at(float x, float z) {
  const std::string at = std::to_string(x) + " 0 " + std::to_string(z);
  const std::string from = std::to_string(x + 0.3f) + " 0.2 " + std::to_string(z);
  return floor_xml(diffuse_xml("0.5")) +
         sensor_xml("orthographic", "<scale value=\"0.0001\"/>" + look_at(from, at, "0 1 0"), 3, 4);
}

inline std::string light_xml(const std::string& type, const std::string& transform,
                             const std::string& parameters) {
  return "<emitter type=\"" + type + "\"><transform name=\"to_world\">" + transform +
         "</transform>" + parameters + "</emitter>";
}

inline std::string number_xml(const std::string& name, double value) {
  return "<float name=\"" + name + "\" value=\"" + std::to_string(value) + "\"/>";
}

/// Down from (0, 2, 0).
inline const std::string kDown = "<lookat origin=\"0 2 0\" target=\"0 0 0\" up=\"0 0 1\"/>";

inline std::string nearest_xml(const std::string& name, const std::string& path) {
  return "<texture type=\"bitmap\" name=\"" + name + "\"><string name=\"filename\" value=\"" +
         path + "\"/><string name=\"filter_type\" value=\"nearest\"/></texture>";
}

}  // namespace kinome::test::local_light
