#include "kinome/shape_group.h"

#include <functional>

#include "scene/traceable.h"

namespace kinome {

ShapeGroup::ShapeGroup(const Properties& props) : Shape(props) {
  // Add parts recursively, because a merge may contain merges. Meshes without faces are left out.
  const std::function<void(const std::shared_ptr<Shape>&)> add = [&](const auto& shape) {
    if (dynamic_cast<const ShapeGroup*>(shape.get())) {
      throw Error(props.where(), "a group of shapes can't be part of another group");
    }
    if (dynamic_cast<const ShapeInstance*>(shape.get())) {
      throw Error(props.where(), "a group of shapes can't contain instances");
    }
    const auto parts = shape->parts();
    for (const auto& part : parts) add(part);
    if (parts.empty() && !has_no_surface(*shape)) shapes_.push_back(shape);
  };
  for (const auto& shape : props.objects<Shape>()) add(shape);
  for (const auto& shape : shapes_) {
    if (shape->emitter()) {
      throw Error(props.where(),
                  "a shape of a group can't emit: move shapes with emitters into the scene");
    }
    if (shape->sensor_pointer()) {
      throw Error(props.where(),
                  "a shape of a group can't have a sensor, because it may have many instances");
    }
    bounds_.expand(shape->bounds());
  }
}

}  // namespace kinome
