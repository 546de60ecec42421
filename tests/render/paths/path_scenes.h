#pragma once

#include <string>

#include "render/direct/direct_scenes.h"

/// Parts of scenes with light after several bounces.
namespace kinome::test {

inline std::string integrator_xml(const std::string& type, int max_depth,
                                  const std::string& parameters = "") {
  return "<integrator type=\"" + type + "\"><integer name=\"max_depth\" value=\"" +
         std::to_string(max_depth) + "\"/>" + parameters + "</integrator>";
}
inline std::string rr_depth_xml(int depth) {
  return "<integer name=\"rr_depth\" value=\"" + std::to_string(depth) + "\"/>";
}
inline const char* const kHideEmitters = "<boolean name=\"hide_emitters\" value=\"true\"/>";

/// A shape with the operations of its to_world transform.
inline std::string shape_xml(const std::string& type, const std::string& transform,
                             const std::string& content) {
  return "<shape type=\"" + type + "\"><transform name=\"to_world\">" + transform + "</transform>" +
         content + "</shape>";
}

inline std::string point_xml(const std::string& position, const std::string& intensity) {
  return "<emitter type=\"point\"><point name=\"position\" value=\"" + position +
         "\"/><rgb name=\"intensity\" value=\"" + intensity + "\"/></emitter>";
}
inline std::string area_xml(const std::string& radiance) {
  return "<emitter type=\"area\"><rgb name=\"radiance\" value=\"" + radiance + "\"/></emitter>";
}

/// The inside of the cube [-1, 1]³, with walls of different colours.
inline std::string room_xml() {
  const auto wall = [](const std::string& transform, const std::string& rgb) {
    return shape_xml("rectangle", transform, diffuse_xml(rgb));
  };
  return wall("<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\"/>", "0.7 0.7 0.7") +
         wall("<rotate x=\"1\" angle=\"90\"/><translate y=\"1\"/>", "0.6 0.7 0.6") +
         wall("<translate z=\"-1\"/>", "0.5 0.5 0.7") +
         wall("<rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/>", "0.3 0.3 0.3") +
         wall("<rotate y=\"1\" angle=\"90\"/><translate x=\"-1\"/>", "0.7 0.2 0.1") +
         wall("<rotate y=\"1\" angle=\"-90\"/><translate x=\"1\"/>", "0.1 0.5 0.2");
}

/// A view of the room from its back wall.
inline std::string room_view(int side, int samples, const std::string& type = "perspective") {
  return sensor_xml(type, look_at("0 0 0.95", "0.1 -0.2 -1", "0 1 0"), side, samples);
}

}  // namespace kinome::test
