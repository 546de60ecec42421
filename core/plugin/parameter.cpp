#include "kinome/parameter.h"

#include <iterator>

namespace kinome {

const char* to_string(ParameterType type) {
  constexpr const char* kTypeNames[] = {"boolean",
                                        "integer",
                                        "float",
                                        "string",
                                        "float or name",
                                        "file",
                                        "vector",
                                        "emission",
                                        "emission texture",
                                        "reflectance texture",
                                        "unitless texture",
                                        "color texture",
                                        "transform",
                                        "pixels",
                                        "object"};
  static_assert(std::size(kTypeNames) == static_cast<size_t>(ParameterType::kObject) + 1);
  return kTypeNames[static_cast<size_t>(type)];
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
