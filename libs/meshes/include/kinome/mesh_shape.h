#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "kinome/distribution.h"
#include "kinome/properties.h"
#include "kinome/shape.h"

namespace kinome {

/// View of a mesh for evaluation at surface points. Up to one value beyond the end of positions and
/// normals may be read. Owns nothing.
struct MeshArrays {
  const float* positions;     ///< three per vertex
  const float* normals;       ///< three per vertex; nullptr: flat shading
  const float* uvs;           ///< two per vertex; nullptr: none
  const uint32_t* triangles;  ///< three vertex indices per triangle
  float side;                 ///< longest side of the bounding box
  bool flip;                  ///< true if the geometric normal is opposite to the winding's
};

/// Base class of triangle meshes. A subclass fills `mesh_` in object space in its constructor and
/// then calls finish(). wide::Mesh (kinome/wide/mesh.h) adds block versions of interaction().
class KINOME_EXPORT MeshShape : public Shape {
 public:
  const TriangleMesh* mesh() const override { return &mesh_; }
  Aabb bounds() const override { return bounds_; }
  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override;
  float area() const override { return area_; }
  SurfaceInteraction sample_surface(const Vec2& u) const override;
  std::optional<AttributeArrays> attribute(const std::string& name) const override;

  /// Replaces the mesh by other triangles in world space, for scene edits. Recomputes normals from
  /// the new positions if the mesh has normals, unless `keep_normals`. Must not be called while
  /// rendering; scenes that contain the shape must be rebuilt. Throws Error at `where` and changes
  /// nothing if array sizes are inconsistent or don't fit the attributes. Returns a function that
  /// restores the previous mesh.
  std::function<void()> replace_mesh(TriangleMesh mesh, bool keep_normals, const Location& where);

 protected:
  explicit MeshShape(const Properties& props) : Shape(props) {}
  /// Validates the mesh and applies `to_world`. Throws Error at the file or at the shape if an
  /// index is out of range or a position is not finite.
  ///
  /// Computes angle-weighted normals if the mesh has none, and for vertices whose normal is 0 or
  /// not finite. `face_normals` drops all normals instead. `flip_normals` inverts normals;
  /// mirroring transforms keep the winding consistent. A mesh without faces is valid; scenes omit
  /// it.
  void finish(const Properties& props, const Transform& to_world, bool face_normals,
              bool flip_normals);
  /// Returns the surface point at a hit's triangle and barycentric coordinates, as sample_surface()
  /// does.
  SurfaceInteraction sampled_at(const Hit& hit) const;
  /// Distribution over triangles by area: a grid with a single row.
  const GridDistribution& area_distribution() const;
  /// True if replace_mesh() replaced the mesh of the constructor. Shapes that compute surface
  /// points by formulas of their own must then use the mesh instead.
  bool is_replaced() const { return is_replaced_; }
  /// View of the mesh; valid after finish().
  MeshArrays arrays() const;
  TriangleMesh mesh_;

 private:
  void measure();
  Aabb bounds_;
  float area_ = 0;
  bool flip_normals_ = false;
  bool flip_geometric_normal_ = false;
  bool is_replaced_ = false;
  /// Built on first use, because few meshes are sampled.
  struct AreaDistribution {
    std::once_flag made;
    GridDistribution triangles;
  };
  std::unique_ptr<AreaDistribution> by_area_ = std::make_unique<AreaDistribution>();
};

}  // namespace kinome
