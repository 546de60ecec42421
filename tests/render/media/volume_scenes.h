#pragma once

#include "render/paths/path_scenes.h"

/// Parts of scenes with media.
namespace kinome::test {

inline std::string rgb_volume_xml(const std::string& name, const std::string& rgb) {
  return "<volume type=\"constvolume\" name=\"" + name + "\"><rgb name=\"value\" value=\"" + rgb +
         "\"/></volume>";
}
inline std::string phase_xml(float g) {
  return "<phase type=\"hg\"><float name=\"g\" value=\"" + std::to_string(g) + "\"/></phase>";
}
/// A homogeneous medium inside of a shape. `name`: interior or exterior.
inline std::string fog_xml(const std::string& extinction, const std::string& albedo,
                           const std::string& more = "", const std::string& name = "interior") {
  return "<medium type=\"homogeneous\" name=\"" + name + "\">" +
         rgb_volume_xml("sigma_t", extinction) + rgb_volume_xml("albedo", albedo) + more +
         "</medium>";
}
inline const char* const kBoundary = "<bsdf type=\"null\"/>";
/// The cube [-1, 1]³ filled with a medium.
inline std::string fog_cube_xml(const std::string& medium, const std::string& transform = "") {
  return shape_xml("cube", transform, kBoundary + medium);
}
/// Parallel rays along -z, from z = 5, that cover [-size, size]².
inline std::string parallel_view(double size, int side, int samples) {
  return sensor_xml("orthographic",
                    "<scale x=\"" + std::to_string(size) + "\" y=\"" + std::to_string(size) +
                        "\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"),
                    side, samples);
}

}  // namespace kinome::test
