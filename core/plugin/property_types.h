#pragma once

#include <optional>
#include <string>

#include "kinome/properties.h"

namespace kinome {

/// What a value is in the scene language, with its article: "an integer", "a bsdf".
std::string describe(const Properties::Value& value);
/// What a parameter takes: "an integer", "a color (rgb, spectrum or float)".
std::string describe(ParameterType type);
/// Whether a getter of `type` takes the value.
bool accepts(ParameterType type, const Properties::Value& value);

/// A number, colour or vector as a colour; nullopt for anything else.
std::optional<UniformColor> as_uniform_color(const Properties::Value& value);
/// The value that a table's default string stands for; std::logic_error where it is none, since
/// tables are code.
Properties::Value parse_default(const Parameter& parameter);

/// The interface that an object implements.
Category category_of(const Object& object);

}  // namespace kinome
