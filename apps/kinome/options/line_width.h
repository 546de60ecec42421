#pragma once

#include <cstddef>
#include <string>

namespace kinome::app {

/// Returns the maximum length of lines on stdout: COLUMNS, or the terminal's width; 0 if unlimited.
size_t line_width();

/// Returns `text` with line breaks between words, so that lines have at most `width` characters
/// unless a word is longer; unchanged if `width` is 0.
std::string wrapped(const std::string& text, size_t width);

}  // namespace kinome::app
