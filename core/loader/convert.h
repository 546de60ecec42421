#pragma once

#include "kinome/properties.h"
#include "loader/node.h"

namespace kinome::loader {

/// The value of a value tag or a transform. `parameter` is the plugin's row of that name, or
/// nullptr: a wavelength spectrum means another colour to a light than to a reflectance. `folders`:
/// where a spectrum's file is looked for.
Properties::Value convert(const Node& node, const Parameter* parameter,
                          const std::vector<std::string>& folders);

/// The operations of a <transform>, the later ones applied after the earlier.
/// Throws Errors: of each operation that is wrong.
Transform convert_transform(const Node& node);

/// Numbers of an attribute, `count` of them or one (then repeated).
Vec3 convert_triple(const Node& node, const Attribute& attribute);
/// A vector from either `value` or x, y and z. `missing`: the value of absent coordinates; nullptr:
/// all three are needed.
Vec3 convert_vector(const Node& node, const float* missing);

}  // namespace kinome::loader
