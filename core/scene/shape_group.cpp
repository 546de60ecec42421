#include "kinome/shape_group.h"

namespace kinome {

ShapeGroup::ShapeGroup(const Properties& props) : Shape(props) {
  for (const auto& nested : props.objects<Shape>()) {
    if (dynamic_cast<const ShapeGroup*>(nested.get())) {
      throw Error(props.where(), "a group of shapes can't be part of another");
    }
    if (dynamic_cast<const ShapeInstance*>(nested.get())) {
      throw Error(props.where(), "a group of shapes can't have instances of another in it");
    }
    const auto parts = nested->parts();
    if (parts.empty()) {
      shapes_.push_back(nested);
    } else {
      shapes_.insert(shapes_.end(), parts.begin(), parts.end());
    }
  }
  if (shapes_.empty()) throw Error(props.where(), "a group of shapes must have at least one");
  for (const auto& shape : shapes_) {
    if (dynamic_cast<const ShapeInstance*>(shape.get())) {
      throw Error(props.where(), "a group of shapes can't have instances of another in it");
    }
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
