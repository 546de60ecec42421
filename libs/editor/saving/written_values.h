#pragma once

#include <string>

#include "kinome/properties.h"

namespace kinome::loader {

/// Returns the shortest text that is read as the same number.
std::string written_number(double value);
/// Returns three such numbers, separated by commas.
std::string written_triple(const Vec3& value);
/// Escapes a text for an XML attribute with either kind of quotes.
std::string escaped(const std::string& text);
/// Throws Error if a text has a $, which begins a name in scene files and can't be escaped.
void expect_no_name(const std::string& text, const Location& where);
/// Returns the escaped text of an attribute. Throws Error if it has a $.
std::string attribute_text(const std::string& text, const Location& where);
/// Returns the element that sets a parameter, such as <float name="alpha" value="0.1"/>. Reading it
/// gives the same bits. `row` describes the parameter, if known. Returns "" for images and objects.
std::string value_element(const std::string& name, const Properties::Value& value,
                          const Parameter* row);

}  // namespace kinome::loader
