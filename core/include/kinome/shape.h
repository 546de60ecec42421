#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/blocks.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/geometry.h"
#include "kinome/interaction.h"
#include "kinome/medium.h"
#include "kinome/object.h"
#include "kinome/properties.h"
#include "kinome/sensor.h"

namespace kinome {

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

  /// Media on the inside and the outside of the surface (opposite to the geometric normal, and on
  /// its side); nullptr: none. A ray that crosses the surface enters the medium of the other side.
  /// A shape with neither doesn't change the ray's medium.
  const Medium* interior() const { return interior_.get(); }
  const Medium* exterior() const { return exterior_.get(); }
  bool separates_media() const { return interior_ || exterior_; }
  void set_media(std::shared_ptr<const Medium> inside, std::shared_ptr<const Medium> outside) {
    interior_ = std::move(inside), exterior_ = std::move(outside);
  }
  /// Takes the media of another shape.
  void share_media(const Shape& other) { set_media(other.interior_, other.exterior_); }

  /// Returns the attribute of this name, or nullopt if there is none. Only meshes have attributes.
  virtual std::optional<AttributeArrays> attribute(const std::string& /*name*/) const {
    return std::nullopt;
  }
  /// Names of the attributes that the textures of its BSDF and emitter read, without duplicates.
  std::vector<std::string> requested_attributes() const;

 protected:
  /// Leaves BSDF, emitter and sensor empty.
  Shape() = default;
  /// Takes the nested BSDF, emitter, sensor and media from `props`. The loader sets a missing BSDF.
  explicit Shape(const Properties& props);

 private:
  std::shared_ptr<Bsdf> bsdf_;
  std::shared_ptr<Emitter> emitter_;
  std::shared_ptr<Sensor> sensor_;
  std::shared_ptr<const Medium> interior_, exterior_;
};

}  // namespace kinome
