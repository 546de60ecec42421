#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "gltf_accessor.h"
#include "mesh_file.h"

/// Vertices and triangles of one glTF primitive, before any transform.
namespace kinome {

struct GltfVertices {
  std::vector<double> positions;  ///< three values per vertex
  std::vector<double> normals;    ///< three values per vertex, or empty
  std::vector<double> uvs;        ///< two values per vertex, or empty
  size_t count = 0;
};

/// Reads POSITION, NORMAL and TEXCOORD_0, and adds the morph targets times `weights` (glTF 2.0,
/// 3.7.2.2).
inline GltfVertices read_vertices(const GltfAccessors& accessors,
                                  const tinygltf::Primitive& primitive,
                                  const std::vector<double>& weights, const std::string& name) {
  const auto read = [&](const char* attribute, int type) {
    const auto found = primitive.attributes.find(attribute);
    if (found == primitive.attributes.end()) return std::vector<double>();
    std::vector<double> values = accessors.read(found->second, type, name + ", " + attribute);
    for (size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
      const auto target = primitive.targets[i].find(attribute);
      if (weights[i] == 0 || target == primitive.targets[i].end()) continue;
      const std::vector<double> moves = accessors.read(
          target->second, type, name + ", target " + std::to_string(i) + ", " + attribute);
      if (moves.size() != values.size()) {
        accessors.fail(name + " has a morph target with a different number of vertices");
      }
      for (size_t k = 0; k < values.size(); ++k) values[k] += weights[i] * moves[k];
    }
    return values;
  };
  GltfVertices vertices;
  vertices.positions = read("POSITION", TINYGLTF_TYPE_VEC3);
  vertices.normals = read("NORMAL", TINYGLTF_TYPE_VEC3);
  vertices.uvs = read("TEXCOORD_0", TINYGLTF_TYPE_VEC2);
  vertices.count = vertices.positions.size() / 3;
  if (vertices.count == 0) accessors.fail(name + " has no positions");
  if ((!vertices.normals.empty() && vertices.normals.size() != vertices.count * 3) ||
      (!vertices.uvs.empty() && vertices.uvs.size() != vertices.count * 2)) {
    accessors.fail(name + " has attributes of different lengths");
  }
  return vertices;
}

/// Reads red, green and blue of COLOR_0, without the opacity that may follow. White if the
/// primitive has no COLOR_0.
inline std::vector<float> read_colors(const GltfAccessors& accessors, const tinygltf::Model& model,
                                      const tinygltf::Primitive& primitive, size_t count,
                                      const std::string& name) {
  std::vector<float> colors(3 * count, 1.f);
  const auto found = primitive.attributes.find("COLOR_0");
  if (found == primitive.attributes.end()) return colors;
  const std::string what = name + ", COLOR_0";
  const bool has_alpha =
      accessors.at(model.accessors, found->second, "accessor", what).type == TINYGLTF_TYPE_VEC4;
  const std::vector<double> values =
      accessors.read(found->second, has_alpha ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3, what);
  const size_t size = has_alpha ? 4 : 3;
  if (values.size() != size * count) {
    accessors.fail(name + " has attributes of different lengths");
  }
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(values[size * i + k])) accessors.fail(what + " is not finite");
      colors[3 * i + k] = static_cast<float>(values[size * i + k]);
    }
  }
  return colors;
}

inline bool is_of_triangles(const tinygltf::Primitive& primitive) {
  return primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == -1 ||
         primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
         primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
}

/// Returns the number of triangles of a list, strip or fan with `corners` vertices.
inline size_t face_count(const tinygltf::Primitive& primitive, size_t corners) {
  const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == -1;
  return is_list ? corners / 3 : std::max<size_t>(corners, 2) - 2;
}

/// Reads the triangles of a list, strip or fan with `count` vertices (glTF 2.0, 3.7.2.1).
inline std::vector<glm::uvec3> read_triangles(const GltfAccessors& accessors,
                                              const tinygltf::Primitive& primitive, size_t count,
                                              const std::string& name) {
  std::vector<uint32_t> indices;
  if (primitive.indices < 0) {
    for (size_t i = 0; i < count; ++i) indices.push_back(static_cast<uint32_t>(i));
  } else {
    const std::vector<double> stored =
        accessors.read(primitive.indices, TINYGLTF_TYPE_SCALAR, name + ", indices");
    indices.reserve(stored.size());
    for (const double index : stored) {
      if (!(index >= 0) || !(index < static_cast<double>(count)) || index != std::floor(index)) {
        accessors.fail(name + " refers to vertex " + format_index(index) + ", expected 0 to " +
                       std::to_string(count - 1));
      }
      indices.push_back(static_cast<uint32_t>(index));
    }
  }
  const bool is_strip = primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
  const bool is_fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
  if (!is_strip && !is_fan && indices.size() % 3 != 0) {
    accessors.fail(name + " has " + std::to_string(indices.size()) +
                   " indices, expected a multiple of 3");
  }
  std::vector<glm::uvec3> triangles;
  for (size_t i = 0; i + 2 < indices.size(); i += is_strip || is_fan ? 1 : 3) {
    glm::uvec3 triangle(indices[i], indices[i + 1], indices[i + 2]);
    if (is_strip && i % 2 == 1) std::swap(triangle.y, triangle.z);
    if (is_fan) triangle.x = indices[0];
    triangles.push_back(triangle);
  }
  return triangles;
}

}  // namespace kinome
