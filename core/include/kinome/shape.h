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

/// Numbers that a mesh's file gives to each vertex, or to each triangle.
struct MeshAttribute {
  std::string name;           ///< "vertex_…" or "face_…"
  uint32_t size = 3;          ///< numbers of each; textures take 1 or 3
  std::vector<float> values;  ///< of the first vertex or triangle, then of the next …
  bool is_of_faces() const { return name.starts_with("face_"); }
};

/// A MeshAttribute as functions over points read it. Owns nothing.
struct AttributeArrays {
  const MeshAttribute* attribute;
  const float* positions;     ///< three of each vertex
  const uint32_t* triangles;  ///< three vertices of each
  Mat4 to_mesh;               ///< from world space to that of the positions
};

/// Triangles in world space. Vertices shared by their indices.
struct TriangleMesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< per vertex, unit; empty: flat shading by face
  std::vector<Vec2> uvs;      ///< per vertex; empty: barycentric coordinates serve as uv
  std::vector<glm::uvec3> triangles;
  std::vector<MeshAttribute> attributes;  ///< those that textures of the shape ask for
};

/// Curves of round cross section, in world space: chains of cones with spheres at their ends, or
/// uniform cubic B-splines, of which four control points in a row make a segment.
struct CurveSet {
  bool is_bspline = false;
  std::vector<glm::vec4> points;   ///< control points; w is the radius, positive
  std::vector<uint32_t> segments;  ///< the first control point of each, in the file's order
};

/// A point of a surface, chosen as seen from another point.
struct SurfaceSample {
  SurfaceInteraction si;  ///< t and wi are not set
  float pdf = 0;          ///< per solid angle at the other point
};

/// Geometry with its material and light. Either a mesh, or curves, or analytic by `intersect`.
class KINOME_EXPORT Shape : public Object {
 public:
  /// Its triangles, or nullptr for an analytic shape.
  virtual const TriangleMesh* mesh() const { return nullptr; }
  /// Its curves, or nullptr.
  virtual const CurveSet* curves() const { return nullptr; }
  virtual Aabb bounds() const = 0;
  /// The shapes that a scene has in its place, always the same ones; empty: itself.
  virtual std::vector<std::shared_ptr<Shape>> parts() const { return {}; }

  /// Analytic shapes only: the nearest hit in [tmin, tmax]; writes t, and u, v, primitive as
  /// interaction() wants them. Called from Embree, from any thread.
  virtual bool intersect(const Ray& /*ray*/, float& /*t*/, Hit& /*hit*/) const { return false; }
  /// What the hit means: everything of SurfaceInteraction except `shape`, which Scene sets.
  virtual SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const = 0;
  /// Analytic shapes only: intersect() of the lanes of 16 rays that are on (valid[i] != 0).
  /// Default: one by one.
  virtual void intersect_block(const Ray16& rays, const int* valid, ShapeHit16& out) const;
  /// interaction() of the rays out.ray[0 … out.count - 1]: all columns of `out` but `ray` and
  /// `shape`. Default: one by one.
  virtual void interaction_block(const RayHit16* rays, const SurfaceBlock& out) const;
  /// World-space surface area.
  virtual float area() const = 0;

  /// A point uniform by area: density 1 / area() per unit of area. t, wi and shape are not set:
  /// that is for the caller.
  virtual SurfaceInteraction sample_surface(const Vec2& u) const = 0;
  /// The same for out.count points: all columns of `out` but `ray` and `shape`; what `wi` holds
  /// afterwards means nothing. Default: one by one.
  virtual void sample_surface_block(const Columns2& u, const SurfaceBlock& out) const;
  /// A point as seen from p, on whichever side; nullopt where it is at p or edge-on. Default:
  /// sample_surface.
  virtual std::optional<SurfaceSample> sample_solid_angle(const Vec3& p, const Vec2& u) const;
  /// Density of sample_solid_angle(p) for a point of the surface, per solid angle at p.
  virtual float pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const;

  /// Both over blocks. Default: one by one.
  virtual void sample_solid_angle_block(const Columns3& p, const Columns2& u, size_t count,
                                        const SurfaceSampleBlock& out) const;
  virtual void pdf_solid_angle_block(const Columns3& p, const SurfaceBlock& points,
                                     float* pdf) const;

