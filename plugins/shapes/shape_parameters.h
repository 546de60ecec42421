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
inline constexpr Parameter kFaceNormals{"face_normals", ParameterType::kBoolean, "false",
                                        "Flat shading: normals of vertices are not used."};

/// The `to_world` of a shape, with a last row of 0 0 0 1. Error where it can't be undone, since
/// then there are no normals.
inline Transform to_world_of(const Properties& props) {
  const Transform transform = props.transform("to_world");
  const Mat4& m = transform.matrix();
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] == 0) {
    throw props.error("to_world", "must be an affine transform, got a projective one");
  }
  if (!transform.is_invertible()) {
    throw props.error("to_world", "must be invertible, got a transform that flattens the shape");
  }
  return m[3][3] == 1 ? transform : Transform(m / m[3][3]);
}

}  // namespace kinome
