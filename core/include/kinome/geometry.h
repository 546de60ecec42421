#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinome/math.h"

/// Geometry that Embree traces: triangles and curves.
namespace kinome {

/// Values stored in a mesh file for each vertex or each triangle.
struct MeshAttribute {
  std::string name;           ///< "vertex_…" or "face_…"
  uint32_t size = 3;          ///< values per vertex or triangle; textures support 1 or 3
  std::vector<float> values;  ///< `size` values per vertex or triangle, in their order
  bool is_of_faces() const { return name.starts_with("face_"); }
};

/// View of a MeshAttribute for evaluation at surface points. Owns nothing.
struct AttributeArrays {
  const MeshAttribute* attribute;
  const float* positions;     ///< three per vertex
  const uint32_t* triangles;  ///< three vertex indices per triangle
  Mat4 to_mesh;               ///< from world space to the space of `positions`
};

/// Triangles in world space, with indexed vertices.
struct TriangleMesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< per vertex, unit; empty: flat shading
  std::vector<Vec2> uvs;      ///< per vertex; empty: barycentric coordinates are used as uv
  std::vector<glm::uvec3> triangles;
  std::vector<MeshAttribute> attributes;  ///< attributes that the shape's textures read
};

/// Curves with round cross-sections, in world space: chains of cones with spheres at the joints, or
/// uniform cubic B-splines with four consecutive control points per segment.
struct CurveSet {
  bool is_bspline = false;
  std::vector<glm::vec4> points;   ///< control points; w is the radius, positive
  std::vector<uint32_t> segments;  ///< first control point of each segment, in file order
};

}  // namespace kinome
