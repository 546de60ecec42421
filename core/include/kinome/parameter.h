#pragma once

#include <span>

#include "kinome/object.h"

namespace kinome {

enum class ParameterType {
  kBoolean,
  kInteger,
  kFloat,
  kString,
  kFloatOrName,  ///< a number, or a string that stands for one: `int_ior` as 1.5046 or "bk7"
  kFile,         ///< a string that names a file; resolved against the search paths
  kVector,       ///< three numbers: <point> or <vector>
  kColor,        ///< <rgb>, <spectrum> or <float>: unbounded, for radiance and intensity
  kTexture,      ///< <rgb>, <spectrum>, <float> or a <texture>; uniform values must lie in [0,1]
  kUnboundedTexture,  ///< the same without the bound: roughness, eta, exponents
  kTransform,
  kObject,  ///< a nested object of `category`, whatever name it has
};
KINOME_EXPORT const char* to_string(ParameterType type);

/// One row of a plugin's parameter table: it generates the documentation, checks the scene, and
/// holds the one and only default.
struct Parameter {
  const char* name;
  ParameterType type;
  /// As it would be written in XML ("0.5", "1 0 0", "true"). nullptr: no default; the plugin asks
  /// has() first, or the parameter is required.
  const char* default_value;
  const char* doc;
  bool required = false;
  Category category = Category::kBsdf;  ///< of a kObject
  int max_count = 1;                    ///< of a kObject
};

}  // namespace kinome
