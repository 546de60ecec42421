#pragma once

#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome::loader {

/// Position of an XML element in its text, as byte offsets.
struct SourceElement {
  struct Attribute {
    std::string name;
    size_t begin = 0;        ///< beginning of the name
    size_t value_begin = 0;  ///< after the opening quote
    size_t value_end = 0;    ///< before the closing quote
    size_t length() const { return value_end - value_begin; }
    Location where = {};  ///< same as the parser's
  };
  std::string tag;
  Location where = {};  ///< same as the parser's
  size_t begin = 0;
  size_t content_begin = 0;  ///< after the start tag
  size_t content_end = 0;    ///< before the end tag
  size_t end = 0;
  bool is_one_tag = false;  ///< "<x/>"
  std::vector<Attribute> attributes;
  std::vector<SourceElement> children;

  const Attribute* find(std::string_view name) const;
};

/// Returns the root element of a text that parse() has accepted.
SourceElement scan_source(const std::string& text, const std::string& file);

/// Replacement for the text in [begin, end).
struct TextPatch {
  size_t begin;
  size_t end;
  std::string text;
};
/// Returns [begin, end) of a text after applying patches, which must not overlap.
std::string patched(const std::string& text, size_t begin, size_t end,
                    std::vector<TextPatch> patches);

/// Returns the blanks between the beginning of the line and `offset`; "" if there is other text.
std::string indentation_at(const std::string& text, size_t offset);
/// Returns true if only blanks precede `offset` in its line.
bool begins_line(const std::string& text, size_t offset);

}  // namespace kinome::loader
