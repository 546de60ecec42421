#pragma once

#include <string>

#include "kinome/properties.h"

namespace kinome::loader {

/// With what XML wants escaped in an attribute.
std::string escaped(const std::string& text);
/// The element that gives a parameter its value, so that reading it gives the same bits:
/// <float name="alpha" value="0.1"/>. `row`: of the parameter, if known. Not of images and objects.
std::string value_element(const std::string& name, const Properties::Value& value,
                          const Parameter* row);

}  // namespace kinome::loader
