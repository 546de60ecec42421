#pragma once

#include <string>

#include "kinome/properties.h"

namespace kinome::loader {

/// The shortest that is read as the same number.
std::string written_number(double value);
/// Three of them, with commas between.
std::string written_triple(const Vec3& value);
/// With what XML wants escaped in an attribute, whichever quotes that has.
std::string escaped(const std::string& text);
/// Throws Error where a text has a $, which a scene file takes for the beginning of a name.
void expect_no_name(const std::string& text, const Location& where);
/// The text escaped, as an attribute says it. Throws Error as above.
std::string said_text(const std::string& text, const Location& where);
/// The element that gives a parameter its value, so that reading it gives the same bits:
/// <float name="alpha" value="0.1"/>. `row`: of the parameter, if known. Not of images and objects.
std::string value_element(const std::string& name, const Properties::Value& value,
                          const Parameter* row);

}  // namespace kinome::loader
