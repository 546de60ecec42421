#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "kinome/shape.h"
#include "ply_header.h"

namespace kinome {

/// Texture coordinates of the faces' corners, as written by MeshLab and photogrammetry programs:
/// each face has a list 'texcoord' with two values per corner.
class PlyWedges {
 public:
  explicit PlyWedges(bool flip_v) : flip_v_(flip_v) {}

  /// Returns the index of the list among the faces' properties, or -1.
  static int find(const PlyElement& faces) { return faces.find_list("texcoord"); }
  /// Sets the first triangle that the faces add to the mesh.
  void begin(size_t first_triangle) { first_triangle_ = first_triangle; }
  /// Appends a value of a face's list.
  void put(float value) { of_face_.push_back(value); }
  /// Ends a face that became a fan of `triangles`. If its list has a wrong length, its coordinates
  /// are 0.
  void end_face(size_t triangles) {
    of_face_.resize(triangles > 0 && of_face_.size() == 2 * (triangles + 2) ? of_face_.size() : 0);
    const auto corner = [&](size_t i) {
      if (of_face_.empty()) return Vec2(0.f);
      const float v = of_face_[2 * i + 1];
      return Vec2(of_face_[2 * i], flip_v_ ? 1 - v : v);
    };
    for (size_t i = 0; i < triangles; ++i) {
      uvs_.insert(uvs_.end(), {corner(0), corner(i + 1), corner(i + 2)});
    }
    of_face_.clear();
  }

  /// Adds the coordinates to the mesh. A vertex whose corners have different coordinates is
  /// duplicated.
  void move_to(TriangleMesh& mesh) {
    if (uvs_.empty()) return;
    std::vector<bool> is_set(mesh.positions.size());
    std::map<std::tuple<uint32_t, float, float>, uint32_t> copies;
    mesh.uvs.assign(mesh.positions.size(), Vec2(0.f));
    for (size_t i = 0; i < uvs_.size(); ++i) {
      uint32_t& vertex = mesh.triangles[first_triangle_ + i / 3][static_cast<int>(i % 3)];
      Vec2 uv = uvs_[i];
      // NaN would break the comparisons.
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = Vec2(0.f);
      if (!is_set[vertex]) {
        is_set[vertex] = true;
        mesh.uvs[vertex] = uv;
      }
      if (mesh.uvs[vertex] == uv) continue;
      const auto next = static_cast<uint32_t>(mesh.positions.size());
      const auto [copy, is_new] = copies.try_emplace({vertex, uv.x, uv.y}, next);
      if (is_new) add_copy(mesh, vertex, uv);
      vertex = copy->second;
    }
    uvs_.clear();
  }

 private:
  static void add_copy(TriangleMesh& mesh, uint32_t vertex, const Vec2& uv) {
    mesh.positions.push_back(Vec3(mesh.positions[vertex]));
    mesh.uvs.push_back(uv);
    if (!mesh.normals.empty()) mesh.normals.push_back(Vec3(mesh.normals[vertex]));
    for (MeshAttribute& attribute : mesh.attributes) {
      if (attribute.is_of_faces()) continue;
      for (uint32_t k = 0; k < attribute.size; ++k) {
        attribute.values.push_back(float{attribute.values[vertex * attribute.size + k]});
      }
    }
  }

  bool flip_v_;
  size_t first_triangle_ = 0;
  std::vector<float> of_face_;
  std::vector<Vec2> uvs_;  ///< three per triangle
};

}  // namespace kinome
