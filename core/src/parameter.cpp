#include "kinome/parameter.h"

namespace kinome {

const char* to_string(ParameterType type) {
  switch (type) {
    case ParameterType::kBoolean:
      return "boolean";
    case ParameterType::kInteger:
      return "integer";
    case ParameterType::kFloat:
      return "float";
    case ParameterType::kString:
      return "string";
    case ParameterType::kFloatOrName:
      return "float or name";
    case ParameterType::kFile:
      return "file";
    case ParameterType::kVector:
      return "vector";
    case ParameterType::kColor:
      return "color";
    case ParameterType::kTexture:
      return "texture";
    case ParameterType::kUnboundedTexture:
      return "unbounded texture";
    case ParameterType::kTransform:
      return "transform";
    case ParameterType::kObject:
      return "object";
  }
  return "";
}

}  // namespace kinome
