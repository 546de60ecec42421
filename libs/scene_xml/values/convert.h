#pragma once

#include "kinome/properties.h"
#include "scene_xml/nodes/node.h"

namespace kinome::loader {

/// Converts a value tag or a transform. `parameter` describes the plugin's parameter, or is
/// nullptr; a spectrum gives different colours as emission and as reflectance. A spectrum's file is
/// searched for in `folders`.
Properties::Value convert(const Node& node, const Parameter* parameter,
                          const std::vector<std::string>& folders);

/// Converts a <transform>, whose operations are applied in their order. Throws Errors with an error
/// for each invalid operation.
Transform convert_transform(const Node& node);

/// Converts an attribute of three numbers, or of one that is repeated.
Vec3 convert_triple(const Node& node, const Attribute& attribute);
/// Converts a vector from either `value` or x, y and z. `missing` is the value of absent
/// coordinates; nullptr makes all three mandatory.
Vec3 convert_vector(const Node& node, const float* missing);

}  // namespace kinome::loader
