#pragma once

#include <memory>
#include <vector>

#include "kinome/shape.h"

namespace kinome {

/// Shapes that are visible only where a ShapeInstance places them. The ray tracer builds one
/// acceleration structure for all instances.
class KINOME_EXPORT ShapeGroup : public Shape {
 public:
  /// Takes the nested shapes, or their parts (Shape::parts()). Throws Error if there are none, or
  /// one of them is an emitter, a group or an instance.
  explicit ShapeGroup(const Properties& props);

  const std::vector<std::shared_ptr<Shape>>& shapes() const { return shapes_; }

  Aabb bounds() const override { return bounds_; }
  // Never called, because no ray hits a group and it is not sampled.
  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 private:
  std::vector<std::shared_ptr<Shape>> shapes_;
  Aabb bounds_;
};

/// Placement of a group's shapes. In the scene it is replaced by its parts, one for each of the
/// group's shapes and in their order. A hit refers to the part.
class KINOME_EXPORT ShapeInstance : public Shape {
 public:
  virtual const ShapeGroup& group() const = 0;
  /// Transform from the group's space to world space.
  virtual const Mat4& to_world() const = 0;

  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 protected:
  using Shape::Shape;
};

}  // namespace kinome
