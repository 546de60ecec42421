#include "kinome/shape_group.h"

#include <functional>

#include "scene/traceable.h"

namespace kinome {

ShapeGroup::ShapeGroup(const Properties& props) : Shape(props) {
  // Parts may have parts, as a merge of merges has. Meshes without faces are left out.
  const std::function<void(const std::shared_ptr<Shape>&)> add = [&](const auto& shape) {
    if (dynamic_cast<const ShapeGroup*>(shape.get())) {
      throw Error(props.where(), "a group of shapes can't be part of another");
    }
    if (dynamic_cast<const ShapeInstance*>(shape.get())) {
      throw Error(props.where(), "a group of shapes can't have instances of another in it");
    }
    const auto parts = shape->parts();
    for (const auto& part : parts) add(part);
    if (parts.empty() && !has_no_surface(*shape)) shapes_.push_back(shape);
  };
  for (const auto& shape : props.objects<Shape>()) add(shape);
  for (const auto& shape : shapes_) {
    if (shape->emitter()) {
      throw Error(props.where(), "a shape of a group can't emit: put lamps into the scene itself");
    }
    if (shape->sensor_pointer()) {
      throw Error(props.where(), "a shape of a group can't measure: there may be many of it");
    }
    bounds_.expand(shape->bounds());
  }
}

}  // namespace kinome
