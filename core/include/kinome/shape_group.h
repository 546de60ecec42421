#pragma once

#include <memory>
#include <vector>

#include "kinome/shape.h"

namespace kinome {

/// Shapes that a scene doesn't show by themselves, but wherever a ShapeInstance places them. The
/// ray tracer has one tree of them, however many instances there are.
class KINOME_EXPORT ShapeGroup : public Shape {
 public:
  /// Of the nested shapes, or of what stands in their place (Shape::parts). Error where there are
  /// none, where one emits, or is a group or an instance itself.
  explicit ShapeGroup(const Properties& props);

  const std::vector<std::shared_ptr<Shape>>& shapes() const { return shapes_; }

  Aabb bounds() const override { return bounds_; }
  // No ray meets it, nor is it sampled.
  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 private:
  std::vector<std::shared_ptr<Shape>> shapes_;
  Aabb bounds_;
};

/// A place for a group's shapes. In the scene its parts stand for it, one for each of the group's
/// shapes, in their order: rays that meet it are told the part.
class KINOME_EXPORT ShapeInstance : public Shape {
 public:
  virtual const ShapeGroup& group() const = 0;
  /// From the group's space to world space.
  virtual const Mat4& to_world() const = 0;

  SurfaceInteraction interaction(const Ray&, const Hit&) const override { return {}; }
  float area() const override { return 0; }
  SurfaceInteraction sample_surface(const Vec2&) const override { return {}; }

 protected:
  using Shape::Shape;
};

}  // namespace kinome
