#include "kinome/parameter.h"

#include <iterator>

#include "plugin/property_types.h"

namespace kinome {
namespace {

/// Properties of a ParameterType.
struct TypeRow {
  const char* name;
  const char* values;  ///< accepted values
  Quantity quantity = Quantity::kNone;
};
constexpr TypeRow kTypes[] = {  // in the order of ParameterType
    {"boolean", "a boolean"},
    {"integer", "an integer"},
    {"float", "a float"},
    {"string", "a string"},
    {"float or name", "a float or a name"},
    {"file", "a string (a file name)"},
    {"vector", "a vector (point or vector)"},
    {"emission", "a color (rgb, spectrum or float)", Quantity::kEmission},
    {"emission texture", "a texture, color or float", Quantity::kEmission},
    {"reflectance texture", "a texture, color or float", Quantity::kReflectance},
    {"unitless texture", "a texture, color or float", Quantity::kUnitless},
    {"color texture", "a texture, color or float", Quantity::kColor},
    {"volume", "a volume, color or float", Quantity::kReflectance},
    {"transform", "a transform"},
    {"pixels", "an array of pixels"},
    {"object", "an object"}};
static_assert(std::size(kTypes) == static_cast<size_t>(ParameterType::kObject) + 1);

const TypeRow& row_of(ParameterType type) {
  return kTypes[static_cast<size_t>(type)];
}

}  // namespace

const char* to_string(ParameterType type) {
  return row_of(type).name;
}

std::string describe(ParameterType type) {
  return row_of(type).values;
}

Quantity quantity_of(ParameterType type) {
  return row_of(type).quantity;
}

bool takes_texture(ParameterType type) {
  return quantity_of(type) != Quantity::kNone;
}

}  // namespace kinome
