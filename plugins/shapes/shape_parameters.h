#pragma once

#include "kinome/parameter.h"
#include "kinome/properties.h"

/// Rows that the parameter tables of all shapes have in common.
namespace kinome {

inline constexpr Parameter kToWorld{"to_world", ParameterType::kTransform, "identity",
                                    "From object to world space."};
inline constexpr Parameter kFlipNormals{"flip_normals", ParameterType::kBoolean, "false",
                                        "Turns the outside in: normals point the other way."};
inline constexpr Parameter kNestedBsdf{"bsdf",  ParameterType::kObject,
                                       nullptr, "Material; diffuse 0.5 where there is none.",
                                       false,   Category::kBsdf};
inline constexpr Parameter kNestedEmitter{"emitter", ParameterType::kObject,
                                          nullptr,   "Light that the surface gives off.",
                                          false,     Category::kEmitter};
inline constexpr Parameter kNestedSensor{"sensor", ParameterType::kObject,
                                         nullptr,  "irradiancemeter: measures what arrives here.",
                                         false,    Category::kSensor};
inline constexpr Parameter kFaceNormals{"face_normals", ParameterType::kBoolean, "false",
                                        "Flat shading: normals of vertices are not used."};
inline constexpr Parameter kIgnoredFaceNormals =
    ignored_row("face_normals", ParameterType::kBoolean, "faces are flat in any case");

/// The `to_world` of a shape. Error where it can't be undone, since then there are no normals.
inline Transform to_world_of(const Properties& props) {
  const Transform transform = props.transform("to_world");
  if (!transform.is_invertible()) {
    throw props.error("to_world", "must be invertible, got a transform that flattens the shape");
  }
  return transform;
}

}  // namespace kinome