  /// Never nullptr: a shape without a BSDF is diffuse .5, as in Mitsuba; one that emits without a
  /// BSDF reflects nothing.
  const Bsdf& bsdf() const { return *bsdf_; }
  std::shared_ptr<Bsdf> bsdf_pointer() const { return bsdf_; }
  void set_bsdf(std::shared_ptr<Bsdf> bsdf) { bsdf_ = std::move(bsdf); }
  /// Puts an emitter of surfaces, which no other shape has, in place of the one that it has. For
  /// edits: not while anything is rendered, and nothing may ask the former one for its shape.
  void set_emitter(std::shared_ptr<Emitter> emitter);
  const Emitter* emitter() const { return emitter_.get(); }
  std::shared_ptr<Emitter> emitter_pointer() const { return emitter_; }
  /// One that measures at this shape, or nullptr.
  std::shared_ptr<Sensor> sensor_pointer() const { return sensor_; }

  /// The attribute of this name; nullopt where there is none, as of all shapes that are no meshes.
  virtual std::optional<AttributeArrays> attribute(const std::string& /*name*/) const {
    return std::nullopt;
  }
  /// Names of the attributes that textures of its BSDF and its emitter read, each once.
  std::vector<std::string> wanted_attributes() const;

 protected:
  /// Without BSDF, emitter and sensor.
  Shape() = default;
  /// Takes the nested bsdf, emitter and sensor. The scene fills in the default BSDF.
  explicit Shape(const Properties& props);

 private:
  std::shared_ptr<Bsdf> bsdf_;
  std::shared_ptr<Emitter> emitter_;
  std::shared_ptr<Sensor> sensor_;
};

/// A mesh as functions over its points read it: of positions and normals, up to a value beyond the
/// end. Owns nothing.
struct MeshArrays {
  const float* positions;     ///< three of each vertex
  const float* normals;       ///< likewise; nullptr: none
  const float* uvs;           ///< two of each vertex; nullptr: none
  const uint32_t* triangles;  ///< three vertices of each
  float side;                 ///< the largest of the bounds
  bool flip;                  ///< whether the geometric normal is the other one than the winding says
};

/// Base of all shapes made of triangles. A subclass fills `mesh_` in its constructor, in object
/// space, then calls finish(). wide::Mesh (kinome/wide/mesh.h) adds interactions by blocks.
class KINOME_EXPORT MeshShape : public Shape {
 public:
  const TriangleMesh* mesh() const override { return &mesh_; }
  Aabb bounds() const override { return bounds_; }
  SurfaceInteraction interaction(const Ray& ray, const Hit& hit) const override;
  float area() const override { return area_; }
  SurfaceInteraction sample_surface(const Vec2& u) const override;
  std::optional<AttributeArrays> attribute(const std::string& name) const override;

  /// Puts other triangles, in world space, in place of its own. Where it has normals, these are
  /// computed from the new positions unless `keep_normals`. For edits: not while anything is
  /// rendered; a scene that has it must be built anew. An Error at `where`, and no change, where
  /// arrays don't fit together; its attributes must still fit, too.
  /// Returns what puts back those that it had.
  std::function<void()> replace_mesh(TriangleMesh mesh, bool keep_normals, const Location& where);

 protected:
  explicit MeshShape(const Properties& props) : Shape(props) {}
  /// Validates the mesh (indices in range, finite positions; Error at `filename` or at the shape) and
  /// applies to_world. Computes angle-weighted normals if the mesh has none, and for vertices whose
  /// normal is zero or not finite, unless face_normals is set, which drops all normals. flip_normals
  /// turns them (and the winding of a mirrored transform is kept consistent). A mesh without faces is
  /// valid; scenes leave it out.
  void finish(const Properties& props, const Transform& to_world, bool face_normals,
              bool flip_normals);
  /// What sample_surface gives for a place on a triangle.
  SurfaceInteraction sampled_at(const Hit& hit) const;
  /// Triangles by area: a single row.
  const GridDistribution& by_area() const;
  /// Once finished.
  MeshArrays arrays() const;
  TriangleMesh mesh_;

 private:
  void measure();
  Aabb bounds_;
  float area_ = 0;
  bool flip_normals_ = false;
  bool flip_geometric_normal_ = false;
  /// Made when the first sample is asked for, as few meshes are.
  struct ByArea {
    std::once_flag made;
    GridDistribution triangles;
  };
  std::unique_ptr<ByArea> by_area_ = std::make_unique<ByArea>();
};

}  // namespace kinome
