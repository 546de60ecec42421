#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "kinome/math.h"
#include "scene_node.h"

/// Nodes of a scene file with their values.
namespace kinome::test {

inline std::string digits(double v) {
  return fmt::format("{:.9g}", v);
}
inline std::string digits(const Vec3& v) {
  return digits(v.x) + " " + digits(v.y) + " " + digits(v.z);
}
inline SceneNode value_of(const std::string& tag, const std::string& name,
                          const std::string& value) {
  return {tag, {{"name", name}, {"value", value}}};
}
inline SceneNode number(const std::string& name, double v) {
  return value_of("float", name, digits(v));
}
inline SceneNode integer(const std::string& name, int64_t v) {
  return value_of("integer", name, std::to_string(v));
}
inline SceneNode boolean(const std::string& name, bool v) {
  return value_of("boolean", name, v ? "true" : "false");
}
inline SceneNode rgb(const std::string& name, const Vec3& v) {
  return value_of("rgb", name, digits(v));
}
inline SceneNode text(const std::string& name, const std::string& v) {
  return value_of("string", name, v);
}
inline SceneNode object(const std::string& tag, const std::string& type,
                        std::vector<SceneNode> children = {}) {
  return {tag, {{"type", type}}, std::move(children)};
}
inline SceneNode named(SceneNode node, const std::string& name) {
  node.attributes.emplace_back("name", name);
  return node;
}

}  // namespace kinome::test
