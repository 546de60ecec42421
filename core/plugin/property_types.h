#pragma once

#include <optional>
#include <string>

#include "kinome/properties.h"

namespace kinome {

/// Returns the name of a value's type in scenes, with its article: "an integer", "a bsdf".
std::string describe(const Properties::Value& value);
/// Returns the name of the accepted values: "an integer", "a color (rgb, spectrum or float)".
std::string describe(ParameterType type);
/// The same for a parameter; for a kObject, its category.
std::string describe(const Parameter& parameter);
/// Returns true if a parameter of `type` accepts the value.
bool accepts(ParameterType type, const Properties::Value& value);
/// The same for a parameter; a kObject accepts only objects of its category.
bool accepts(const Parameter& parameter, const Properties::Value& value);

/// Converts a number, colour or vector to a colour; returns nullopt for other types.
std::optional<UniformColor> as_uniform_color(const Properties::Value& value);
/// Parses the parameter's default value. Throws std::logic_error if it is invalid, which is a bug
/// of the plugin.
Properties::Value parse_default(const Parameter& parameter);

/// Returns the category of an object's interface.
Category category_of(const Object& object);

}  // namespace kinome
