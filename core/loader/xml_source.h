#pragma once

#include <string>
#include <vector>

#include "kinome/error.h"

namespace kinome::loader {

/// Where an XML element stands in its text, as offsets of bytes.
struct SourceElement {
  struct Attribute {
    std::string name;
    size_t begin = 0;        ///< of its name
    size_t value_begin = 0;  ///< between the quotes
    size_t value_end = 0;
    size_t length() const { return value_end - value_begin; }
    Location where = {};  ///< as the parser has it
  };
  std::string tag;
  Location where = {};  ///< as the parser has it
  size_t begin = 0;
  size_t content_begin = 0;  ///< behind its first tag
  size_t content_end = 0;    ///< before its last tag
  size_t end = 0;
  bool is_one_tag = false;  ///< "<x/>"
  std::vector<Attribute> attributes;
  std::vector<SourceElement> children;

  const Attribute* find(std::string_view name) const;
};

/// The root of a text that parse() takes for well-formed.
SourceElement scan_source(const std::string& text, const std::string& file);

/// Text in place of what is in [begin, end).
struct TextPatch {
  size_t begin;
  size_t end;
  std::string text;
};
/// What stands in [begin, end) of a text, with patches in it, none of which overlap.
std::string patched(const std::string& text, size_t begin, size_t end,
                    std::vector<TextPatch> patches);

/// The blanks that a place's line begins with, where nothing else stands before it; otherwise "".
std::string indentation_at(const std::string& text, size_t place);
/// Whether nothing but blanks stands before a place in its line.
bool begins_line(const std::string& text, size_t place);

}  // namespace kinome::loader
