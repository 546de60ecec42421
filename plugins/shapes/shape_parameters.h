#pragma once

#include "kinome/parameter.h"
#include "kinome/properties.h"

/// Parameters that shapes share.
namespace kinome {

inline constexpr Parameter kToWorld{"to_world", ParameterType::kTransform, "identity",
                                    "Transform from object to world space."};
inline constexpr Parameter kFlipNormals{"flip_normals", ParameterType::kBoolean, "false",
                                        "Flip the normals, which swaps inside and outside."};
inline constexpr Parameter kNestedBsdf{"bsdf",  ParameterType::kObject,
                                       nullptr, "BSDF; default: diffuse with reflectance 0.5.",
                                       false,   Category::kBsdf};
inline constexpr Parameter kNestedEmitter{"emitter", ParameterType::kObject,
                                          nullptr,   "Emitter of the surface, such as area.",
                                          false,     Category::kEmitter};
inline constexpr Parameter kNestedSensor{"sensor", ParameterType::kObject,
                                         nullptr,  "An irradiancemeter for this surface.",
                                         false,    Category::kSensor};
inline constexpr Parameter kInterior =
    named_object("interior", Category::kMedium, "Medium inside of the shape; default: none.");
inline constexpr Parameter kExterior =
    named_object("exterior", Category::kMedium, "Medium outside of the shape; default: none.");
/// Objects that are nested in shapes.
#define KINOME_NESTED_IN_SHAPES kNestedBsdf, kNestedEmitter, kNestedSensor, kInterior, kExterior
inline constexpr Parameter kFaceNormals{"face_normals", ParameterType::kBoolean, "false",
                                        "Flat shading, without the normals of vertices."};
inline constexpr Parameter kIgnoredFaceNormals =
    ignored_row("face_normals", ParameterType::kBoolean, "faces are always flat");

/// Reads `to_world` of a shape. Throws Error if it isn't invertible, because normals would be
/// undefined.
inline Transform to_world_of(const Properties& props) {
  const Transform transform = props.transform("to_world");
  if (!transform.is_invertible()) {
    throw props.error("to_world", "must be invertible, got a transform that flattens the shape");
  }
  return transform;
}

}  // namespace kinome
