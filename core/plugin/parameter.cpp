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
    case ParameterType::kEmission:
      return "emission";
    case ParameterType::kEmissionTexture:
      return "emission texture";
    case ParameterType::kReflectanceTexture:
      return "reflectance texture";
    case ParameterType::kUnitlessTexture:
      return "unitless texture";
    case ParameterType::kColorTexture:
      return "color texture";
    case ParameterType::kTransform:
      return "transform";
    case ParameterType::kImage:
      return "pixels";
    case ParameterType::kObject:
      return "object";
  }
  return "";
}

Quantity quantity_of(ParameterType type) {
  switch (type) {
    case ParameterType::kEmission:
    case ParameterType::kEmissionTexture:
      return Quantity::kEmission;
    case ParameterType::kReflectanceTexture:
      return Quantity::kReflectance;
    case ParameterType::kUnitlessTexture:
      return Quantity::kUnitless;
    case ParameterType::kColorTexture:
      return Quantity::kColor;
    default:
      return Quantity::kNone;
  }
}

bool takes_texture(ParameterType type) {
  return quantity_of(type) != Quantity::kNone;
}

}  // namespace kinome
