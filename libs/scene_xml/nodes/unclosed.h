#pragma once

#include <optional>
#include <string>

namespace kinome::loader {

/// Returns the offset of the first tag from `at` on, past text, comments and other markup, or npos.
size_t next_tag(const std::string& text, size_t at);

/// An element whose end tag is missing.
struct UnclosedElement {
  std::string tag;
  size_t begin = 0;  ///< offset of its '<'
};

/// Returns the innermost element that is open at offset `end` of an XML text; nullopt if none is.
std::optional<UnclosedElement> innermost_open_element(const std::string& text, size_t end);

}  // namespace kinome::loader
