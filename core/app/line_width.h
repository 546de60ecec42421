#pragma once

#include <cstddef>
#include <string>

namespace kinome::app {

/// Where lines on stdout are to end: of a terminal, or as COLUMNS says; 0: nowhere.
size_t line_width();

/// `text` with line breaks between words, so that lines have at most `room` characters where words
/// allow it; unchanged if `room` is 0.
std::string wrapped(const std::string& text, size_t room);

}  // namespace kinome::app
