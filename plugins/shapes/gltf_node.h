#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "gltf_accessor.h"
#include "kinome/math.h"

/// Transforms of glTF nodes and of their instances.
namespace kinome {

/// Returns the matrix of a scale, a rotation (a quaternion x, y, z, w of any length but 0) and a
/// translation, applied in this order (glTF 2.0, 3.5.3). nullptr stands for the identity.
inline glm::dmat4 trs_matrix(const double* translation, const double* rotation,
                             const double* scale) {
  glm::dmat4 m(1.);
  if (rotation) {
    glm::dvec4 q(rotation[0], rotation[1], rotation[2], rotation[3]);
    const double length = glm::length(q);
    // Rotations that are stored as integers have a length of nearly 1.
    q = length > 0 ? q / length : glm::dvec4(0, 0, 0, 1);
    m = glm::mat4_cast(glm::dquat(q.w, q.x, q.y, q.z));
  }
  for (int i = 0; scale && i < 3; ++i) m[i] *= scale[i];
  if (translation) m[3] = {translation[0], translation[1], translation[2], 1};
  return m;
}

/// Returns the transform from a node's space to its parent's.
inline glm::dmat4 local_matrix(const GltfAccessors& accessors, const tinygltf::Node& node,
                               const std::string& name) {
  const auto values = [&](const std::vector<double>& v, size_t size, const char* what) {
    if (!v.empty() && v.size() != size) {
      accessors.fail(name + " has a " + what + " of " + std::to_string(v.size()) +
                     " numbers, expected " + std::to_string(size));
    }
    return v.empty() ? nullptr : v.data();
  };
  if (const double* const matrix = values(node.matrix, 16, "matrix")) {
    glm::dmat4 m;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = matrix[i];
    return m;
  }
  return trs_matrix(values(node.translation, 3, "translation"),
                    values(node.rotation, 4, "rotation"), values(node.scale, 3, "scale"));
}

/// Returns a member of an extension's JSON, or a null value. The library's own look-up requires an
/// object.
inline tinygltf::Value json_member(const tinygltf::Value& value, const std::string& name) {
  return value.IsObject() ? value.Get(name) : tinygltf::Value();
}

/// Returns the accessors of EXT_mesh_gpu_instancing that give the transforms of a node's instances.
inline std::vector<int> instance_accessors(const tinygltf::Node& node) {
  std::vector<int> accessors;
  const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == node.extensions.end()) return accessors;
  const tinygltf::Value attributes = json_member(extension->second, "attributes");
  for (const char* const attribute : {"TRANSLATION", "ROTATION", "SCALE"}) {
    const tinygltf::Value accessor = json_member(attributes, attribute);
    if (accessor.IsInt()) accessors.push_back(accessor.GetNumberAsInt());
  }
  return accessors;
}

/// Returns the transforms of the copies of a node's mesh, in the node's space: one for each
/// instance of EXT_mesh_gpu_instancing, or only the identity.
inline std::vector<glm::dmat4> instance_matrices(const GltfAccessors& accessors,
                                                 const tinygltf::Node& node,
                                                 const std::string& name) {
  const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == node.extensions.end()) return {glm::dmat4(1.)};
  const tinygltf::Value attributes = json_member(extension->second, "attributes");
  const auto read = [&](const char* attribute, int type) {
    const tinygltf::Value accessor = json_member(attributes, attribute);
    if (!accessor.IsInt()) return std::vector<double>();
    return accessors.read(accessor.GetNumberAsInt(), type, name + ", instances' " + attribute);
  };
  const std::vector<double> translations = read("TRANSLATION", TINYGLTF_TYPE_VEC3);
  const std::vector<double> rotations = read("ROTATION", TINYGLTF_TYPE_VEC4);
  const std::vector<double> scales = read("SCALE", TINYGLTF_TYPE_VEC3);
  const size_t count = std::max({translations.size() / 3, rotations.size() / 4, scales.size() / 3});
  const auto fits = [count](const std::vector<double>& v, size_t size) {
    return v.empty() || v.size() == count * size;
  };
  if (!fits(translations, 3) || !fits(rotations, 4) || !fits(scales, 3)) {
    accessors.fail(name + " has instances' attributes of different lengths");
  }
  if (count == 0) accessors.fail(name + " has instances without TRANSLATION, ROTATION or SCALE");
  std::vector<glm::dmat4> matrices;
  const auto item = [](const std::vector<double>& v, size_t i) {
    return v.empty() ? nullptr : v.data() + i;
  };
  for (size_t i = 0; i < count; ++i) {
    matrices.push_back(
        trs_matrix(item(translations, 3 * i), item(rotations, 4 * i), item(scales, 3 * i)));
  }
  return matrices;
}

/// True if KHR_node_visibility hides the node and its descendants.
inline bool is_hidden(const tinygltf::Node& node) {
  const auto extension = node.extensions.find("KHR_node_visibility");
  if (extension == node.extensions.end()) return false;
  const tinygltf::Value visible = json_member(extension->second, "visible");
  return visible.IsBool() && !visible.Get<bool>();
}

}  // namespace kinome
