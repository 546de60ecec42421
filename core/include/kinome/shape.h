#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/bsdf.h"
#include "kinome/distribution.h"
#include "kinome/emitter.h"
#include "kinome/interaction.h"
#include "kinome/object.h"
#include "kinome/properties.h"
#include "kinome/sensor.h"

namespace kinome {

/// Values stored in a mesh file for each vertex or each triangle.
struct MeshAttribute {
  std::string name;           ///< "vertex_…" or "face_…"
  uint32_t size = 3;          ///< values per vertex or triangle; textures support 1 or 3
  std::vector<float> values;  ///< of the first vertex or triangle, then of the next, …
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

/// Surface point sampled as seen from a reference point.
struct SurfaceSample {
  SurfaceInteraction si;  ///< t and wi are not set
  float pdf = 0;          ///< per solid angle at the reference point
};

/// Geometry with its material and emitter. A shape is either a mesh, a set of curves, or analytic
/// (implements intersect()).
class KINOME_EXPORT Shape : public Object {
 public:
  /// Triangles in world space, or nullptr if the shape is not a mesh.
  virtual const TriangleMesh* mesh() const { return nullptr; }
  /// Curves in world space, or nullptr if the shape has none.
  virtual const CurveSet* curves() const { return nullptr; }
  /// World-space bounding box.
  virtual Aabb bounds() const = 0;
  /// Shapes that replace this one in a scene, always the same objects. Empty: the shape represents
  /// itself.
  virtual std::vector<std::shared_ptr<Shape>> parts() const { return {}; }

  /// Analytic shapes only: finds the nearest hit in [tmin, tmax]. Sets t, and u, v and primitive as
  /// interaction() needs them. Returns false without a hit. Called from Embree, on any thread.
  virtual bool intersect(const Ray& /*ray*/, float& /*t*/, Hit& /*hit*/) const { return false; }
  /// Computes the surface interaction of a hit: all fields but `shape`, which Scene sets.
  virtual SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const = 0;
  /// Analytic shapes only: intersects the active lanes (valid[i] != 0) of 16 rays. Default: calls
  /// intersect() lane by lane.
  virtual void intersect_block(const Ray16& rays, const int* valid, ShapeHit16& out) const;
  /// Computes interaction() for rays out.ray[0 … out.count - 1]. Sets all columns of `out` except
  /// `ray` and `shape`. Default: ray by ray.
  virtual void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const;
  /// World-space surface area.
  virtual float area() const = 0;

  /// Samples a point uniformly by area, with density 1 / area(). Does not set t, wi and shape.
  virtual SurfaceInteraction sample_surface(const Vec2& u) const = 0;
  /// Samples out.count points as sample_surface() does. Sets all columns of `out` except `ray` and
  /// `shape`; `wi` is undefined. Default: point by point.
  virtual void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const;
  /// Samples a point as seen from p, on either side of the surface. Returns nullopt if the point
  /// coincides with p or is seen edge-on. Default: uses sample_surface().
  virtual std::optional<SurfaceSample> sample_solid_angle(const Vec3& p, const Vec2& u) const;
  /// Density of sample_solid_angle(p) for the point `si`, per solid angle at p.
  virtual float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const;

  /// Block versions of the two functions above. Default: point by point.
  virtual void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                        const SurfaceSampleBlock& out) const;
  virtual void pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                                     float* pdf) const;

  /// BSDF of the surface. The loader gives shapes without a BSDF a diffuse one with reflectance
  /// 0.5, as in Mitsuba, or a black one if they emit.
  const Bsdf& bsdf() const { return *bsdf_; }
  std::shared_ptr<Bsdf> bsdf_pointer() const { return bsdf_; }
  void set_bsdf(std::shared_ptr<Bsdf> bsdf) { bsdf_ = std::move(bsdf); }
  /// Replaces the surface emitter. `emitter` must not belong to another shape. Used for scene
  /// edits: not while rendering, and the previous emitter's shape() must not be used afterwards.
  void set_emitter(std::shared_ptr<Emitter> emitter);
  const Emitter* emitter() const { return emitter_.get(); }
  std::shared_ptr<Emitter> emitter_pointer() const { return emitter_; }
  /// Sensor that measures at this shape, or nullptr.
  std::shared_ptr<Sensor> sensor_pointer() const { return sensor_; }

  /// Returns the attribute of this name, or nullopt if there is none. Only meshes have attributes.
  virtual std::optional<AttributeArrays> attribute(const std::string& /*name*/) const {
    return std::nullopt;
  }
  /// Names of the attributes that the textures of its BSDF and emitter read, without duplicates.
  std::vector<std::string> wanted_attributes() const;

 protected:
  /// Leaves BSDF, emitter and sensor empty.
  Shape() = default;
  /// Takes the nested BSDF, emitter and sensor from `props`. The loader sets a missing BSDF.
  explicit Shape(const Properties& props);

 private:
  std::shared_ptr<Bsdf> bsdf_;
  std::shared_ptr<Emitter> emitter_;
  std::shared_ptr<Sensor> sensor_;
};

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
  /// mirroring transforms keep the winding consistent. A mesh without faces is valid; scenes leave
  /// it out.
  void finish(const Properties& props, const Transform& to_world, bool face_normals,
              bool flip_normals);
  /// Returns the surface point at a hit's triangle and barycentric coordinates, as sample_surface()
  /// does.
  SurfaceInteraction sampled_at(const Hit& hit) const;
  /// Distribution over triangles by area: a grid with a single row.
  const GridDistribution& by_area() const;
  /// View of the mesh; valid after finish().
  MeshArrays arrays() const;
  TriangleMesh mesh_;

 private:
  void measure();
  Aabb bounds_;
  float area_ = 0;
  bool flip_normals_ = false;
  bool flip_geometric_normal_ = false;
  /// Built when first sampled, because few meshes are.
  struct ByArea {
    std::once_flag made;
    GridDistribution triangles;
  };
  std::unique_ptr<ByArea> by_area_ = std::make_unique<ByArea>();
};

}  // namespace kinome
